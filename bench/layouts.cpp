#include "bench/layouts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace lockstep::bench {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Block = Eigen::Matrix<double, 3, 6>;

// The rows of a contact on one of its bodies: sign (d, arm x d) for the normal and both tangents d.
Block rows_on(const LayoutProblem::Contact& c, bool of_a) {
  const Eigen::Matrix<double, 3, 2> t = solver_tangents(c.normal);
  const double sign = of_a ? 1 : -1;
  Block block;
  for (int k = 0; k < 3; ++k) {
    const Vector3d d = k == 0 ? c.normal : Vector3d(t.col(k - 1));
    block.row(k) << sign * d.transpose(), sign * (of_a ? c.arm_a : c.arm_b).cross(d).transpose();
  }
  return block;
}

template <class Values>
void append(std::vector<float>& values, const Values& block) {
  for (Eigen::Index i = 0; i < block.rows(); ++i) {
    for (Eigen::Index k = 0; k < block.cols(); ++k) values.push_back(float(block(i, k)));
  }
}

// Of each body its contacts in order, twice the contact and 1 more where it is b.
std::vector<std::vector<u32>> sides_of(const LayoutProblem& problem) {
  std::vector<std::vector<u32>> sides(problem.bodies.size());
  for (u32 i = 0; i < problem.contacts.size(); ++i) {
    const LayoutProblem::Contact& c = problem.contacts[i];
    if (c.body_a != NONE) sides[c.body_a].push_back(2 * i);
    if (c.body_b != NONE) sides[c.body_b].push_back(2 * i + 1);
  }
  return sides;
}

PackedBlock empty_block(u32 null) {
  PackedBlock block = {};
  for (u32 lane = 0; lane < PACK; ++lane) {
    block.body[0][lane] = block.body[1][lane] = null;
    block.normal[2][lane] = 1;  // tangents need a direction
  }
  return block;
}

void put(const LayoutProblem::Contact& c, PackedBlock& block, std::size_t lane) {
  if (c.body_a != NONE) block.body[0][lane] = c.body_a;
  if (c.body_b != NONE) block.body[1][lane] = c.body_b;
  for (int k = 0; k < 3; ++k) {
    block.normal[k][lane] = float(c.normal[k]);
    block.arm[0][k][lane] = float(c.arm_a[k]);
    block.arm[1][k][lane] = float(c.arm_b[k]);
  }
}

struct Pair {
  u32 first, count;  // contacts
};

// Contacts of the same bodies stand one after another.
std::vector<Pair> pairs_of(const LayoutProblem& problem) {
  std::vector<Pair> pairs;
  for (u32 i = 0; i < problem.contacts.size(); ++i) {
    const LayoutProblem::Contact& c = problem.contacts[i];
    const bool is_next = !pairs.empty() && problem.contacts[pairs.back().first].body_a == c.body_a &&
                         problem.contacts[pairs.back().first].body_b == c.body_b;
    if (is_next)
      ++pairs.back().count;
    else
      pairs.push_back({i, 1});
  }
  return pairs;
}

// Each pair in turn to the first colour that neither of its bodies has.
std::vector<std::vector<Pair>> colours_of(const LayoutProblem& problem) {
  std::vector<std::vector<bool>> taken(problem.bodies.size());
  std::vector<std::vector<Pair>> colours;
  for (const Pair& pair : pairs_of(problem)) {
    const LayoutProblem::Contact& c = problem.contacts[pair.first];
    const auto has = [&](u32 body, std::size_t colour) {
      return body != NONE && colour < taken[body].size() && taken[body][colour];
    };
    std::size_t colour = 0;
    while (has(c.body_a, colour) || has(c.body_b, colour)) ++colour;
    for (const u32 body : {c.body_a, c.body_b}) {
      if (body == NONE) continue;
      taken[body].resize(std::max(taken[body].size(), colour + 1), false);
      taken[body][colour] = true;
    }
    colours.resize(std::max(colours.size(), colour + 1));
    colours[colour].push_back(pair);
  }
  return colours;
}

}  // namespace

LayoutProblem layout_problem(const ContactSystem& system, u32 worlds) {
  LayoutProblem problem;
  std::vector<u32> slot(system.bodies.size(), NONE);
  u32 count = 0;
  for (std::size_t i = 0; i < system.bodies.size(); ++i) {
    if (system.bodies[i].inverse_mass > 0) slot[i] = count++;
  }
  for (u32 world = 0; world < worlds; ++world) {
    const auto body = [&](u32 i) { return slot[i] == NONE ? NONE : slot[i] + world * count; };
    for (const SystemBody& b : system.bodies) {
      if (b.inverse_mass > 0) problem.bodies.push_back({b.inverse_mass, b.inverse_inertia});
    }
    for (const SystemContact& c : system.contacts)
      problem.contacts.push_back({body(c.body_a), body(c.body_b), c.normal, c.arm_a, c.arm_b});
  }
  return problem;
}

BlockMatrix jacobian_of(const LayoutProblem& problem) {
  BlockMatrix j;
  j.starts = {0};
  for (const LayoutProblem::Contact& c : problem.contacts) {
    for (const bool of_a : {true, false}) {
      const u32 body = of_a ? c.body_a : c.body_b;
      if (body == NONE) continue;
      j.columns.push_back(body);
      append(j.values, rows_on(c, of_a));
    }
    j.starts.push_back(j.blocks());
  }
  return j;
}

