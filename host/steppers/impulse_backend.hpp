// Impulse-based error correction (Bender, Finkenzeller, Schmitt 2005; Bender and Schmitt, Constraint-based collision
// and contact handling using impulses, 2006; survey 4.4.1): impulses are found from what the joints will be at the end
// of the sub-step, not from what their velocities are at its start. In a sub-step of length h
//   predict    the poses at its end, with the velocities as they are
//   measure    the gap d of each joint there
//   solve      R dl = -d / h: the impulses at the start that change the velocities so that the gap closes, directly by
//              the tree of bodies and joints (cpu_reference/oracle/joints/joint_ldlt.hpp), loops and all
// is repeated until all gaps are closed; the equation is linear in first order only. Impulses act along the axes and at
// the points of the sub-step's start, so that the positions are those of SHAKE (Ryckaert, Ciccotti, Berendsen 1977).
// That is explicit in what tension does to links that turn across it, and shares the limit of the leapfrog scheme,
// h w < 2: a chain of links of length l and moment of inertia I (across, about their centres) under a tension T bends
// to and fro with up to w = sqrt(T l / I), each link against the next about centres that stand still, so that T has to
// stay below 4 I / (h^2 l). Beyond that it grows, and soon no impulse closes the joints.
// Contacts, limits and motors are inequalities beside it: sweeps over them and the direct solve of the joints in turn
// (joints/mixed.hpp), in each repetition. Limits of joints are met by the coordinate at the end as well.
#pragma once

#include "host/steppers/oracle_backend.hpp"

namespace lockstep {

inline constexpr const char* impulse_based = "impulse_based";

/// Joints are closed to 1e-11 m and rad at the end of each sub-step, but those that are soft on purpose, and springs:
/// they keep their law. Where that cannot be had the sub-step counts as unsolved, and has the impulses of the
/// prediction with the smallest gap. The residual in the report is that of
/// the last system solved. For states of an integrator that moves bodies by their new velocities: not explicit Euler,
/// which is refused by the first step (Error, input).
class ImpulseBackend final : public OracleBackend {
 public:
  explicit ImpulseBackend(InitialState<double> state, bool profile = false)
      : OracleBackend(std::move(state), {}, profile) {}

 private:
  void work(Stage stage, const StepParams<double>& params) override;
  oracle::SolveReport solve_system(ContactSystem& system, const StepParams<double>& params,
                                   const std::string& where) override;
  std::vector<JointBlock<double>> predict(const StepParams<double>& params);
};

}  // namespace lockstep
