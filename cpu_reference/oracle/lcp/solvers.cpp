#include "cpu_reference/oracle/lcp/solvers.hpp"

#include <array>

namespace lockstep::oracle::lcp {

std::span<const NamedSolver> solvers() {
  static constexpr std::array<NamedSolver, 12> all = {{{"enumeration", enumeration, true},
                                                       {"lemke", lemke, true},
                                                       {"keller", keller, true},
                                                       {"baraff", baraff, true},
                                                       {"murty", murty, true},
                                                       {"jacobi", projected_jacobi, false},
                                                       {"damped_jacobi", damped_jacobi, false},
                                                       {"pgs", pgs, false},
                                                       {"psor", psor, false},
                                                       {"pgs_sm", pgs_sm, false},
                                                       {"nncg", nncg, false},
                                                       {"fischer_newton", fischer_newton, false}}};
  return all;
}

std::span<const NamedBoxedSolver> boxed_solvers() {
  static constexpr std::array<NamedBoxedSolver, 8> all = {{{"baraff", baraff, true},
                                                           {"jacobi", projected_jacobi, false},
                                                           {"damped_jacobi", damped_jacobi, false},
                                                           {"pgs", pgs, false},
                                                           {"psor", psor, false},
                                                           {"pgs_sm", pgs_sm, false},
                                                           {"nncg", nncg, false},
                                                           {"fischer_newton", fischer_newton, false}}};
  return all;
}

}  // namespace lockstep::oracle::lcp
