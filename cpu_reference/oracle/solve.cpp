#include "cpu_reference/oracle/solve.hpp"

namespace lockstep::oracle {

std::string_view stop_name(Stop stop) {
  switch (stop) {
    case Stop::tolerance: return "tolerance";
    case Stop::stall: return "stall";
    case Stop::limit: return "limit";
    case Stop::interrupted: return "interrupted";
    case Stop::infeasible: return "infeasible";
  }
  return "unknown";
}

}  // namespace lockstep::oracle
