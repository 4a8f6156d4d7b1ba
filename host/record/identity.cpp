#include "host/record/identity.hpp"

#include "host/record/content_hash.hpp"
#include "host/record/layout.hpp"
#include "host/record/stored_name.hpp"

namespace lockstep {

namespace {

template <class real>
void hash_buffers(ContentHash& hash, const Buffers<real>& buffers, Lifetime lifetime) {
  for_each_buffer(buffers, [&](Buffer buffer, const auto& elements) {
    if (info(buffer).lifetime != lifetime || elements.empty()) return;
    hash.add(stored_name(buffer));
    hash.add(elements.data(), rows_in_use(buffer, buffers, elements.size()) * sizeof(elements[0]));
  });
}

}  // namespace

template <class real>
SceneIdentity identity_of(const InitialState<real>& state, OracleIs oracle) {
  ContentHash settings, constants;
  settings.add(sizeof(real));
  settings.add(state.features & ~static_cast<Features>(Feature::summed_impulses));  // which tell, and change nothing
  for_each_setting(state.params, [&](const char*, auto value) { settings.add(&value, sizeof(value)); });
  if (state.oracle && oracle == OracleIs::counted) {
    settings.add(state.oracle.name);
    settings.add(state.oracle.directions);
  }
  hash_buffers(constants, state.buffers, Lifetime::constant);
  return {settings.value(), constants.value()};
}

template <class real>
std::uint64_t persistent_hash(const Buffers<real>& buffers) {
  ContentHash hash;
  hash_buffers(hash, buffers, Lifetime::persistent);
  return hash.value();
}

template SceneIdentity identity_of<float>(const InitialState<float>&, OracleIs);
template SceneIdentity identity_of<double>(const InitialState<double>&, OracleIs);
template std::uint64_t persistent_hash<float>(const Buffers<float>&);
template std::uint64_t persistent_hash<double>(const Buffers<double>&);

}  // namespace lockstep
