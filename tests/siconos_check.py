#!/usr/bin/python3
"""Measures a solution of a frictional contact problem by means that share nothing with Lockstep: its own reader, its own
measure, and Siconos's error functions (Debian: python3-siconos).
    tests/siconos_check.py PROBLEM SOLUTION           the solution of `lockstep solve --solution`, as text
    tests/siconos_check.py PROBLEM --solve SOLUTION   solves by Siconos instead, and writes the impulses for --guess
Prints one line of JSON:
    equations  how far v and u are from M v = f + H r + G l, u = H^T v + w, G^T v + b = 0 (or u = W r + V l + q), against
               the size of what they add
    laws       rms over the contacts of the defect of Coulomb's law and that of rolling, in velocities, against rms |q|
    siconos    Siconos's own error, where it has a function for this kind of problem
Files of HDF5 need h5py."""
import json
import sys

import numpy


class Matrix:
    """Entries by row, column, value."""

    def __init__(self, rows, columns, i, j, x):
        self.shape = (rows, columns)
        self.i, self.j, self.x = numpy.array(i, int), numpy.array(j, int), numpy.array(x, float)

    def __matmul__(self, vector):
        return numpy.bincount(self.i, self.x * vector[self.j], self.shape[0]) if self.x.size else numpy.zeros(self.shape[0])

    def size_of(self, vector):
        """Of what its product with a vector adds up, which may cancel."""
        return Matrix(*self.shape, self.i, self.j, abs(self.x)) @ abs(vector)

    @property
    def T(self):
        return Matrix(self.shape[1], self.shape[0], self.j, self.i, self.x)

    def diagonal(self):
        on = self.i == self.j
        return numpy.bincount(self.i[on], self.x[on], self.shape[0])

    def dense(self):
        full = numpy.zeros(self.shape)
        numpy.add.at(full, (self.i, self.j), self.x)
        return full

    def whole(self):
        """With the other triangle, where only one is stored."""
        off = (self.i != self.j) & (self.x != 0)
        above, below = (self.i[off] < self.j[off]).any(), (self.i[off] > self.j[off]).any()
        if above == below:
            return self
        return Matrix(*self.shape, numpy.concatenate((self.i, self.j[off])), numpy.concatenate((self.j, self.i[off])),
                      numpy.concatenate((self.x, self.x[off])))


class Words:
    def __init__(self, path):
        self.words = open(path, encoding="ascii", errors="replace").read().split()
        self.at = 0

    def integer(self):
        self.at += 1
        return int(self.words[self.at - 1])

    def integers(self, count):
        return [self.integer() for _ in range(count)]

    def numbers(self, count):
        self.at += count
        values = numpy.array(self.words[self.at - count:self.at], float)
        assert values.size == count, "the file ends early"
        return values

    def skip_to(self, word):
        while self.words[self.at] != word:
            self.at += 1
        self.at += 1

    def left(self):
        return len(self.words) - self.at

    def matrix(self):
        storage, rows, columns = self.integers(3)
        if storage == 0:
            self.integers(2)
            j, i = numpy.divmod(numpy.arange(rows * columns), max(rows, 1))
            return Matrix(rows, columns, i, j, self.numbers(rows * columns))
        if storage == 1:
            return self.blocks(rows, columns)
        kind = self.integer()
        if kind in (1, 4):
            self.skip_to("triplet:")
            self.skip_to("nnz:")
            count = self.integer()
            table = numpy.array(self.words[self.at:self.at + 4 * count]).reshape(count, 4)
            self.at += 4 * count
            return Matrix(rows, columns, table[:, 0], table[:, 1], table[:, 3])
        self.skip_to("nnz:")
        self.at += 3  # the number, and the norm
        i, j, x = [], [], []
        for line in range(columns if kind == 2 else rows):
            self.skip_to("locations")
            first, last = int(self.words[self.at]), int(self.words[self.at + 2])
            self.at += 3
            for _ in range(last - first + 1):
                i.append(int(self.words[self.at]))
                j.append(line)
                x.append(float(self.words[self.at + 2]))
                self.at += 3
        return Matrix(rows, columns, i, j, x) if kind == 2 else Matrix(rows, columns, j, i, x)

    def blocks(self, rows, columns):
        count = self.integer()
        if count == 0:
            return Matrix(rows, columns, [], [], [])
        block_rows, block_columns = self.integers(2)
        row_ends, column_ends = [0] + self.integers(block_rows), [0] + self.integers(block_columns)
        lengths = self.integers(2)
        first, column = self.integers(lengths[0]), self.integers(lengths[1])
        i, j, x = [], [], []
        for row in range(lengths[0] - 1):
            for k in range(first[row], first[row + 1]):
                self.integer()
                for c in range(column_ends[column[k]], column_ends[column[k] + 1]):
                    for r in range(row_ends[row], row_ends[row + 1]):
                        i.append(r)
                        j.append(c)
                x.append(self.numbers(len(i) - sum(map(len, x))))
        return Matrix(rows, columns, i, j, numpy.concatenate(x))


