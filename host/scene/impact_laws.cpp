#include "host/scene/impact_laws.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/error.hpp"

namespace lockstep {

namespace {

const char* name_of(ImpactLaw law) { return impact_law_names[law].first; }

[[noreturn]] void refuse(const Scene& scene, const std::string& location, const std::string& what) {
  throw Error(Failure::input, scene.source + ": " + location, what);
}

void expect_range(const Scene& scene, const std::string& owner, const std::optional<double>& e) {
  if (!e || (*e >= -1 && *e <= 1)) return;
  refuse(scene, owner + "/tangential_restitution", fmt::format("must be in -1 .. 1, is {}", *e));
}

void expect_its_law(const Scene& scene, const std::string& owner, const PairLaw& pair, const std::optional<double>& e) {
  if (!e || pair.law == IMPACT_CHATTERJEE_RUINA) return;
  refuse(
      scene, owner + "/tangential_restitution",
      fmt::format("belongs to the law chatterjee_ruina, and this is {}; name that law as impact_law, or leave this out",
                  name_of(pair.law)));
}

std::optional<double> larger(const std::optional<double>& a, const std::optional<double>& b) {
  return a && b ? std::max(*a, *b) : a ? a : b;
}

}  // namespace

std::vector<PairLaw> impact_laws_of(const Scene& scene) {
  std::vector<Material> materials = scene.materials;
  if (materials.empty()) materials.emplace_back();
  const std::size_t count = materials.size();
  std::vector<PairLaw> laws(count * count);
  for (std::size_t a = 0; a < count; ++a) {
    const std::string owner = fmt::format("/materials/{}", a);
    const std::optional<double>& own = materials[a].tangential_restitution;
    expect_range(scene, owner, own);
    expect_its_law(scene, owner, {materials[a].impact_law.value_or(IMPACT_NEWTON)}, own);
    for (std::size_t b = 0; b < count; ++b) {
      PairLaw& pair = laws[a * count + b];
      pair.law =
          std::max(materials[a].impact_law.value_or(IMPACT_NEWTON), materials[b].impact_law.value_or(IMPACT_NEWTON));
      if (pair.law == IMPACT_CHATTERJEE_RUINA)
        pair.tangential_restitution = larger(own, materials[b].tangential_restitution).value_or(0);
    }
  }
  for (std::size_t i = 0; i < scene.material_pairs.size(); ++i) {
    const MaterialPairRule& rule = scene.material_pairs[i];
    const std::string owner = fmt::format("/material_pairs/{}", i);
    PairLaw pair = laws[rule.material_a * count + rule.material_b];
    if (rule.impact_law) pair = {*rule.impact_law, 0};
    expect_range(scene, owner, rule.tangential_restitution);
    expect_its_law(scene, owner, pair, rule.tangential_restitution);
    pair.tangential_restitution = rule.tangential_restitution.value_or(pair.tangential_restitution);
    laws[rule.material_a * count + rule.material_b] = laws[rule.material_b * count + rule.material_a] = pair;
  }
  return laws;
}

}  // namespace lockstep
