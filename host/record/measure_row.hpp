// A row of the table `measures`.
#pragma once

#include "host/record/recording.hpp"
#include "host/report/measures.hpp"

namespace lockstep {

MeasureRow measure_row(u32 step, const Measures& measures);

}  // namespace lockstep