def read_text(path):
    words = Words(path)
    d, n = words.integers(2)
    first = words.matrix()
    problem = {"d": d, "n": n}
    coefficients = n * (2 if d == 5 else 1)
    if words.left() > d * n + coefficients + 1 or first.shape[0] != d * n:
        problem["M"], problem["H"] = first.whole(), words.matrix()
        problem["f"] = words.numbers(first.shape[0])
        problem["w"] = words.numbers(d * n)
    else:
        problem["W"], problem["q"] = first.whole(), words.numbers(d * n)
    problem["mu"] = words.numbers(n)
    problem["mu_r"] = words.numbers(n) if d == 5 else None
    return problem


def read_fclib(path):
    import h5py

    def matrix(group):
        m, n, nz = (int(group[name][0]) for name in ("m", "n", "nz"))
        p, i, x = (group[name][:] for name in ("p", "i", "x"))
        if nz >= 0:
            return Matrix(m, n, i[:nz], p[:nz], x[:nz])
        lines = numpy.repeat(numpy.arange(len(p) - 1), numpy.diff(p))
        count = p[-1]
        return Matrix(m, n, i[:count], lines, x[:count]) if nz == -1 else Matrix(m, n, lines, i[:count], x[:count])

    file = h5py.File(path)
    group = next(file[name] for name in ("fclib_local", "fclib_global", "fclib_global_rolling") if name in file)
    problem = {"d": int(group["spacedim"][0])}
    for name in "MHGWVR":
        if name in group:
            problem[name] = matrix(group[name])
            if name in "MWR":
                problem[name] = problem[name].whole()
    for name, value in group["vectors"].items():
        problem["q" if name == "a" else name] = value[:]
    problem["n"] = problem["mu"].size
    return problem


def read_solution(path):
    words = open(path, encoding="ascii").read().split()
    parts, at = {}, 0
    while at < len(words):
        count = int(words[at + 1])
        parts[words[at]] = numpy.array(words[at + 2:at + 2 + count], float)
        at += 2 + count
    return parts


def conjugate_gradients(matrix, right):
    """Near enough for a scale."""
    scale = 1 / matrix.diagonal()
    x = numpy.zeros_like(right)
    rest, direction = right.copy(), scale * right
    rho = rest @ direction
    for _ in range(1000):
        if rho <= 1e-16 * (right @ (scale * right)):
            break
        image = matrix @ direction
        step = rho / (direction @ image)
        x += step * direction
        rest -= step * image
        ahead = scale * rest
        rho, before = rest @ ahead, rho
        direction = ahead + rho / before * direction
    return x


def off(terms, scale=1.0):
    """How far from 0 the sum of matrix @ vector, and of vectors alone, is against the size of what it adds."""
    total, size = 0.0, 0.0
    for sign, matrix, vector in terms:
        total = total + sign * (vector if matrix is None else matrix @ vector)
        size = size + (abs(vector) if matrix is None else matrix.size_of(vector))
    largest = numpy.linalg.norm(scale * size)
    return numpy.linalg.norm(scale * total) / largest if largest > 0 else 0.0


