#include <gtest/gtest.h>

#include <map>
#include <set>

#include "cpu_reference/solver_cell.hpp"
#include "tests/cell_scene.hpp"

namespace lockstep::test::partition_contacts_test {
namespace {

template <class real>
class PartitionContacts : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(PartitionContacts, Precisions);

TYPED_TEST(PartitionContacts, KernelMatchesReference) {
  using real = TypeParam;
  run_twins(Stage::partition_contacts, graphs_in_cells<real>(1, {{3, 5}, {400, 1500}, {1, 2}}));
  run_twins(Stage::partition_contacts, graphs_in_cells<real>(2, {{5, 0}}));
  InitialState<real> state = graphs_in_cells<real>(3, {{200, 900}});
  state.buffers.positions[7].x = real(1e30);  // beyond the numbers of cells
  state.buffers.positions[8].y = std::numeric_limits<real>::quiet_NaN();
  state.buffers.positions[9].z = -std::numeric_limits<real>::infinity();
  run_twins(Stage::partition_contacts, state);
}

// The cell of a pair of bodies at these places, by its phase and its number in it; NONE: in no cell.
template <class real>
u32 cell_of_two(Vector3 a, Vector3 b, double size = 1) {
  InitialState<real> state = contact_graphs<real>({{BODY_DYNAMIC, BODY_DYNAMIC}}, {{{0, 1}}});
  use_cells(state, size);
  set(&state.buffers.positions[0].x, a);
  set(&state.buffers.positions[1].x, b);
  return reference::cell_of_pair(state.buffers, state.params, state.buffers.contacts[0]);
}

// A world of two bodies has one slot in each phase: the number of a cell is its phase.
TYPED_TEST(PartitionContacts, CellsAreHalfOpenCubesOnBothSidesOfZero) {
  using real = TypeParam;
  EXPECT_EQ(cell_of_two<real>({0.5, 0.5, 0.5}, {0.9, 0.1, 0.2}), 0u);
  EXPECT_EQ(cell_of_two<real>({1, 0.5, 0.5}, {1.5, 0.5, 0.5}), 1u);  // on a face: the cell above
  EXPECT_EQ(cell_of_two<real>({0.999, 0.5, 0.5}, {1, 0.5, 0.5}), 0u);
  EXPECT_EQ(cell_of_two<real>({0.5, 1, 0.5}, {0.5, 1, 0.5}), 2u);
  EXPECT_EQ(cell_of_two<real>({0.5, 0.5, 1}, {0.5, 0.5, 1}), 4u);
  EXPECT_EQ(cell_of_two<real>({-0.001, 0.5, 0.5}, {0, 0.5, 0.5}), 1u);  // -1 is odd
  EXPECT_EQ(cell_of_two<real>({-1, -1, -1}, {-1, -1, -1}), 7u);
  EXPECT_EQ(cell_of_two<real>({-1.001, 0.5, 0.5}, {-1, 0.5, 0.5}), 0u);
  EXPECT_EQ(cell_of_two<real>({0.5, 1.5, 0.5}, {1.5, 0.5, 1.5}), 0u);  // the lower along each axis
  EXPECT_EQ(cell_of_two<real>({-0.001, 0.5, 0.5}, {1, 0.5, 0.5}), NONE);
  EXPECT_EQ(cell_of_two<real>({0.5, 0.5, 0.5}, {0.5, 2, 0.5}), NONE);
  EXPECT_EQ(cell_of_two<real>({-0.001, 0.5, 0.5}, {1, 0.5, 0.5}, 3), 1u);
}

// What the phases are for: a body is in one cell of each.
TYPED_TEST(PartitionContacts, CellsOfAPhaseShareNoMovableBody) {
  using real = TypeParam;
  InitialState<real> state = graphs_in_cells<real>(4, {{300, 2000}, {40, 100}});
  for (Vec4<real>& at : state.buffers.positions) at.x *= 4;
  reference::run_stage(Stage::partition_contacts, state.buffers, state.params);
  const Buffers<real>& b = state.buffers;
  const u32 cells = u32(b.cell_starts.size()) - 1, in_phase = cells / CELL_PHASES;
  std::set<u32> listed;
  u32 used = 0;
  for (u32 phase = 0; phase < CELL_PHASES; ++phase) {
    std::map<u32, u32> cell_of_body;
    for (u32 cell = phase * in_phase; cell < (phase + 1) * in_phase; ++cell) {
      used += b.cell_starts[cell] < b.cell_starts[cell + 1];
      for (u32 k = b.cell_starts[cell]; k < b.cell_starts[cell + 1]; ++k) {
        const u32 i = b.cell_pairs[k];
        EXPECT_TRUE(listed.insert(i).second);
        EXPECT_GT(reference::pair_contact_count(b, i), 0u);
        EXPECT_TRUE(k == b.cell_starts[cell] || b.cell_pairs[k - 1] < i);
        for (const u32 body : movable_bodies(b, i))
          EXPECT_EQ(cell_of_body.emplace(body, cell).first->second, cell) << "body " << body;
      }
    }
  }
  EXPECT_GT(used, 20u);
  EXPECT_GT(listed.size(), 200u);
  // and the others have bodies that are more than a cell apart
  u32 far = 0;
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    if (reference::pair_contact_count(b, i) == 0 || listed.contains(i)) continue;
    const Vec4<real>&x = b.positions[b.contacts[i].body_a], &y = b.positions[b.contacts[i].body_b];
    ++far;
    EXPECT_TRUE(std::abs(x.x - y.x) > 1 || std::abs(x.y - y.y) > 1 || std::abs(x.z - y.z) > 1);
  }
  EXPECT_GT(far, 100u);
}

// What cannot move may be anywhere.
TYPED_TEST(PartitionContacts, ImmovableBodiesHaveNoCell) {
  using real = TypeParam;
  for (const BodyKind kind : {BODY_STATIC, BODY_KINEMATIC}) {
    InitialState<real> state = contact_graphs<real>({{BODY_DYNAMIC, kind}}, {{{0, 1}}});
    use_cells(state, 1);
    state.buffers.positions = {{real(2.5), real(3.5), real(0.5), 0}, {real(1e9), 0, 0, 0}};
    EXPECT_EQ(reference::cell_of_pair(state.buffers, state.params, state.buffers.contacts[0]), 2u);
  }
}

}  // namespace
}  // namespace lockstep::test::partition_contacts_test
