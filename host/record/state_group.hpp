// What a simulation starts from, as groups of HDF5: its constant buffers and settings, and its state. A dataset a
// buffer, records x words, bit for bit.
#pragma once

#include "host/record/hdf5.hpp"
#include "host/scene/compile.hpp"

namespace lockstep {

/// What a file says its numbers are: "float" or "double". Throws h5::Failed for anything else.
std::string read_precision(hid_t file);

/// The constant buffers, the features, the settings and the oracle: what does not change while a scene is simulated.
template <class real>
void write_constants(hid_t group, const InitialState<real>& state);

/// The scene that was written, every list with room for a first step; throws h5::Failed for what is none. The state is
/// empty yet.
template <class real>
InitialState<real> read_constants(hid_t group);

/// The oracle among them, if there is one.
OracleChoice read_oracle(hid_t group);

/// The persistent buffers, as far as they are in use.
template <class real>
void write_persistent(hid_t group, const Buffers<real>& buffers, Features features);

/// Reads them into a state of the same scene, making room where the lists are longer. Throws h5::Failed where the shape
/// of one is not that of the scene.
template <class real>
void read_persistent(hid_t group, InitialState<real>& state);

}  // namespace lockstep
