// The launcher: parameters bound by name, grids that cover the work, access checked against the stage table.
#include <gtest/gtest.h>

#include "tests/launcher_bench.hpp"

namespace lockstep::launcher_test {
namespace {

// A device with a program of its own, bound as the stage begin_step.
struct Bench : test::LauncherBench {
  explicit Bench(const std::string& source, u32 work_group = 0, bool profile = false)
      : LauncherBench(KernelSources(std::vector<KernelFile>{{"begin_step.cl", source}}), "begin_step.cl", work_group,
                      profile) {}
};

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

const char* const write_squares =
    "kernel void squares(global uint* values, uint count, uint first) {\n"
    "  for (uint i = (uint)get_global_id(0); i < count; i += (uint)get_global_size(0)) values[i] = first + i * i;\n"
    "}\n";

TEST(Launcher, GridsCoverTheWorkForEveryWorkGroupSize) {
  for (const u32 work_group : {0u, 1u, 3u, 16u, 64u}) {
    for (const u32 planned : {0u, 1u, 100u, 5000u}) {
      Bench bench(write_squares, work_group);
      bench.launcher.scratch("values", 5000);
      bench.launcher.run("squares", planned, {{"count", 5000u}, {"first", 7u}});
      const std::vector<u32> values = bench.read("values", 5000);
      for (u32 i = 0; i < 5000; ++i) ASSERT_EQ(values[i], 7 + i * i) << work_group << " " << planned;
    }
  }
}

TEST(Launcher, RebindsWhatChanged) {
  Bench bench(write_squares);
  bench.launcher.scratch("values", 10);
  bench.launcher.scratch("others", 10);
  bench.launcher.run("squares", 10, {{"count", 10u}, {"first", 1u}});
  bench.launcher.run_group("squares", {{"count", 10u}, {"first", 2u}, {"values", "others"}});
  bench.launcher.run("squares", 10, {{"count", 1u}, {"first", 3u}, {"values", "counters"}});
  EXPECT_EQ(bench.read("values", 4), (std::vector<u32>{1, 2, 5, 10}));
  EXPECT_EQ(bench.read("others", 4), (std::vector<u32>{2, 3, 6, 11}));
  EXPECT_EQ(bench.read("counters", 2), (std::vector<u32>{3, 0}));
  bench.launcher.scratch("values", 100000);
  bench.launcher.run("squares", 10, {{"count", 100000u}, {"first", 0u}});
  EXPECT_EQ(bench.read("values", 100000)[300], 90000u);
}

TEST(Launcher, NamesWhatCannotBeBound) {
  Bench bench(write_squares);
  EXPECT_NE(message_of([&] {
              bench.launcher.run("squares", 1, {{"count", 1u}, {"first", 1u}});
            }).find("values"),
            std::string::npos);
  bench.launcher.scratch("values", 10);
  EXPECT_NE(message_of([&] { bench.launcher.run("squares", 1, {{"count", 1u}}); }).find("first"), std::string::npos);
  EXPECT_NE(message_of([&] { bench.launcher.run("cubes", 1); }).find("cubes"), std::string::npos);
  EXPECT_NE(message_of([&] {
              bench.launcher.run("squares", 1, {{"count", 1u}, {"first", 1u}, {"last", 1u}});
            }).find("has no parameter last"),
            std::string::npos);
  EXPECT_NE(message_of([&] {
              bench.launcher.run("squares", 1, {{"count", 1u}, {"first", 1u}, {"values", "positions"}});
            }).find("squares writes positions"),
            std::string::npos);
}

TEST(Launcher, MeasuresStages) {
  Bench bench(write_squares, 0, true);
  bench.launcher.scratch("values", 100);
  for (int i = 0; i < 3; ++i) bench.launcher.run("squares", 100, {{"count", 100u}, {"first", 1u}});
  bench.queue.finish();
  const auto spans = bench.launcher.take_spans();
  ASSERT_EQ(spans.size(), 1u);
  EXPECT_EQ(spans[0].stage, Stage::begin_step);
  EXPECT_GT(spans[0].last.getProfilingInfo<CL_PROFILING_COMMAND_END>(),
            spans[0].first.getProfilingInfo<CL_PROFILING_COMMAND_START>());
}

TEST(StageTable, RefusesAKernelThatTakesWhatItsStageDoesNotList) {
  const auto check = [](const std::string& parameters) {
    const KernelSources sources(
        std::vector<KernelFile>{{"end_step.cl", "kernel void end_step(" + parameters + ") {}\n"}});
    const std::vector<std::string> names = {"end_step.cl"};
    return message_of([&] { check_stage_table(sources.signatures(names)); });
  };
  EXPECT_EQ(check("global u32* step_index, global u32* counters"), "no error");
  EXPECT_EQ(check("global u32* anything_else"), "no error");
  EXPECT_NE(check("global Vec4* positions").find("writes positions"), std::string::npos);
  EXPECT_NE(check("global const Vec4* positions").find("reads positions"), std::string::npos);
}

TEST(KernelSources, IncludesHeadersOnceAndTablesEachTime) {
  const KernelSources sources({{"a.cl", "#include \"h.h\"\nint a;\n"},
                               {"b.cl", "#include \"h.h\"\n#include \"t.def\"\n#include \"t.def\"\nint b;\n"},
                               {"h.h", "int h;\n"},
                               {"t.def", "ROW(x)\n"}});
  const std::vector<std::string> names = {"a.cl", "b.cl"};
  EXPECT_EQ(sources.assemble(names),
            "#line 1 \"kernels/a.cl\"\n#line 1 \"kernels/h.h\"\nint h;\n#line 2 \"kernels/a.cl\"\nint a;\n"
            "#line 1 \"kernels/b.cl\"\n#line 2 \"kernels/b.cl\"\n"
            "#line 1 \"kernels/t.def\"\nROW(x)\n#line 3 \"kernels/b.cl\"\n"
            "#line 1 \"kernels/t.def\"\nROW(x)\n#line 4 \"kernels/b.cl\"\nint b;\n");
}

TEST(KernelSources, ReadsParameterLists) {
  const KernelSources sources(
      std::vector<KernelFile>{{"a.cl",
                               "// kernel void not_this(global u32* x)\n"
                               "kernel void first(global const Vec4* restrict positions,\n"
                               "                  global u32* counters, /* a comma, */ const StepParams params) {}\n"
                               "__kernel void second(const u32 color) {}\nkernel void third() {}\n"}});
  const std::vector<std::string> names = {"a.cl"};
  const auto kernels = sources.signatures(names);
  using Kind = KernelParameter::Kind;
  ASSERT_EQ(kernels.size(), 3u);
  ASSERT_EQ(kernels[0].parameters.size(), 3u);
  EXPECT_EQ(kernels[0].parameters[0].name, "positions");
  EXPECT_EQ(kernels[0].parameters[0].kind, Kind::read);
  EXPECT_EQ(kernels[0].parameters[1].kind, Kind::written);
  EXPECT_EQ(kernels[0].parameters[2].kind, Kind::params);
  EXPECT_EQ(kernels[1].name, "second");
  EXPECT_EQ(kernels[1].parameters[0].kind, Kind::value);
  EXPECT_TRUE(kernels[2].parameters.empty());
}

TEST(Program, ABuildErrorCarriesFileLineAndTheWholeLog) {
  const std::string message =
      message_of([] { Bench bench("kernel void wrong(global uint* counters) {\n  counters[0] = nonsense;\n}\n"); });
  EXPECT_NE(message.find("kernels/begin_step.cl:2"), std::string::npos) << message;
  EXPECT_NE(message.find("nonsense"), std::string::npos) << message;
}

TEST(Program, DoubleIsRefusedWhereThereIsNone) {
  Device device = open_device(test_device());
  device.info.fp64 = false;
  const std::string message = message_of([&] { build_program(device, "", {.double_precision = true}); });
  EXPECT_EQ(message, device.info.name + ": has no double precision, run with --precision float");
}

}  // namespace
}  // namespace lockstep::launcher_test