def equations(problem, solution):
    r, u, l = solution["r"], solution["u"], solution.get("l", numpy.zeros(0))
    if "W" in problem:
        worst = off([(1, None, u), (-1, problem["W"], r), (-1, None, problem["q"])] +
                    ([(-1, problem["V"], l)] if "V" in problem else []))
        if "R" in problem:
            worst = max(worst, off([(1, problem["V"].T, r), (1, problem["R"], l), (1, None, problem["s"])]))
        return worst
    v = solution["v"]
    worst = max(off([(1, problem["M"], v), (-1, None, problem["f"]), (-1, problem["H"], r)] +
                    ([(-1, problem["G"], l)] if "G" in problem else []), 1 / numpy.sqrt(problem["M"].diagonal())),
                off([(1, None, u), (-1, problem["H"].T, v), (-1, None, problem["w"])]))
    if "G" in problem:
        worst = max(worst, off([(1, problem["G"].T, v), (1, None, problem["b"])]))
    return worst


def mobilities(problem):
    """Of the rows of each contact, its largest: of the normal and the tangents, of the moments."""
    if "W" in problem:
        rows = problem["W"].diagonal()
    else:
        h, m = problem["H"], problem["M"].diagonal()
        rows = numpy.bincount(h.j, h.x**2 / m[h.i], h.shape[1])
    return numpy.maximum(rows.reshape(problem["n"], problem["d"]), 0)


def free_velocities(problem):
    if "W" in problem:
        return problem["q"]
    return problem["H"].T @ conjugate_gradients(problem["M"], problem["f"]) + problem["w"]


def laws(problem, solution):
    """Of each contact: r_n - max(0, r_n - rho u_n), and r_t (moments alike) less its nearest point in the disc of mu r_n
    after a step by -rho u_t; divided by rho, so that it is a velocity."""
    d, n = problem["d"], problem["n"]
    if n == 0:
        return 0.0
    r, u = solution["r"].reshape(n, d), solution["u"].reshape(n, d)
    mobility = mobilities(problem)
    scale = numpy.where(mobility.max(axis=1) > 0, mobility.max(axis=1), 1)
    defect = (r[:, 0] * scale - numpy.maximum(0, r[:, 0] * scale - u[:, 0]))**2
    parts = [(slice(1, min(d, 3)), problem["mu"])] + ([(slice(3, 5), problem["mu_r"])] if d == 5 else [])
    for rows, mu in parts:
        rho = numpy.where(mobility[:, rows].max(axis=1) > 0, mobility[:, rows].max(axis=1), 1)[:, None]
        target = r[:, rows] * rho - u[:, rows]
        radius = numpy.maximum(mu * r[:, 0], 0)[:, None] * rho
        length = numpy.linalg.norm(target, axis=1, keepdims=True)
        inside = target * numpy.minimum(1, radius / numpy.maximum(length, 1e-300))
        defect += ((r[:, rows] * rho - inside)**2).sum(axis=1)
    q = free_velocities(problem)
    size = numpy.sqrt((q**2).sum() / n)
    return float(numpy.sqrt(defect.mean()) / (size if size > 0 else 1))


def write_dense(problem, path):
    """As a text for Siconos."""
    with open(path, "w", encoding="ascii") as file:
        def numbers(values):
            file.write(" ".join(f"{value:.17g}" for value in values) + "\n")

        file.write(f"{problem['d']}\n{problem['n']}\n")
        for name in ("W",) if "W" in problem else ("M", "H"):
            rows, columns = problem[name].shape
            file.write(f"0\n{rows}\n{columns}\n{rows}\t{columns}\n")
            numbers(problem[name].dense().T.ravel())
        for name in ("q", "mu") if "W" in problem else ("f", "w", "mu"):
            numbers(problem[name])
        if problem["d"] == 5:
            numbers(problem["mu_r"])


