// Prints, as CSV, the error of every closed form at each time step and the order seen between one step and the next.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <exception>

#include "bench/closed_forms.hpp"

int main() try {
  fmt::print("case,precision,quantity,exact,dt_s,error,order\n");
  for (const auto& form : lockstep::bench::closed_forms()) {
    for (const char* precision : {"float", "double"}) {
      std::vector<lockstep::bench::CaseError> coarse;
      double coarse_dt = 0;
      for (const double dt : form.steps) {
        const auto errors = form.run(dt, precision);
        for (std::size_t i = 0; i < errors.size(); ++i) {
          const auto& e = errors[i];
          // an order means nothing where the error is rounding
          const double rounding = (precision[0] == 'f' ? 1e-6 : 1e-13) * std::abs(e.exact);
          const bool measurable = !coarse.empty() && e.error > rounding && coarse[i].error > rounding;
          fmt::print(
              "{},{},{},{:.9g},{},{:.3g},{}\n", form.name, precision, e.quantity, e.exact, dt, e.error,
              measurable ? fmt::format("{:.2f}", std::log(coarse[i].error / e.error) / std::log(coarse_dt / dt)) : "");
        }
        coarse = errors;
        coarse_dt = dt;
      }
    }
  }
} catch (const std::exception& error) {
  fmt::print(stderr, "closed_forms_bench: {}\n", error.what());
  return 2;
}
