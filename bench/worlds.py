#!/usr/bin/env python3
"""Worlds a second over the size of a batch and the number of ranks: a CSV.

    bench/worlds.py > bench/results/MACHINE/worlds.csv
    bench/worlds.py --device gpu --scenes rag_doll --worlds 1 1024 --ranks 1

Each row is one run of `lockstep run SCENE --worlds N`, under mpirun where ranks are more than one; times are the
median of the steps of the slowest rank.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--program", default="build/release/lockstep")
parser.add_argument("--device", default="auto")
parser.add_argument("--scenes", nargs="+", default=["rag_doll", "box_stack", "mixed_spheres"])
parser.add_argument("--worlds", nargs="+", type=int, default=[1, 4, 16, 64, 256, 1024])
parser.add_argument("--ranks", nargs="+", type=int, default=[1, 2])
parser.add_argument("--steps", type=int, default=60)
options = parser.parse_args()

environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
columns = "scene,device,precision,ranks,worlds,bodies,steps,ms_per_step,world_steps_per_second,body_steps_per_second,state_hash"
print(columns, flush=True)
hashes = {}
for scene in options.scenes:
    for worlds in options.worlds:
        for ranks in options.ranks:
            if ranks > worlds:
                continue
            with tempfile.TemporaryDirectory() as folder:
                path = os.path.join(folder, "report.json")
                command = [options.program, "run", scene, "--worlds", str(worlds), "--steps", str(options.steps)]
                command += ["--device", options.device, "--quiet", "--report", path]
                if ranks > 1:
                    command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks)] + command
                subprocess.run(command, check=True, env=environment)
                with open(path) as file:
                    r = json.load(file)
            per_second = 1e3 / r["ms_per_step_median"]
            print(
                f"{scene},{r['device']},{r['precision']},{ranks},{worlds},{r['bodies']},{r['steps']},{r['ms_per_step_median']:.4f},"
                f"{worlds * per_second:.1f},{r['bodies'] * per_second:.4g},{r['state_hash']}",
                flush=True,
            )
            if hashes.setdefault((scene, worlds), r["state_hash"]) != r["state_hash"]:
                sys.exit(f"{scene}: {worlds} worlds have other bits on {ranks} ranks")
