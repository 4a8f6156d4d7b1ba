// `lockstep verify` finds each word of a recording that was changed after it was made.
#include <functional>

#include "host/record/hdf5.hpp"
#include "host/record/recording_tables.hpp"
#include "tests/command_line.hpp"

namespace lockstep::verify_test {
namespace {

class Verify : public CommandLine {
 protected:
  // What is said of a recording once `change` has changed a table of it.
  template <class Row>
  Outcome after_change(const char* table, hid_t type, const std::function<void(std::vector<Row>&)>& change) {
    const fs::path changed = file("changed.h5");
    fs::copy_file(recorded(), changed, fs::copy_options::overwrite_existing);
    {
      const h5::Handle of(H5Fopen(changed.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
      const h5::Handle dataset = h5::open_dataset(of, table);
      hsize_t count = 1;
      for (const hsize_t extent : h5::extent_of(dataset)) count *= extent;
      std::vector<Row> rows(count);
      h5::check(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()));
      change(rows);
      h5::check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()));
    }
    return run("verify --device reference " + changed.string());
  }

  std::string recorded() {
    const fs::path path = file("x.h5");
    if (!fs::exists(path)) {
      EXPECT_EQ(
          run("run rag_doll --steps 20 --quiet --device reference --record-forces --record " + path.string()).status,
          0);
    }
    return path.string();
  }

  static void expect_found(const Outcome& outcome, const std::string& start) {
    EXPECT_EQ(outcome.status, 1) << outcome.out;
    EXPECT_EQ(outcome.err.find("lockstep: " + start), 0u) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
  }
};

TEST_F(Verify, FindsOneBitInEachTableOfBodies) {
  const char* const buffers[] = {"positions[0] word 0", "orientations[0] word 0", "motions[0] word ",
                                 "motions[0] word "};
  for (unsigned table = 0; table < 4; ++table) {
    SCOPED_TRACE(body_tables[table].name);
    const Outcome outcome = after_change<float>(body_tables[table].name, H5T_NATIVE_FLOAT, [](std::vector<float>& of) {
      float& word = of[of.size() / 20 * 7];  // the first one after the eighth step
      word = std::bit_cast<float>(std::bit_cast<std::uint32_t>(word) ^ 1u);
    });
    expect_found(outcome, std::string("step 7: ") + buffers[table]);
    EXPECT_NE(outcome.err.find("the state hash is equal, so the file was changed since"), std::string::npos);
  }
}

// All positions moved alike: every hash is that of the true run.
TEST_F(Verify, FindsAMotionThatWasMoved) {
  const Outcome outcome = after_change<float>("positions", H5T_NATIVE_FLOAT, [](std::vector<float>& of) {
    for (float& x : of) x += 7;
  });
  expect_found(outcome, "step 0: positions[0] word 0: recorded ");
}

TEST_F(Verify, FindsAForceThatWasChanged) {
  expect_found(after_change<ContactForceRow>("contact_forces", contact_force_row_type(),
                                             [](auto& rows) { rows.at(0).force[2] *= 1.5; }),
               "step ");
  const Outcome joints = after_change<double>("joint_forces", H5T_NATIVE_DOUBLE, [](std::vector<double>& of) {
    of[of.size() / 20 * 7 + 2] += 1;  // after the eighth step, of the first joint
  });
  expect_found(joints, "step 7: joint_forces[0] force: recorded ");
}

TEST_F(Verify, FindsWhatElseIsStored) {
  const h5::Handle measures = measure_row_type(), steps = step_row_type();
  expect_found(after_change<MeasureRow>("measures", measures, [](auto& rows) { rows[2].kinetic_j *= 1.5; }),
               "step 2: measures, kinetic_j: recorded ");
  // a row of another step, of none, or of one twice, would be compared with nothing
  for (const double step : {1.5, 2.0, 1000.0}) {
    const Outcome moved = after_change<MeasureRow>("measures", measures, [&](auto& rows) { rows.back().step = step; });
    EXPECT_EQ(moved.status, 2) << step;
    EXPECT_NE(moved.err.find("measures[19] is of no step"), std::string::npos) << moved.err;
  }
  expect_found(after_change<StepRow>("steps", steps, [](auto& rows) { rows[5].contacts += 1; }),
               "step 5: contacts: recorded ");
  expect_found(after_change<std::uint64_t>("pose_hashes", H5T_NATIVE_UINT64, [](auto& of) { of[4] ^= 1; }),
               "step 4: the pose hash of world 0 was recorded as ");
  expect_found(after_change<std::uint64_t>("state_hashes", H5T_NATIVE_UINT64, [](auto& of) { of[4] ^= 1; }),
               "step 4: the state hash of world 0 was recorded as ");
  // how long a step took is nothing that a replay knows
  EXPECT_EQ(after_change<StepRow>("steps", steps, [](auto& rows) { rows[5].milliseconds += 1; }).status, 0);
}

}  // namespace
}  // namespace lockstep::verify_test
