// The contacts of a step as J and M^-1 J^T in several layouts (bench/layouts.cl has their products).
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "host/report/contact_system.hpp"

namespace lockstep::bench {

/// What the layouts are made of: contacts in the order of the step, bodies that can move.
struct LayoutProblem {
  struct Contact {
    u32 body_a = NONE, body_b = NONE;  // NONE: does not move
    Eigen::Vector3d normal, arm_a, arm_b;
  };
  struct Body {
    double inverse_mass = 0;          // 1/kg
    Eigen::Matrix3d inverse_inertia;  // world frame, 1/(kg m^2)
  };
  std::vector<Contact> contacts;
  std::vector<Body> bodies;
};

/// `worlds` times the system beside each other.
LayoutProblem layout_problem(const ContactSystem& system, u32 worlds);

/// Blocks of 18 reals in a sparse matrix, row by row: J (3 x 6, a row each contact) or M^-1 J^T (6 x 3, a row each
/// body, its contacts in order).
struct BlockMatrix {
  std::vector<u32> starts;   // of each row, and the end
  std::vector<u32> columns;  // of each block
  std::vector<float> values;
  u32 rows() const { return static_cast<u32>(starts.size()) - 1; }
  u32 blocks() const { return static_cast<u32>(columns.size()); }
};
BlockMatrix jacobian_of(const LayoutProblem& problem);
BlockMatrix mobility_of(const LayoutProblem& problem);

/// SELL-C-sigma (Kreutzer, Hager, Wellein, Fehske, Bishop 2014) of blocks, C = PACK: in windows of `sigma` rows the
/// longest first, chunks of PACK of them, each as long as its longest. Blocks that are missing are 0 and of column
/// `null`.
struct SlicedMatrix {
  std::vector<u32> starts;   // of each chunk, in columns of PACK blocks, and the end
  std::vector<u32> columns;  // PACK a column
  std::vector<float> values;
  std::vector<u32> order;  // the row of each lane; NONE: none
  u32 chunks() const { return static_cast<u32>(starts.size()) - 1; }
};
SlicedMatrix sliced(const BlockMatrix& matrix, u32 sigma, u32 null);

/// PackedBlock of bench/layouts.cl.
struct PackedBlock {
  u32 body[2][PACK];
  float normal[3][PACK], arm[2][3][PACK];
};
struct PackedRows {
  std::vector<PackedBlock> blocks;
  std::vector<u32> slots;                      // of what each contact pushes with: PACK of a, PACK of b; NONE: nowhere
  std::vector<u32> starts;                     // of the slots of each body, and the end
  std::vector<std::array<float, 8>> inverses;  // of each body: 1 / m; xx, yy, zz, xy, xz, yz of the inverse inertia; -
};
/// `null`: the body of what does not move.
PackedRows packed_rows(const LayoutProblem& problem, u32 null);

/// The same in the order of the solver: pairs of one colour share no body that moves; PACK of them, those of more
/// contacts first, have as many blocks one after another as the first has contacts.
struct ColouredRows {
  std::vector<PackedBlock> blocks;
  std::vector<u32> contacts;           // of each lane of each block; NONE: none
  std::vector<u32> starts;             // of the blocks of each PACK pairs, and the end
  std::vector<u32> colours;            // the first of those of each colour, and the end
  std::vector<Motion<float>> motions;  // of each body, at rest, and of `null`
};
ColouredRows coloured_rows(const LayoutProblem& problem, u32 null);

}  // namespace lockstep::bench
