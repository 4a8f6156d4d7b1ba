#!/usr/bin/python3
"""Solves a frictional contact problem in a text file with Siconos (Debian: python3-siconos).
    bench/siconos_solve.py PROBLEM.dat nsgs|admm|nsn_ac TOLERANCE IMPULSES
Writes the impulses, one number a line, normal and two tangents of each contact, and prints a line: 1 where it was solved,
iterations, Siconos's own error (the natural map over the largest of |q|, |r| and |u|),
seconds."""
import sys
import time

import numpy
import siconos.numerics as numerics

# and how many iterations they get
SOLVERS = {
    "nsgs": (numerics.SICONOS_FRICTION_3D_NSGS, 100000),
    "admm": (numerics.SICONOS_FRICTION_3D_ADMM, 100000),
    "nsn_ac": (numerics.SICONOS_FRICTION_3D_NSN_AC, 1000),
}


def solve(path, solver, tolerance):
    """Impulses, whether they were found, iterations, Siconos's error, seconds."""
    problem = numerics.frictionContact_new_from_filename(path)
    identifier, iterations = SOLVERS[solver]
    options = numerics.SolverOptions(identifier)
    options.dparam[numerics.SICONOS_DPARAM_TOL] = tolerance
    options.iparam[numerics.SICONOS_IPARAM_MAX_ITER] = iterations
    r = numpy.zeros(3 * problem.numberOfContacts)
    u = numpy.zeros_like(r)
    start = time.perf_counter()
    info = numerics.fc3d_driver(problem, r, u, options)
    seconds = time.perf_counter() - start
    iterations = options.iparam[numerics.SICONOS_IPARAM_ITER_DONE]
    return r, info == 0, iterations, options.dparam[numerics.SICONOS_DPARAM_RESIDU], seconds


if __name__ == "__main__":
    impulses, solved, count, error, duration = solve(sys.argv[1], sys.argv[2], float(sys.argv[3]))
    numpy.savetxt(sys.argv[4], impulses, fmt="%.17g")
    print(int(solved), count, f"{error:.17g}", f"{duration:.6f}")
