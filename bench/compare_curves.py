#!/usr/bin/env python3
"""Compares what an error costs by two programs: compare_curves.py OLD.csv NEW.csv

Both files are of `lockstep bench`, taken on one machine that did nothing else. For each case, precision and quantity the
best trials of OLD, those that nothing of OLD beats in both error and time, are held against NEW: how long NEW's fastest
trial takes that errs by no more than 1.05 times as much, in parts of OLD's time. Below 1 NEW is faster; "none": no trial
of NEW is as good. Errors below --floor (1e-9) count as that. With --shared settings that one file lacks are left out, so
that files of runs which were ended can be compared.
"""
import argparse
import csv
import math
import statistics


def setting(row):
    return tuple(row[key] for key in ("case", "device", "precision", "method", "dt_s", "substeps", "sweeps"))


def curves(rows, floor):
    found = {}
    for row in rows:
        if row["failure"] or not row["error"]:
            continue
        error = float(row["error"])
        if math.isfinite(error):
            trial = (max(abs(error), floor), float(row["ms_per_second"]), row["method"])
            found.setdefault((row["case"], row["device"], row["precision"], row["quantity"]), []).append(trial)
    return found


def best(trials):
    """Those that no other is at least as good as in both."""
    front = []
    for error, time, method in sorted(trials, key=lambda trial: (trial[1], trial[0])):
        if not front or error < front[-1][0]:
            front.append((error, time, method))
    return front


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=argparse.FileType())
    parser.add_argument("new", type=argparse.FileType())
    parser.add_argument("--floor", type=float, default=1e-9)
    parser.add_argument("--shared", action="store_true")
    options = parser.parse_args()
    files = [list(csv.DictReader(file)) for file in (options.old, options.new)]
    if options.shared:
        shared = set(map(setting, files[0])) & set(map(setting, files[1]))
        files = [[row for row in rows if setting(row) in shared] for rows in files]
    old, new = [curves(rows, options.floor) for rows in files]
    everything = []
    for key in sorted(old.keys() & new.keys()):
        front = best(old[key])
        ratios = []
        for error, time, method in front:
            times = [t for e, t, _ in new[key] if e <= 1.05 * error]
            ratios.append((min(times) / time if times else math.inf, error, method))
        worst = max(ratios)
        everything += [ratio for ratio, *_ in ratios]
        told = "none" if worst[0] == math.inf else f"{worst[0]:.2f}"
        print(f"{' '.join(key[:3])}, {key[3]}: median {statistics.median(r for r, *_ in ratios):.2f} of {len(ratios)}, "
              f"worst {told} at an error of {worst[1]:.2g} ({worst[2]})")
    print(f"{len(everything)} trials: median {statistics.median(everything):.2f}, "
          f"{sum(r > 1.2 for r in everything)} slower by more than a fifth, {sum(r == math.inf for r in everything)} as good by none"
          if everything else "nothing in both files")


if __name__ == "__main__":
    main()
