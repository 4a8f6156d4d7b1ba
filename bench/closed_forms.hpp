// The cases of one body that have an exact answer: each is run at a time step and gives its errors. Since every backend
// computes the same bits, the errors of the reference are those of every device.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep::bench {

struct CaseError {
  std::string quantity;  // what is compared, with its unit
  double exact, error;   // the exact value, and |computed - exact|
};

struct ClosedForm {
  std::string name;
  std::vector<double> steps;  // the time steps to run at, s, coarse to fine
  std::function<std::vector<CaseError>(double dt, const std::string& precision)> run;
};

/// Every case, ordered as docs/error_measures.md lists them.
const std::vector<ClosedForm>& closed_forms();

}  // namespace lockstep::bench
