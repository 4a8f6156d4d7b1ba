// The rules of the house that no compiler checks (CONTRIBUTING.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host/stages.hpp"

namespace lockstep::house_rules_test {
namespace {

namespace fs = std::filesystem;

const fs::path root = LOCKSTEP_SOURCE_DIR;

std::string read_file(const fs::path& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// Files below `folder` whose names end in one of `endings`, relative to the root.
std::vector<std::string> files(const std::string& folder, const std::set<std::string>& endings) {
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
    if (entry.is_regular_file() && endings.count(entry.path().extension().string()))
      found.push_back(fs::relative(entry.path(), root).string());
  }
  EXPECT_FALSE(found.empty()) << folder;
  return found;
}

std::vector<std::string> sources() {
  std::vector<std::string> all;
  for (const char* folder : {"kernels", "cpu_reference", "host", "tests", "bench", "include", "python"}) {
    for (std::string& file : files(folder, {".cl", ".h", ".hpp", ".cpp", ".def"})) all.push_back(std::move(file));
  }
  return all;
}

std::string without_comments(const std::string& text) {
  return std::regex_replace(text, std::regex(R"(//[^\n]*|/\*[^]*?\*/)"), "");
}

// The words of an identifier in lower case: it is split at _ and before capitals.
std::set<std::string> words_of(const std::string& identifier) {
  std::set<std::string> words;
  std::string word;
  for (std::size_t i = 0; i <= identifier.size(); ++i) {
    const bool ends = i == identifier.size() || identifier[i] == '_' ||
                      (std::isupper(identifier[i]) && i > 0 && !std::isupper(identifier[i - 1]));
    if (ends && !word.empty()) words.insert(std::exchange(word, ""));
    if (i < identifier.size() && identifier[i] != '_') word += static_cast<char>(std::tolower(identifier[i]));
  }
  return words;
}

// All first groups of a pattern in a text.
std::vector<std::string> matches(const std::string& text, const std::string& pattern) {
  std::vector<std::string> found;
  const std::regex expression(pattern);
  for (std::sregex_iterator i(text.begin(), text.end(), expression), end; i != end; ++i) found.push_back((*i)[1]);
  return found;
}

TEST(HouseRules, EachStageIsATriple) {
  for (u32 s = 0; s < stage_count; ++s) {
    const std::string name(info(static_cast<Stage>(s)).name);
    for (const std::string& file :
         {"kernels/" + name + ".cl", "cpu_reference/" + name + ".hpp", "tests/" + name + "_test.cpp"})
      EXPECT_TRUE(fs::exists(root / file)) << file;
  }
}

TEST(HouseRules, KernelsStartWithoutContraction) {
  for (const std::string& file : files("kernels", {".cl"}))
    EXPECT_EQ(read_file(root / file).rfind("#pragma OPENCL FP_CONTRACT OFF\n", 0), 0u) << file;
}

// Contract rule 2: what is not the same on every implementation does not stand in a kernel.
TEST(HouseRules, KernelsUseNoBannedFunction) {
  const std::string banned =
      "dot|cross|length|distance|normalize|fast_\\w+|mix|mad|fma|rsqrt|fmin|fmax|fmod|hypot|native_\\w+|half_\\w+|"
      "a?sin(?:h|pi)?|sincos|a?cos(?:h|pi)?|a?tan(?:h|pi|2)?|exp\\w*|log\\w*|pow\\w*|cbrt|step|smoothstep|clamp|sign|"
      "degrees|radians|"
      "atomic_(add|sub|xchg)_float|atom_\\w+";
  for (const std::string& file : files("kernels", {".cl", ".h", ".def"})) {
    for (const std::string& name : matches(without_comments(read_file(root / file)), "\\b(" + banned + ")\\s*\\("))
      ADD_FAILURE() << file << ": " << name;
  }
}

// What the compiler of NVIDIA's driver does not take, or makes wrong code of (docs/how_to/run_on_a_gpu.md).
TEST(HouseRules, KernelsAreWithinWhatGpuDriversTake) {
  for (const std::string& file : files("kernels", {".cl", ".h"})) {
    const std::string text = without_comments(read_file(root / file));
    EXPECT_TRUE(matches(text, R"((#define[^\n]*\.\.\.))").empty()) << file << " has a macro with ...";
    EXPECT_TRUE(matches(text, R"(((?:inline|LANE_INLINE|CALLED)\b[^{;]*\bStepParams \w))").empty())
        << file << ": functions take StepParams by address";
  }
}

TEST(HouseRules, NoFileIsLong) {
  for (const std::string& file : sources()) {
    const std::string text = read_file(root / file);
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 500) << file;
  }
}

// The module of a file: its folder, but for the simulation, which stands above the backends it drives.
std::string module_of(const std::string& file) {
  if (file.rfind("host/simulation.", 0) == 0) return "simulation";
  for (const char* folder :
       {"host/scene", "host/device", "host/backends", "host/report", "host/steppers", "host/problems", "host/record",
        "host/render", "host/cases", "host/world", "host/app", "cpu_reference/oracle"})
    if (file.rfind(std::string(folder) + "/", 0) == 0) return folder;
  return file.substr(0, file.find('/'));
}

// Dependencies run one way, and siblings do not see each other.
TEST(HouseRules, ModulesIncludeDownwardsOnly) {
  const std::map<std::string, std::set<std::string>> below = {
      {"include", {}},  // the public headers include each other alone
      {"kernels", {}},
      {"host", {"include", "kernels"}},
      {"cpu_reference", {"kernels", "host"}},
      {"cpu_reference/oracle", {"host"}},  // nothing of the twins, nor they of the oracles
      {"host/scene", {"include", "kernels", "host"}},
      {"host/device", {"kernels", "host"}},
      {"host/report", {"kernels", "host"}},
      {"host/render", {"kernels", "host"}},
      {"host/backends", {"kernels", "host", "cpu_reference", "host/scene", "host/device"}},
      {"simulation", {"kernels", "host", "host/scene", "host/backends"}},
      {"host/steppers",
       {"kernels", "host", "host/scene", "host/device", "host/backends", "host/report", "cpu_reference/oracle"}},
      {"host/record", {"kernels", "host", "host/scene", "host/backends", "host/report", "host/steppers", "simulation"}},
      {"host/problems", {"host", "host/record", "cpu_reference/oracle"}},
      {"host/cases",
       {"kernels", "host", "host/scene", "host/device", "host/backends", "host/report", "host/steppers", "simulation"}},
      {"host/world",
       {"include", "kernels", "host", "host/scene", "host/device", "host/backends", "host/report", "host/steppers",
        "host/record", "simulation"}},
      {"host/app",
       {"kernels", "host", "host/scene", "host/device", "host/backends", "host/report", "host/record", "host/render",
        "host/steppers", "host/problems", "host/cases", "simulation", "cpu_reference/oracle"}},
      {"python", {"include", "kernels", "host", "host/scene", "host/device"}},
  };
  for (const std::string& file : sources()) {
    const std::string module = module_of(file);
    if (!below.count(module) || module == "kernels") continue;
    for (const std::string& included : matches(read_file(root / file), "(?:^|\\n)#include \"([^\"]+)\"")) {
      if (module == "include") {
        EXPECT_TRUE(fs::exists(root / "include/lockstep" / included)) << file << " includes " << included;
        continue;
      }
      EXPECT_TRUE(fs::exists(root / included)) << file << " includes " << included << ", not named from the root";
      const std::string other = module_of(included);
      EXPECT_TRUE(other == module || below.at(module).count(other)) << file << " includes " << included;
    }
  }
}

// Two types of one name in one namespace are one to the linker, which takes the functions of either for both.
TEST(HouseRules, ATypeOfAHeaderHasOneHome) {
  std::map<std::string, std::string> homes;
  for (const char* folder : {"host", "include"}) {
    for (const std::string& file : files(folder, {".hpp"})) {
      for (const std::string& type : matches(read_file(root / file), R"(\n(?:struct|class) ([\w:]*\w)[^;{]*\{)")) {
        const auto [home, is_new] = homes.emplace(type, file);
        EXPECT_TRUE(is_new) << type << " is in " << home->second << " and in " << file;
      }
    }
  }
  EXPECT_GT(homes.size(), 100u);
}

// Words that stood for several things each, or for what the field has another term for (docs/reference/glossary.md).
// Prose may use them.
TEST(HouseRules, IdentifiersAreTermsOfTheField) {
  const std::set<std::string> refused = {"turn",  "turns",  "turned",  "turning", "spin",    "spins",   "spinning",
                                         "visit", "visits", "visited", "visitor", "now",     "stand",   "stands",
                                         "stood", "rub",    "rubs",    "rubbing", "way",     "ways",    "hold",
                                         "holds", "held",   "holding", "grain",   "grains",  "lever",   "levers",
                                         "reach", "place",  "places",  "placed",  "placing", "apart",   "part",
                                         "parts", "loose",  "drowsy",  "kick",    "aim",     "renaming"};
  // of other libraries
  const std::set<std::string> accepted = {"RTLD_NOW", "solveInPlace", "reverseInPlace"};
  const std::regex identifier(R"([A-Za-z_]\w*)");
  // texts, readings of clocks, and old names that are kept for a release
  const std::regex others(R"re("(?:\\.|[^"\\\n])*"|::now\b|[^\n]*\[\[deprecated[^\n]*)re");
  for (const std::string& file : sources()) {
    if (file == "tests/house_rules_test.cpp" || file == "host/scene/renamed_keys.def") continue;
    const std::string text = std::regex_replace(without_comments(read_file(root / file)), others, "");
    std::set<std::string> seen;
    for (std::sregex_iterator i(text.begin(), text.end(), identifier), end; i != end; ++i) seen.insert(i->str());
    for (const std::string& name : seen) {
      if (accepted.count(name)) continue;
      for (const std::string& word : words_of(name))
        EXPECT_FALSE(refused.count(word))
            << file << ": " << name << "; docs/reference/glossary.md has the term for " << word;
    }
  }
}

// A comment that cites the contract names rules that its page lists.
TEST(HouseRules, CitedContractRulesExist) {
  const std::string page = read_file(root / "docs/theory/bit_exactness.md");
  const std::size_t first = page.find("\n## The contract\n"), last = page.find("\n## ", first + 1);
  ASSERT_NE(last, std::string::npos);
  std::set<std::string> rules;
  for (const std::string& rule : matches(page.substr(first, last - first), R"(\n(\d+)\. )")) rules.insert(rule);
  EXPECT_GE(rules.size(), 8u);
  std::size_t cited = 0;
  for (const std::string& file : sources()) {
    const std::string text = std::regex_replace(read_file(root / file), std::regex(R"(\s*\n\s*//+\s*)"), " ");
    for (const std::string& list : matches(text, R"([Cc]ontract rules? (\d+(?:(?:,| and| to|, and) \d+)*))")) {
      for (const std::string& rule : matches(list, R"((\d+))")) {
        ++cited;
        EXPECT_TRUE(rules.count(rule)) << file << " cites contract rule " << rule;
      }
    }
  }
  EXPECT_GT(cited, 0u);
}

TEST(HouseRules, KernelsIncludeKernels) {
  for (const std::string& file : files("kernels", {".cl", ".h"})) {
    for (const std::string& included : matches(read_file(root / file), "(?:^|\\n)#include \"([^\"]+)\""))
      EXPECT_TRUE(fs::exists(root / "kernels" / included)) << file << " includes " << included;
  }
}

// What the page of the library shows is an example that the tests build, but for its first line of comment.
TEST(HouseRules, ThePageOfTheLibraryShowsATestedExample) {
  std::string example = read_file(root / "examples/watch_a_scene.cpp");
  example.erase(0, example.find('\n') + 1);
  EXPECT_NE(read_file(root / "docs/tutorials/library.md").find("```cpp\n" + example + "```"), std::string::npos);
}

// So does that of the Python module.
TEST(HouseRules, ThePageOfPythonShowsATestedExample) {
  const std::string page = read_file(root / "docs/tutorials/python.md");
  for (const char* file : {"examples/drop_and_watch.py", "examples/balance_a_pole.py"}) {
    const std::string example = read_file(root / file);
    EXPECT_NE(page.find("```python\n" + example + "```"), std::string::npos) << file;
  }
}

TEST(HouseRules, TheTutorialOfASolverShowsATestedOne) {
  const std::string page = read_file(root / "docs/tutorials/add_a_solver.md");
  for (const char* file : {"examples/symmetric_pgs.hpp", "tests/oracle/symmetric_pgs_test.cpp"}) {
    std::size_t shown = 0;
    const std::string code = read_file(root / file);
    for (const std::string& block : matches(page, "```cpp\n([^`]*)```")) shown += code.find(block) != std::string::npos;
    EXPECT_EQ(shown, 1u) << file;
  }
}

// Kinds without a table stand twice, for kernels and for users; those of tables are compared by
// host/scene/settings.cpp.
TEST(HouseRules, KindsAreThoseOfTheKernels) {
  const auto kinds = [](const char* file) {
    std::set<std::string> all;
    for (const std::string& kind : matches(read_file(root / file), R"(\b((?:BODY|EVENT|IMPACT)_[A-Z_]+ = \d+))"))
      all.insert(kind);
    return all;
  };
  const std::set<std::string> in_kernels = kinds("kernels/types.h");
  EXPECT_EQ(in_kernels, kinds("include/lockstep/types.hpp"));
  EXPECT_EQ(in_kernels.size(), 14u);
}

// What CI runs here it runs in public: each command of .ci/run is a step of the workflow.
TEST(HouseRules, TheWorkflowRunsWhatCiRuns) {
  const std::string workflow = read_file(root / ".github/workflows/ci.yml");
  const std::vector<std::string> commands = matches(read_file(root / ".ci/run"), R"(\n((?:scripts|tests)/[^\n]+))");
  EXPECT_GE(commands.size(), 4u);
  for (const std::string& command : commands)
    EXPECT_NE(workflow.find("- run: " + command + "\n"), std::string::npos) << command << " is not in the workflow";
}

// One version in all files that name it.
TEST(HouseRules, FilesNameOneVersion) {
  const std::vector<std::string> version =
      matches(read_file(root / "CMakeLists.txt"), R"(project\(lockstep VERSION (\S+))");
  ASSERT_EQ(version.size(), 1u);
  EXPECT_NE(read_file(root / "CITATION.cff").find("\nversion: " + version[0] + "\n"), std::string::npos);
  EXPECT_NE(read_file(root / "CHANGELOG.md").find("\n## " + version[0] + "\n"), std::string::npos);
}

std::size_t code_points(const std::string& line) {
  return static_cast<std::size_t>(std::ranges::count_if(line, [](char c) { return (c & 0xc0) != 0x80; }));
}

// What sites call the headings of a page: in lower case, words and hyphens.
std::set<std::string> anchors_of(const std::string& page) {
  std::set<std::string> anchors;
  for (const std::string& heading : matches(page, R"(\n#+ ([^\n]+))")) {
    std::string name;
    for (const char c : heading) {
      if (std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-')
        name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      else if (c == ' ')
        name += '-';
    }
    anchors.insert(name);
  }
  return anchors;
}

// A path in the text of a document: a link, or a name in backticks that starts with a folder of the project. Names with
// <placeholders> stand for many.
TEST(HouseRules, DocumentsNameFilesThatExist) {
  std::vector<std::string> documents = files("docs", {".md"});
  for (const char* name : {"README.md", "CONTRIBUTING.md", "CHANGELOG.md"}) documents.push_back(name);
  const std::regex anchor(R"(\]\(([^)#:\s]*)#([^)]+)\))");
  const std::string folders =
      "(?:\\.ci|bench|cmake|cpu_reference|docs|examples|host|kernels|python|scenes|scripts|tests)";
  for (const std::string& document : documents) {
    ASSERT_TRUE(fs::exists(root / document)) << document;
    const std::string text = read_file(root / document);
    for (const std::string& path : matches(text, "`(" + folders + "/[^`\\s<>*]*)`"))
      EXPECT_TRUE(fs::exists(root / path)) << document << " names " << path;
    for (const std::string& path : matches(text, R"(`(\w+\.(?:md|txt|json))`)"))
      EXPECT_TRUE(fs::exists(root / path)) << document << " names " << path;
    for (const std::string& link : matches(text, R"(\]\(([^)#:\s]+)(?:#[^)]*)?\))"))
      EXPECT_TRUE(fs::exists(root / fs::path(document).parent_path() / link)) << document << " links to " << link;
    // and the heading behind a #, as sites call it
    for (std::sregex_iterator i(text.begin(), text.end(), anchor), end; i != end; ++i) {
      const fs::path page =
          (*i)[1].length() == 0 ? fs::path(document) : fs::path(document).parent_path() / (*i)[1].str();
      EXPECT_TRUE(anchors_of(read_file(root / page)).count((*i)[2])) << document << " links to #" << (*i)[2];
    }
  }
}

// Pages that can be read in one sitting, in lines that any window shows. Pictures and code may name what is longer.
TEST(HouseRules, PagesAreShortAndNarrow) {
  std::vector<std::string> documents = files("docs", {".md"});
  documents.push_back("README.md");
  for (const std::string& document : documents) {
    std::istringstream lines(read_file(root / document));
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count)
      EXPECT_LE(code_points(line), 120u) << document << ":" << count + 1;
    EXPECT_LE(count, document == "README.md" ? 80 : 250) << document;
  }
}

// Each page is in the menu of the site (mkdocs.yml).
TEST(HouseRules, TheSiteHasEachPage) {
  const std::string site = read_file(root / "mkdocs.yml");
  for (const std::string& page : files("docs", {".md"}))
    EXPECT_NE(site.find(": " + page.substr(5) + "\n"), std::string::npos) << page << " is not in mkdocs.yml";
}

}  // namespace
}  // namespace lockstep::house_rules_test
