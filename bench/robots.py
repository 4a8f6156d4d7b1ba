"""Which robots of a folder load, and with which line the others are refused; a table in Markdown with --table FILE.

    PYTHONPATH=build/release/python python3 bench/robots.py [FOLDER...] [--approximate] [--table FILE]

Without a folder that of MENAGERIE_ROOT. Where the package mujoco is installed, and loads a file too, the mass, the centre
and the principal moments of each body are held against its: the largest relative difference. Bodies with several joints,
whose links share their mass, count with the sum of all masses only."""
import argparse
import collections
import os
import re
import sys
import warnings

import lockstep
import numpy

try:
    import mujoco
except ImportError:
    mujoco = None

def robots_of(folder):
    for root, _, files in sorted(os.walk(folder)):
        for name in sorted(files):
            path = os.path.join(root, name)
            if name.endswith(".urdf"):
                yield path
            elif name.endswith(".xml"):
                with open(path, errors="replace") as file:
                    if "<mujoco" in file.read():
                        yield path


def loaded(path, approximate):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return lockstep.World.load(path, precision="double", device="reference", approximate=approximate)


def difference(world, path):
    """The largest relative difference to MuJoCo's bodies, where each of Lockstep's is one of them; else why not."""
    try:
        model = mujoco.MjModel.from_xml_path(path)
    except Exception:
        return "MuJoCo refuses it"
    data = mujoco.MjData(model)
    for joint in range(model.njnt):  # what stands beyond its limits starts on them here
        if model.jnt_limited[joint] and model.jnt_type[joint] >= int(mujoco.mjtJoint.mjJNT_SLIDE):
            at = model.jnt_qposadr[joint]
            data.qpos[at] = numpy.clip(data.qpos[at], *model.jnt_range[joint])
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    ours = sum(world.mass(body) for body in world.bodies)
    moving = [i for i in range(model.nbody) if model.body_weldid[i] != 0]
    theirs = sum(model.body_mass[i] for i in moving)
    worst = abs(ours - theirs) / theirs if theirs > 0 else 0
    heads = collections.defaultdict(list)
    for i in moving:
        heads[model.body_weldid[i]].append(i)
    names = {world.name(body).split("/", 1)[1]: row for row, body in enumerate(world.bodies)}
    poses = world.poses()
    for head, members in heads.items():
        name = model.body(head).name
        if name not in names:
            continue
        body = world.bodies[names[name]]
        masses = model.body_mass[members]
        if masses.sum() == 0:
            continue
        if any(other.startswith(name + ".") for other in names):
            continue  # several joints in a body: helper links have a part of it
        centre = masses @ data.xipos[members] / masses.sum()
        inertia = numpy.zeros((3, 3))
        for i in members:
            axes = data.ximat[i].reshape(3, 3)
            arm = data.xipos[i] - centre
            inertia += axes @ numpy.diag(model.body_inertia[i]) @ axes.T
            inertia += model.body_mass[i] * (arm @ arm * numpy.eye(3) - numpy.outer(arm, arm))
        moments = numpy.sort(numpy.linalg.eigvalsh(inertia))
        size = max(1, numpy.abs(centre).max())
        worst = max(worst, abs(world.mass(body) - masses.sum()) / masses.sum(),
                    numpy.abs(poses[names[name]][:3] - centre).max() / size,
                    numpy.abs(numpy.sort(world.inertia(body)) - moments).max() / moments.max())
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", metavar="FOLDER")
    parser.add_argument("--approximate", action="store_true")
    parser.add_argument("--table", metavar="FILE")
    arguments = parser.parse_args()
    folders = arguments.folders or [os.environ.get("MENAGERIE_ROOT", "")]
    if not all(os.path.isdir(folder) for folder in folders):
        sys.exit("no such folder; name one, or set MENAGERIE_ROOT")
    rows, refusals = [], collections.Counter()
    for folder in folders:
        for path in robots_of(folder):
            name = os.path.relpath(path, folder)
            try:
                world = loaded(path, arguments.approximate)
            except lockstep.Error as error:
                line = str(error).replace(os.path.abspath(folder) + os.sep, "").replace(folder + os.sep, "")
                rows.append((name, "refused", line))
                refusals[re.sub(r'"[^"]*"|-?\d[-+.e\d]*', "*", line.split(": ", 1)[-1])[:100]] += 1
                continue
            same = ""
            if mujoco:
                off = difference(world, path)
                same = off if isinstance(off, str) else f"masses, centres and moments differ by {off:.1e}"
            rows.append((name, "loaded", same))
    for row in rows:
        print("%-55s %-8s %s" % row)
    count = sum(row[1] == "loaded" for row in rows)
    print(f"\n{count} of {len(rows)} load")
    for line, times in refusals.most_common():
        print(f"{times:4d} {line}")
    if arguments.table:
        with open(arguments.table, "w") as file:
            file.write(f"{count} of {len(rows)} load.\n\n| file | | |\n|---|---|---|\n")
            for name, verdict, line in rows:
                file.write(f"| `{name}` | {verdict} | {line.replace('|', '/')} |\n")


main()
