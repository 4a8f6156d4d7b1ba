// golden HASHES.json            runs every case on the reference and compares: status 1 where a hash differs
// golden HASHES.json --update   writes the hashes that this build computes
// A program of its own, so that other compilers and other options can build it without OpenCL (tests/golden/compilers).
#include "tests/golden/golden.hpp"

#include <cstdio>
#include <cstring>
#include <fstream>

#include "host/backends/reference_backend.hpp"

namespace {

using namespace lockstep;

template <class real>
void run_on_reference(GoldenCase& golden) {
  run_case<real>(golden,
                 [](const InitialState<real>& state) { return std::make_unique<ReferenceBackend<real>>(state); });
}

GoldenCase computed(GoldenCase golden) {
  if (golden.precision == "double")
    run_on_reference<double>(golden);
  else
    run_on_reference<float>(golden);
  return golden;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: golden HASHES.json [--update]\n");
    return 2;
  }
  const bool update = argc > 2 && std::strcmp(argv[2], "--update") == 0;
  auto cases = nlohmann::json::parse(std::ifstream(argv[1])).get<std::vector<GoldenCase>>();
  int differing = 0;
  for (GoldenCase& expected : cases) {
    const GoldenCase found = computed(expected);
    const bool equal = found.state_hash == expected.state_hash && found.pose_hash == expected.pose_hash;
    differing += !equal;
    if (!equal)
      std::printf("%s in %s after %u steps: state %s, poses %s; expected %s, %s\n", found.scene.c_str(),
                  found.precision.c_str(), found.steps, found.state_hash.c_str(), found.pose_hash.c_str(),
                  expected.state_hash.c_str(), expected.pose_hash.c_str());
    expected = found;
  }
  std::printf("%zu golden hashes, %d differ\n", cases.size(), differing);
  if (!update) return differing == 0 ? 0 : 1;

  std::ofstream file(argv[1]);
  const char* separator = "[\n  ";
  for (const GoldenCase& golden : cases) {
    file << separator << nlohmann::json(golden).dump();
    separator = ",\n  ";
  }
  file << "\n]\n";
  return 0;
}
