// FCLIB's files: /fclib_local {spacedim, W, V, R, vectors {q, mu, s}} or /fclib_global {spacedim, M, H, G, vectors {f,
// w, mu, b}}, or /fclib_global_rolling, the same with mu_r; /solution {v, u, r, l}, /guesses/1 alike. A matrix is {m,
// n, nzmax, nz, p, i, x}; nz = -1: compressed columns, -2: compressed rows, else triplets: rows in `i` and columns in
// `p`, as the files of the collection have it, or the other way round, as fclib.h says; which one fits tells a matrix
// that is not square, and a symmetric one does not mind.
#include <fmt/format.h>

#include <algorithm>

#include "host/problems/formats.hpp"
#include "host/record/hdf5.hpp"

namespace lockstep {

namespace {

using Eigen::VectorXd;
using oracle::SparseMatrix;

template <class Number>
hid_t native_type() {
  return std::is_same_v<Number, double> ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT32;
}

// A group of the file, and the path in it, for complaints.
class Group {
 public:
  Group(const std::string& path, hid_t parent, const std::string& location, const char* name)
      : path_(path), location_(location + "/" + name), group_(h5::open_group(parent, name)) {}

  bool has(const char* name) const { return h5::has(group_, name); }
  Group group(const char* name) const {
    if (!has(name)) refuse(name, "is missing");
    return Group(path_, group_, location_, name);
  }

  [[noreturn]] void refuse(const std::string& name, const std::string& what) const {
    refuse_problem(path_, location_ + "/" + name, what);
  }

