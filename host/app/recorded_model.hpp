// The bodies of a recording, to be drawn.
#pragma once

#include "host/record/recording.hpp"
#include "host/render/scene_model.hpp"
#include "host/scene/compile.hpp"

namespace lockstep::app {

/// From what the run began with; shapes that were not simulated are those of the scene's text, where it can be read.
template <class real>
SceneModel recorded_model(const InitialState<real>& start, const RecordingLabel& label, Shown shown = Shown::shapes);

}  // namespace lockstep::app
