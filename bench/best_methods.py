#!/usr/bin/env python3
"""Says which method is how far from the best curve of speed against error: best_methods.py TABLE.csv...

The tables are of `lockstep bench`. For each case, precision and quantity the best trials of all methods, those that
nothing beats in both error and time, are the curve. A method's factor is how long its fastest trial takes that errs by
no more than 1.05 times as much as a point of the curve, in parts of the point's time: the median over the points that it
reaches, with how many of them it does. Errors below --floor (1e-9) count as that.
"""
import argparse
import csv
import statistics

from compare_curves import best, curves

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("tables", nargs="+", type=argparse.FileType())
parser.add_argument("--floor", type=float, default=1e-9)
options = parser.parse_args()
found = curves([row for table in options.tables for row in csv.DictReader(table)], options.floor)
factors_of = {}
for (case, device, precision, quantity), trials in sorted(found.items()):
    front = best(trials)
    parts = []
    for method in sorted({method for _, _, method in trials}):
        own = [(error, time) for error, time, its in trials if its == method]
        reached = [[t / time for e, t in own if e <= 1.05 * error] for error, time, _ in front]
        factors = [min(times) for times in reached if times]
        name = " ".join(method.split())
        if factors:
            parts.append(f"{name} {statistics.median(factors):.2f} ({len(factors)} of {len(front)})")
            factors_of.setdefault(name, []).append((statistics.median(factors), len(factors) / len(front)))
        else:
            parts.append(f"{name} none")
    print(f"{case}, {precision}, {quantity}: " + ", ".join(parts))
print()
for name, factors in sorted(factors_of.items()):
    print(
        f"{name}: median {statistics.median(f for f, _ in factors):.2f} over {len(factors)} curves, "
        f"reaches {statistics.mean(r for _, r in factors):.0%} of their points"
    )
