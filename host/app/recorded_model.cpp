#include "host/app/recorded_model.hpp"

#include "host/error.hpp"
#include "host/scene/read.hpp"

namespace lockstep::app {

template <class real>
SceneModel recorded_model(const InitialState<real>& start, const RecordingLabel& label, Shown shown) {
  if (!has(start.features, Feature::contacts)) {
    try {
      const Buffers<real> shapes = compile_shapes<real>(parse_scene(label.scene_text, label.scene), shown);
      if (shapes.body_infos.size() == start.buffers.body_infos.size()) return SceneModel(shapes);
    } catch (const Error&) {
      // a mesh of the scene may be somewhere else by now: bodies are drawn by their moments
    }
  }
  return SceneModel(start.buffers);
}

template SceneModel recorded_model(const InitialState<float>&, const RecordingLabel&, Shown);
template SceneModel recorded_model(const InitialState<double>&, const RecordingLabel&, Shown);

}  // namespace lockstep::app
