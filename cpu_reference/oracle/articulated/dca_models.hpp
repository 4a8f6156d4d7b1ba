// The models of Bhalerao, Anderson and Trinkle (A recursive hybrid time-stepping scheme for intermittent contact in
// multi-rigid-body dynamics, 2009; survey 3.7), as mixed complementarity problems over the unknowns x of
// reduced_pyramid.hpp and velocities w of a few bodies. What the trees between them do comes from an assembly:
//   Model-DCA-mLCP1   w: the twists of every body that is touched, and of the two terminal handles of the assembly
//   Model-DCA-mLCP2   w: the twists of the two terminal handles
//   Model-DCA-LCP     no w: ReducedPyramid::lcp()
// With the answers Y = Phi J^T of the handles and V_0 their twists without impulses, the rows of w are
// w = V_0 + Y x. In the first model contacts see w alone, u = J w, so that their rows are sparse and F is nothing but
// couplings. In the second they see the terminals and what impulses do while these are held,
//   u = K w + (W - K Y_t) x + (q - K V_0t),   K = J Phi_ct Phi_tt^+,
// dense as all in the assembly is coupled. Rows of bounds and drives, which no model of the survey has, see x alone.
// The survey writes M w in the rows of w, with the articulated inertia of the handles; that has no inverse where
// handles are jointed to each other, and so these rows are multiplied by Phi.
#pragma once

#include "cpu_reference/oracle/articulated/assembly.hpp"
#include "cpu_reference/oracle/articulated/reduced_pyramid.hpp"
#include "cpu_reference/oracle/models/friction_pyramid.hpp"

namespace lockstep::oracle::articulated {

/// The terminal handles: the root and the last leaf of the largest tree; where there is none, the first and the last
/// body that moves.
std::vector<std::size_t> terminals(const Tree& tree);

/// Bodies that move and have a contact, once each.
std::vector<std::size_t> touched(const Tree& tree, const Demand& demand);

/// `bodies`: those of w, in order; a body may stand in it twice. `problem` has them among its handles.
models::MixedLcp dca_mlcp1(const AssembledProblem& problem, const ReducedPyramid& pyramid,
                           const std::vector<std::size_t>& bodies);
models::MixedLcp dca_mlcp2(const AssembledProblem& problem, const ReducedPyramid& pyramid,
                           const std::vector<std::size_t>& terminals);

}  // namespace lockstep::oracle::articulated
