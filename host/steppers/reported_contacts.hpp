// The contacts of the last step, wherever it was computed.
#pragma once

#include <span>
#include <vector>

#include "host/backends/backend.hpp"
#include "host/contact_geometry.hpp"
#include "host/scene/reported_contact.hpp"

namespace lockstep {

/// A contact as it is simulated, world frame.
struct StepContact {
  u32 body_a, body_b, shape_a, shape_b;
  ContactGeometry geometry;
  Eigen::Vector3d impulse;  // on body a in impulse_time(), N s
};

/// Those of the step, and what sleepers last carried, ordered by their shapes; nothing where shapes cannot touch.
/// `shapes` are those that the backend simulates; `params` and `counters` are those of the step.
template <class real>
std::vector<StepContact> step_contacts(Backend<real>& backend, const StepParams<real>& params, const Counters& counters,
                                       std::span<const ShapeInfo> shapes);

/// The same by bodies and shapes as they were `described`.
template <class real>
std::vector<ReportedContact> reported_contacts(Backend<real>& backend, const StepParams<real>& params,
                                               const Counters& counters, std::span<const ShapeInfo> shapes,
                                               const DescribedShapes& described);

}  // namespace lockstep