  template <class Number>
  std::vector<Number> numbers(const char* name) const {
    if (!has(name)) refuse(name, "is missing");
    const h5::Handle dataset = h5::open_dataset(group_, name);
    const h5::Handle type(H5Dget_type(dataset));
    const H5T_class_t wanted = std::is_same_v<Number, double> ? H5T_FLOAT : H5T_INTEGER;
    if (H5Tget_class(type) != wanted) refuse(name, "holds no numbers of the right kind");
    const std::vector<hsize_t> extent = h5::extent_of(dataset);
    if (extent.size() > 1) refuse(name, fmt::format("must have one dimension, has {}", extent.size()));
    std::vector<Number> values(extent.empty() ? 1 : extent[0]);
    if (!values.empty())
      h5::check(H5Dread(dataset, native_type<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
    if constexpr (std::is_same_v<Number, double>) expect_finite(path_, location_ + "/" + name, values);
    return values;
  }

  int integer(const char* name, long long least, long long most) const {
    const std::vector<int> values = numbers<int>(name);
    if (values.size() != 1) refuse(name, fmt::format("must be one number, has {}", values.size()));
    if (values[0] < least || values[0] > most)
      refuse(name, fmt::format("must be from {} to {}, is {}", least, most, values[0]));
    return values[0];
  }

  VectorXd vector(const char* name, Eigen::Index size) const {
    const std::vector<double> values = numbers<double>(name);
    if (Eigen::Index(values.size()) != size)
      refuse(name, fmt::format("must have {} numbers, has {}", size, values.size()));
    return Eigen::Map<const VectorXd>(values.data(), size);
  }

  const std::string& path() const { return path_; }
  const std::string& location() const { return location_; }

 private:
  const std::string& path_;
  const std::string location_;
  const h5::Handle group_;
};

bool all_below(std::span<const int> indices, int bound) {
  return std::ranges::all_of(indices, [&](int i) { return i >= 0 && i < bound; });
}

SparseMatrix read_matrix(const Group& group) {
  const long long most = 6 * most_contacts;
  const int rows = group.integer("m", 0, most), columns = group.integer("n", 0, most);
  const int nz = group.integer("nz", -2, 0x7fffffff);
  std::vector<int> p = group.numbers<int>("p"), i = group.numbers<int>("i");
  const std::vector<double> x = group.numbers<double>("x");
  std::size_t count = static_cast<std::size_t>(std::max(nz, 0));
  if (nz < 0) {
    const std::size_t outer = static_cast<std::size_t>(nz == -1 ? columns : rows);
    if (p.size() != outer + 1 || p[0] != 0 || !std::ranges::is_sorted(p))
      group.refuse("p", fmt::format("must be {} rising offsets from 0", outer + 1));
    count = static_cast<std::size_t>(p.back());
    if (i.size() >= count) {
      std::vector<int> spelled_out;
      for (std::size_t k = 0; k < outer; ++k)
        spelled_out.insert(spelled_out.end(), std::size_t(p[k + 1] - p[k]), int(k));
      p = std::move(spelled_out);
      if (nz == -2) std::swap(p, i);
    }
  }
  for (const auto& [name, size] : {std::pair("i", i.size()), std::pair("p", p.size()), std::pair("x", x.size())}) {
    if (size < count) group.refuse(name, fmt::format("must have {} numbers, has {}", count, size));
  }
  p.resize(count);
  i.resize(count);
  if (nz >= 0 && !(all_below(i, rows) && all_below(p, columns))) std::swap(p, i);
  if (!all_below(i, rows)) group.refuse("i", fmt::format("names a row beyond the {} that there are", rows));
  if (!all_below(p, columns)) group.refuse("p", fmt::format("names a column beyond the {} that there are", columns));
  std::vector<Eigen::Triplet<double>> triplets;
  for (std::size_t k = 0; k < count; ++k) triplets.emplace_back(i[k], p[k], x[k]);
  SparseMatrix matrix(rows, columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

void expect_size(const Group& group, const char* name, const SparseMatrix& matrix, Eigen::Index rows,
                 Eigen::Index columns) {
  if (matrix.rows() != rows || matrix.cols() != columns)
    group.refuse(name, fmt::format("must be {} x {}, is {} x {}", rows, columns, matrix.rows(), matrix.cols()));
}

// Number of contacts for so many rows.
Eigen::Index contacts_of(const Group& group, const char* name, Eigen::Index rows, std::uint32_t dimension) {
  if (rows % dimension != 0)
    group.refuse(name, fmt::format("{} rows of contacts are no multiple of the dimension {}", rows, dimension));
  return rows / dimension;
}

// Our own note: which rows of joints are a block.
std::vector<std::uint32_t> joint_blocks(const Group& group, Eigen::Index rows) {
  std::vector<std::uint32_t> first;
  if (!group.has("joint_blocks")) {
    for (Eigen::Index i = 0; i <= rows; ++i) first.push_back(static_cast<std::uint32_t>(i));
    return first;
  }
  for (const int start : group.numbers<int>("joint_blocks")) {
    if (start < 0 || start > rows || (!first.empty() && std::uint32_t(start) <= first.back()))
      group.refuse("joint_blocks", "must be rising row numbers");
    first.push_back(static_cast<std::uint32_t>(start));
  }
  if (first.empty() || first.front() != 0 || first.back() != rows)
    group.refuse("joint_blocks", "must go from the first row to the end");
  return first;
}

// Coefficients of friction, and those of rolling friction where contacts have five rows.
struct Friction {
  VectorXd mu, rolling;
};

Friction read_friction(const Group& vectors, Eigen::Index contacts, std::uint32_t dimension) {
  Friction friction = {vectors.vector("mu", contacts), {}};
  expect_friction(vectors.path(), vectors.location() + "/mu", friction.mu);
  if (dimension != 5) return friction;
  friction.rolling = vectors.vector("mu_r", contacts);
  expect_friction(vectors.path(), vectors.location() + "/mu_r", friction.rolling);
  return friction;
}

void read_local(const Group& group, ConeFile& file) {
  file.form = "FCLIB, local";
  SparseMatrix w = read_matrix(group.group("W"));
  expect_size(group, "W", w, w.rows(), w.rows());
  w = whole_matrix(group.path(), group.location() + "/W", std::move(w), "W", file.form);
  const Eigen::Index n = contacts_of(group, "W", w.rows(), file.dimension);
  const Group vectors = group.group("vectors");
  // an old version of the library wrote q under the name of a
  const VectorXd q = vectors.vector(!vectors.has("q") && vectors.has("a") ? "a" : "q", w.rows());
  const Friction friction = read_friction(vectors, n, file.dimension);
  std::optional<oracle::Bilateral> joints;
  if (group.has("V") || group.has("R")) {
    joints.emplace();
    joints->r = read_matrix(group.group("R"));
    joints->v = read_matrix(group.group("V"));
    expect_size(group, "R", joints->r, joints->r.rows(), joints->r.rows());
    expect_size(group, "V", joints->v, w.rows(), joints->r.rows());
    joints->r = whole_matrix(group.path(), group.location() + "/R", std::move(joints->r), "R", file.form);
    joints->s = vectors.vector("s", joints->r.rows());
    joints->first = joint_blocks(group, joints->r.rows());
  }
  set_local(file, w, q, friction.mu, friction.rolling, std::move(joints));
}

void read_global(const Group& group, ConeFile& file) {
  file.form = file.dimension == 5 ? "FCLIB, global, rolling friction" : "FCLIB, global";
  oracle::GlobalConeProblem problem;
  problem.m = read_matrix(group.group("M"));
  expect_size(group, "M", problem.m, problem.m.rows(), problem.m.rows());
  problem.m = whole_matrix(group.path(), group.location() + "/M", std::move(problem.m), "M", file.form);
  problem.h = read_matrix(group.group("H"));
  expect_size(group, "H", problem.h, problem.m.rows(), problem.h.cols());
  const Eigen::Index n = contacts_of(group, "H", problem.h.cols(), file.dimension);
  const Group vectors = group.group("vectors");
  problem.f = vectors.vector("f", problem.m.rows());
  problem.w = vectors.vector("w", problem.h.cols());
  const Friction friction = read_friction(vectors, n, file.dimension);
  problem.mu = friction.mu;
  problem.g = SparseMatrix(problem.m.rows(), 0);
  if (group.has("G")) {
    problem.g = read_matrix(group.group("G"));
    expect_size(group, "G", problem.g, problem.m.rows(), problem.g.cols());
    problem.b = vectors.vector("b", problem.g.cols());
    problem.first = joint_blocks(group, problem.g.cols());
  }
  try {
    set_global(file, std::move(problem), friction.rolling);
  } catch (const std::runtime_error& error) {
    group.refuse("M", error.what());
  }
}

// What lies in a group `solution`, or in the first of `guesses`, where joints may have no impulses.
oracle::ConeImpulses read_solution(const Group& group, const ConeFile& file) {
  const Eigen::Index rows = Eigen::Index(file.dimension) * file.contacts();
  oracle::ConeImpulses stored = {impulses_in_problem(file, group.vector("r", rows)), {}};
  if (file.problem.joints && group.has("l")) stored.l = group.vector("l", file.problem.joints->s.size());
  return stored;
}

// The forms that a file may have, by the group that holds it, and from how many rows a contact to how many.
struct Form {
  const char* group;
  long long least, most;
  void (*read)(const Group&, ConeFile&);
};

constexpr Form forms[] = {
    {"fclib_local", 2, 3, read_local},
    {"fclib_global", 2, 3, read_global},
    {"fclib_global_rolling", 5, 5, read_global},
};

}  // namespace

ConeFile read_fclib(const std::string& path, std::span<const unsigned char> bytes) {
  try {
    const h5::Handle image = h5::open_image(bytes);
    const auto form = std::ranges::find_if(forms, [&](const Form& f) { return h5::has(image, f.group); });
    if (form == std::end(forms))
      refuse_problem(path, "/",
                     "has neither fclib_local, fclib_global nor fclib_global_rolling; it is another kind of "
                     "HDF5 file");
    const Group group(path, image, "", form->group);
    ConeFile file;
    file.dimension = static_cast<std::uint32_t>(group.integer("spacedim", form->least, form->most));
    form->read(group, file);
    if (h5::has(image, "solution")) file.stored = read_solution(Group(path, image, "", "solution"), file);
    return file;
  } catch (const h5::Failed& failed) {
    refuse_problem(path, "HDF5", std::string(failed.what()) + "; the file may be cut short");
  }
}

oracle::ConeImpulses read_fclib_solution(const std::string& path, std::span<const unsigned char> bytes,
                                         const ConeFile& file) {
  try {
    const h5::Handle image = h5::open_image(bytes);
    const bool solved = h5::has(image, "solution");
    if (!solved && !h5::has(image, "guesses")) refuse_problem(path, "/", "has neither a solution nor guesses");
    const Group group = solved ? Group(path, image, "", "solution") : Group(path, image, "", "guesses").group("1");
    return read_solution(group, file);
  } catch (const h5::Failed& failed) {
    refuse_problem(path, "HDF5", std::string(failed.what()) + "; the file may be cut short");
  }
}

}  // namespace lockstep
