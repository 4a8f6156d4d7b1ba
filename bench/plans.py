#!/usr/bin/env python3
"""What a step takes by each plan of its sub-steps (`--plan`), on a CPU device, on a machine that does nothing else:
    bench/plans.py [--program FILE] [--steps N] [--repetitions N] OUT.csv
Each repetition runs all plans of a scene in turn; OUT.csv gets the medians, ms, and how many times as fast as one thread
each plan is. Scenes of up to 16 bodies are compared with the reference, which takes them by `--device auto`. Whether all
plans have one state hash is checked."""
import argparse
import csv
import json
import statistics
import subprocess
import sys
import tempfile

CPU = ["--device", "cpu"]
LARGE = {
    "one thread": CPU + ["--threads", "1", "--plan", "launches"],
    "launches": CPU + ["--plan", "launches"],
    "all groups": CPU + ["--plan", "all_groups"],
}
SMALL = {"device": CPU, "reference": ["--device", "reference"]}
SCENES = {
    "box_heap": LARGE, "spheres8000": LARGE, "pyramid100": LARGE, "wall": LARGE, "mixed_spheres": LARGE,
    "slide_to_roll": SMALL, "two_cubes": SMALL, "box_stack": SMALL, "rag_doll": SMALL,
}


def step_ms(program, scene, options, steps):
    with tempfile.NamedTemporaryFile(suffix=".json") as report:
        subprocess.run([program, "run", scene, "--steps", str(steps), "--quiet", "--report", report.name, *options],
                       check=True)
        values = json.load(open(report.name))
    return values["ms_per_step_median"], values["state_hash"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/release/lockstep")
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("out")
    options = parser.parse_args()
    with open(options.out, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["scene", "plan", "ms_per_step", "times_as_fast_as_the_first"])
        for scene, plans in SCENES.items():
            for arguments in plans.values():  # builds what is missing
                step_ms(options.program, scene, arguments, 2)
            times = {plan: [] for plan in plans}
            hashes = set()
            for _ in range(options.repetitions):
                for plan, arguments in plans.items():
                    ms, state = step_ms(options.program, scene, arguments, options.steps)
                    times[plan].append(ms)
                    hashes.add(state)
            if len(hashes) != 1:
                sys.exit(f"{scene}: plans differ in their bits: {hashes}")
            first = statistics.median(next(iter(times.values())))
            for plan, of_plan in times.items():
                ms = statistics.median(of_plan)
                table.writerow([scene, plan, f"{ms:.4g}", f"{first / ms:.2f}"])
                print(f"{scene:14} {plan:12} {ms:8.4g} ms  {first / ms:.2f}")
            file.flush()


if __name__ == "__main__":
    main()