BlockMatrix mobility_of(const LayoutProblem& problem) {
  const auto sides = sides_of(problem);
  BlockMatrix b;
  b.starts = {0};
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (const u32 side : sides[i]) {
      const Block on = rows_on(problem.contacts[side / 2], side % 2 == 0);
      Eigen::Matrix<double, 6, 3> moved;
      moved << problem.bodies[i].inverse_mass * on.leftCols<3>().transpose(),
          problem.bodies[i].inverse_inertia * on.rightCols<3>().transpose();
      b.columns.push_back(side / 2);
      append(b.values, moved);
    }
    b.starts.push_back(b.blocks());
  }
  return b;
}

SlicedMatrix sliced(const BlockMatrix& matrix, u32 sigma, u32 null) {
  const auto length = [&](u32 row) { return row == NONE ? 0 : matrix.starts[row + 1] - matrix.starts[row]; };
  SlicedMatrix s;
  s.order.resize(matrix.rows());
  std::iota(s.order.begin(), s.order.end(), 0u);
  for (std::size_t first = 0; first < s.order.size(); first += sigma) {
    const auto begin = s.order.begin() + std::ptrdiff_t(first);
    const auto end = s.order.begin() + std::ptrdiff_t(std::min<std::size_t>(first + sigma, s.order.size()));
    std::stable_sort(begin, end, [&](u32 a, u32 b) { return length(a) > length(b); });
  }
  s.order.resize((s.order.size() + PACK - 1) / PACK * PACK, NONE);
  s.starts = {0};
  for (std::size_t first = 0; first < s.order.size(); first += PACK) {
    u32 longest = 0;
    for (u32 lane = 0; lane < PACK; ++lane) longest = std::max(longest, length(s.order[first + lane]));
    for (u32 k = 0; k < longest; ++k) {
      const std::size_t values = s.values.size();
      s.values.resize(values + std::size_t(18) * PACK, 0);
      for (u32 lane = 0; lane < PACK; ++lane) {
        const u32 row = s.order[first + lane];
        if (k >= length(row)) {
          s.columns.push_back(null);
          continue;
        }
        const u32 block = matrix.starts[row] + k;
        s.columns.push_back(matrix.columns[block]);
        for (u32 entry = 0; entry < 18; ++entry)
          s.values[values + entry * PACK + lane] = matrix.values[std::size_t(18) * block + entry];
      }
    }
    s.starts.push_back(s.starts.back() + longest);
  }
  return s;
}

PackedRows packed_rows(const LayoutProblem& problem, u32 null) {
  PackedRows p;
  p.blocks.resize((problem.contacts.size() + PACK - 1) / PACK, empty_block(null));
  p.slots.resize(2 * PACK * p.blocks.size(), NONE);
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) put(problem.contacts[i], p.blocks[i / PACK], i % PACK);
  const auto sides = sides_of(problem);
  p.starts = {0};
  u32 next = 0;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (const u32 side : sides[i]) {
      p.slots[side / 2 / PACK * 2 * PACK + side % 2 * PACK + side / 2 % PACK] = next++;
    }
    p.starts.push_back(next);
    const LayoutProblem::Body& b = problem.bodies[i];
    const Matrix3d& m = b.inverse_inertia;
    p.inverses.push_back({float(b.inverse_mass), float(m(0, 0)), float(m(1, 1)), float(m(2, 2)), float(m(0, 1)),
                          float(m(0, 2)), float(m(1, 2)), 0});
  }
  return p;
}

ColouredRows coloured_rows(const LayoutProblem& problem, u32 null) {
  ColouredRows rows;
  rows.starts = {0};
  for (std::vector<Pair>& pairs : colours_of(problem)) {
    rows.colours.push_back(u32(rows.starts.size()) - 1);
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.count > b.count; });
    for (std::size_t first = 0; first < pairs.size(); first += PACK) {
      const std::size_t begin = rows.blocks.size();
      rows.blocks.resize(begin + pairs[first].count, empty_block(null));
      rows.contacts.resize(PACK * rows.blocks.size(), NONE);
      for (std::size_t k = first; k < std::min<std::size_t>(first + PACK, pairs.size()); ++k) {
        for (u32 row = 0; row < pairs[k].count; ++row) {
          put(problem.contacts[pairs[k].first + row], rows.blocks[begin + row], k - first);
          rows.contacts[(begin + row) * PACK + k - first] = pairs[k].first + row;
        }
      }
      rows.starts.push_back(u32(rows.blocks.size()));
    }
  }
  rows.colours.push_back(u32(rows.starts.size()) - 1);
  rows.motions.resize(null + 1);
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    const LayoutProblem::Body& b = problem.bodies[i];
    const Matrix3d& m = b.inverse_inertia;
    Motion<float>& motion = rows.motions[i];
    motion.inverse_mass = float(b.inverse_mass);
    motion.inertia_xx = float(m(0, 0));
    motion.inertia_yy = float(m(1, 1));
    motion.inertia_zz = float(m(2, 2));
    motion.inertia_xy = float(m(0, 1));
    motion.inertia_xz = float(m(0, 2));
    motion.inertia_yz = float(m(1, 2));
  }
  return rows;
}

}  // namespace lockstep::bench
