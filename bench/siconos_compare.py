#!/usr/bin/python3
"""Steps of our scenes solved by Siconos and by Lockstep to the same tolerances, each from zero, as CSV. Installs Debian's
python3-siconos and python3-h5py where they are missing (as root).
    bench/siconos_compare.py > bench/results/MACHINE/siconos.csv
residual and natural_map are measured by Lockstep, of the impulses of either (docs/reference/error_measures.md); seconds are those
of one solve, by each program's own clock."""
import json
import pathlib
import subprocess
import sys
import tempfile

try:
    import h5py
    import siconos_solve
except ImportError:
    install = "apt-get install -qq -y --no-install-recommends python3-siconos python3-h5py"
    subprocess.run(install.split(), stdout=sys.stderr, check=True)
    import h5py
    import siconos_solve

LOCKSTEP = pathlib.Path(__file__).resolve().parent.parent / "build/release/lockstep"
STEPS = [("spheres_small", 90), ("incline", 40), ("box_stack", 40), ("mass_ratio", 20), ("card_house", 20)]


def lockstep(*arguments):
    """Status 1 says that a tolerance was not reached; the report is there all the same."""
    status = subprocess.run([LOCKSTEP, *map(str, arguments), "--quiet"], stderr=subprocess.PIPE).returncode
    if status > 1:
        sys.exit(f"lockstep {' '.join(map(str, arguments))} ended with status {status}")


def main():
    print("problem,contacts,program,solver,tolerance,solved,iterations,seconds,residual,natural_map")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        text, file, report = folder / "p.dat", folder / "p.hdf5", folder / "report.json"

        def solve(problem, solver, tolerance, *more):
            lockstep("solve", problem, "--solver", solver, "--tolerance", tolerance, "--seconds", 10, "--report", report,
                     *more)
            return json.loads(report.read_text())

        for scene, at in STEPS:
            for path in (text, file):
                lockstep("export", scene, "--at", at, "--device", "reference", "-o", path)

            def row(figures, program, solver, tolerance, solved, iterations, seconds, residual, natural_map):
                print(f"{scene} {at},{figures['contacts']},{program},{solver},{tolerance:g},{int(solved)},{iterations},"
                      f"{seconds:.6f},{residual:.3g},{natural_map:.3g}", flush=True)

            for tolerance in (1e-4, 1e-8):
                for solver in siconos_solve.SOLVERS:
                    r, solved, iterations, _, seconds = siconos_solve.solve(str(text), solver, tolerance)
                    with h5py.File(file, "r+") as stored:
                        stored["solution/r"][...] = r.reshape(stored["solution/r"].shape)
                    f = solve(file, "nsgs", 1, "--iterations", 1)  # for what it says of the impulses that are stored
                    row(f, "siconos", solver, tolerance, solved, iterations, seconds, f["stored_residual"],
                        f["stored_natural_map"])
                for solver in ("nsgs", "admm", "newton", "auto"):
                    f = solve(text, solver, tolerance)
                    row(f, "lockstep", solver, tolerance, f["converged"], f["iterations"], f["seconds"], f["residual"],
                        f["natural_map"])


main()
