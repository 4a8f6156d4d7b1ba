#!/usr/bin/env python3
"""Compares the errors that two `lockstep bench` runs found, on two machines say: same_errors.py A.csv B.csv

Bit-exact devices give the same. Rows are of one trial and one quantity; those that only one file has are counted.
"""
import csv
import sys


def errors(path):
    trial = ("case", "precision", "method", "dt_s", "substeps", "sweeps", "quantity")
    with open(path) as file:
        return {tuple(row[key] for key in trial): row["error"] for row in csv.DictReader(file)}


if len(sys.argv) != 3:
    sys.exit(__doc__)
a, b = (errors(path) for path in sys.argv[1:])
both = a.keys() & b.keys()
differ = sorted(key for key in both if a[key] != b[key])
for key in differ:
    print(*key, a[key], b[key])
print(f"{len(both)} rows in both, {len(differ)} differ; {len(a) - len(both)} and {len(b) - len(both)} in one only")
sys.exit(1 if differ else 0)