def of_siconos(problem, path, solution):
    """Its error of a solution, or, where there is none, what it solves and its error."""
    import siconos.numerics as siconos

    if "G" in problem or "V" in problem or problem["d"] == 2 or problem["n"] == 0:
        return None, None
    rows = problem["d"] * problem["n"]
    solved = solution is None
    r, u = (numpy.zeros(rows), numpy.zeros(rows)) if solved else (solution["r"].copy(), solution["u"].copy())
    tolerance = 1e-10
    if problem["d"] == 5:
        if "M" in problem:
            inverse = numpy.linalg.inv(problem["M"].dense())
            h = problem["H"].dense()
            w = h.T @ inverse @ h
            i, j = numpy.indices(w.shape).reshape(2, -1)
            problem = dict(problem, W=Matrix(*w.shape, i, j, w.ravel()),
                           q=h.T @ inverse @ problem["f"] + problem["w"])
            write_dense({key: problem[key] for key in ("d", "n", "W", "q", "mu", "mu_r")}, path)
        data = siconos.rollingFrictionContact_new_from_filename(path)
        options = siconos.SolverOptions(siconos.SICONOS_ROLLING_FRICTION_3D_NSGS)
        drive = siconos.rolling_fc3d_driver
        error = siconos.rolling_fc3d_compute_error
    elif "M" in problem:
        data = siconos.globalFrictionContact_new_from_filename(path)
        options = siconos.SolverOptions(siconos.SICONOS_GLOBAL_FRICTION_3D_NSGS_WR)
        v = numpy.zeros(problem["M"].shape[0]) if solved else solution["v"].copy()
        options.dparam[siconos.SICONOS_DPARAM_TOL] = tolerance
        options.iparam[siconos.SICONOS_IPARAM_MAX_ITER] = 100000
        if solved:
            siconos.gfc3d_driver(data, r, u, v, options)
        norms = numpy.linalg.norm(problem["f"]), numpy.linalg.norm(problem["w"])
        return {"r": r, "u": u, "v": v}, siconos.gfc3d_compute_error(data, r, u, v, tolerance, options, *norms)[1]
    else:
        data = siconos.frictionContact_new_from_filename(path)
        options = siconos.SolverOptions(siconos.SICONOS_FRICTION_3D_NSGS)
        drive, error = siconos.fc3d_driver, siconos.fc3d_compute_error
    options.dparam[siconos.SICONOS_DPARAM_TOL] = tolerance
    options.iparam[siconos.SICONOS_IPARAM_MAX_ITER] = 100000
    if solved:
        drive(data, r, u, options)
    return {"r": r, "u": u}, error(data, r, u, tolerance, options, numpy.linalg.norm(problem["q"]))[1]


def main(path, *rest):
    hdf5 = open(path, "rb").read(4) == b"\x89HDF"
    problem = read_fclib(path) if hdf5 else read_text(path)
    text = path
    if hdf5:
        text = rest[-1] + ".problem.dat"
        write_dense(problem, text)
    if rest[0] == "--solve":
        solution, error = of_siconos(problem, text, None)
        if solution is None:
            sys.exit("Siconos does not solve this kind")
        with open(rest[1], "w", encoding="ascii") as file:
            file.write(f"r {solution['r'].size}\n" + "\n".join(f"{x:.17g}" for x in solution["r"]) + "\n")
    else:
        solution = read_solution(rest[0])
        error = of_siconos(problem, text, solution)[1]
    outcome = {"kind": "local" if "W" in problem else "global", "dimension": problem["d"], "contacts": problem["n"]}
    if rest[0] != "--solve":
        outcome["equations"] = float(equations(problem, solution))
    print(json.dumps(dict(outcome, laws=laws(problem, solution), siconos=error)))


if __name__ == "__main__":
    main(*sys.argv[1:])
