// The contacts of the last step, wherever it was computed.
#pragma once

#include <span>
#include <vector>

#include "host/backends/backend.hpp"
#include "host/scene/reported_contact.hpp"

namespace lockstep {

/// Those of the step, and what sleepers last carried, ordered by their shapes; nothing where shapes cannot touch.
/// `shapes` are those that the backend simulates, `described` as which; `params` and `counters` are those of the step.
template <class real>
std::vector<ReportedContact> reported_contacts(Backend<real>& backend, const StepParams<real>& params,
                                               const Counters& counters, std::span<const ShapeInfo> shapes,
                                               const DescribedShapes& described);

}  // namespace lockstep
