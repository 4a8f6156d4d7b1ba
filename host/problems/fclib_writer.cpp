#include <numeric>
#include <string_view>

#include "host/problems/cone_file.hpp"
#include "host/problems/solution_file.hpp"
#include "host/record/hdf5.hpp"

namespace lockstep {

namespace {

using Eigen::VectorXd;
using oracle::SparseMatrix;

void write_integers(hid_t group, const char* name, std::span<const int> values) {
  const hsize_t extent[] = {values.size()};
  const h5::Handle dataset(
      H5Dcreate2(group, name, H5T_STD_I32LE, h5::space(extent), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  if (!values.empty()) h5::check(H5Dwrite(dataset, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
}

void write_integer(hid_t group, const char* name, Eigen::Index value) {
  const int one[] = {static_cast<int>(value)};
  write_integers(group, name, one);
}

void write_numbers(hid_t group, const char* name, std::span<const double> values) {
  const hsize_t extent[] = {values.size()};
  const h5::Handle dataset(
      H5Dcreate2(group, name, H5T_IEEE_F64LE, h5::space(extent), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  if (!values.empty()) h5::check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
}

void write_vector(hid_t group, const char* name, const VectorXd& values) {
  write_numbers(group, name, {values.data(), static_cast<std::size_t>(values.size())});
}

h5::Handle make_group(hid_t parent, const char* name) {
  return h5::Handle(H5Gcreate2(parent, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
}

void write_matrix(hid_t parent, const char* name, SparseMatrix matrix) {
  matrix.makeCompressed();
  const h5::Handle group = make_group(parent, name);
  const auto count = static_cast<std::size_t>(matrix.nonZeros());
  write_integer(group, "m", matrix.rows());
  write_integer(group, "n", matrix.cols());
  write_integer(group, "nzmax", matrix.nonZeros());
  write_integer(group, "nz", -1);
  write_integers(group, "p", {matrix.outerIndexPtr(), static_cast<std::size_t>(matrix.cols()) + 1});
  write_integers(group, "i", {matrix.innerIndexPtr(), count});
  write_numbers(group, "x", {matrix.valuePtr(), count});
}

void write_joint_blocks(hid_t group, const std::vector<std::uint32_t>& first, Eigen::Index rows) {
  if (first.size() == static_cast<std::size_t>(rows) + 1 || first.empty()) return;  // each row by itself
  write_integers(group, "joint_blocks", std::vector<int>(first.begin(), first.end()));
}

std::vector<unsigned char> bytes_of(hid_t file) {
  h5::check(H5Fflush(file, H5F_SCOPE_LOCAL));
  std::vector<unsigned char> bytes(static_cast<std::size_t>(h5::check(H5Fget_file_image(file, nullptr, 0))));
  h5::check(H5Fget_file_image(file, bytes.data(), bytes.size()));
  return bytes;
}

h5::Handle file_in_memory() {
  h5::be_quiet();
  const h5::Handle access(H5Pcreate(H5P_FILE_ACCESS));
  h5::check(H5Pset_fapl_core(access, 1u << 20, false));
  return h5::Handle(H5Fcreate("problem", H5F_ACC_TRUNC, H5P_DEFAULT, access));
}

// The file's bytes; `fill` writes what is in it.
template <class Fill>
std::vector<unsigned char> encode(const char* form, std::uint32_t dimension, const std::string& title, Fill&& fill,
                                  const std::optional<oracle::ConeImpulses>& stored) {
  const h5::Handle file = file_in_memory();
  {
    const h5::Handle group = make_group(file, form);
    write_integer(group, "spacedim", dimension);
    fill(group);
    const h5::Handle info = make_group(group, "info");
    for (const auto& [name, text] :
         {std::pair("title", title), std::pair("description", std::string()), std::pair("math_info", std::string())})
      h5::write_text(info, name, text);
  }
  if (stored) {
    const h5::Handle group = make_group(file, "solution");
    write_vector(group, "r", stored->r);
    if (stored->l.size() > 0) write_vector(group, "l", stored->l);
  }
  return bytes_of(file);
}

constexpr const char* problem_groups[] = {"fclib_local", "fclib_global", "fclib_global_rolling", "guesses"};

}  // namespace

std::vector<unsigned char> encode_solution(const ProblemSolution& solution, std::span<const unsigned char> problem) {
  const h5::Handle file = file_in_memory();
  if (std::string_view(reinterpret_cast<const char*>(problem.data()), problem.size()).starts_with("\x89HDF")) {
    const h5::Handle image = h5::open_image(problem);
    for (const char* name : problem_groups) {
      if (h5::has(image, name)) h5::check(H5Ocopy(image, name, file, name, H5P_DEFAULT, H5P_DEFAULT));
    }
  }
  {
    const h5::Handle group = make_group(file, "solution");
    if (solution.v.size() > 0) write_vector(group, "v", solution.v);
    write_vector(group, "u", solution.u);
    write_vector(group, "r", solution.r);
    if (solution.l.size() > 0) write_vector(group, "l", solution.l);
  }
  return bytes_of(file);
}

std::vector<unsigned char> encode_fclib(const oracle::ConeProblem& problem, const std::string& title,
                                        const std::optional<oracle::ConeImpulses>& stored) {
  const auto fill = [&](hid_t group) {
    write_matrix(group, "W", problem.w.sparse());
    const h5::Handle vectors = make_group(group, "vectors");
    write_vector(vectors, "q", problem.q);
    write_vector(vectors, "mu", problem.mu);
    if (!problem.joints) return;
    write_matrix(group, "V", problem.joints->v);
    write_matrix(group, "R", problem.joints->r);
    write_vector(vectors, "s", problem.joints->s);
    write_joint_blocks(group, problem.joints->first, problem.joints->s.size());
  };
  return encode("fclib_local", 3, title, fill, stored);
}

std::vector<unsigned char> encode_fclib(const oracle::GlobalConeProblem& problem, const std::string& title,
                                        const std::optional<oracle::ConeImpulses>& stored) {
  const auto fill = [&](hid_t group) {
    write_matrix(group, "M", problem.m);
    write_matrix(group, "H", problem.h);
    const h5::Handle vectors = make_group(group, "vectors");
    write_vector(vectors, "f", problem.f);
    write_vector(vectors, "w", problem.w);
    write_vector(vectors, "mu", problem.mu);
    if (problem.g.cols() == 0) return;
    write_matrix(group, "G", problem.g);
    write_vector(vectors, "b", problem.b);
    write_joint_blocks(group, problem.first, problem.g.cols());
  };
  return encode("fclib_global", problem.dimension, title, fill, stored);
}

}  // namespace lockstep
