// What a solve of a constraint is for. The solver's sweeps solve its law as prepared; the relaxing sweep
// (cpu_reference/relax_constraints.hpp) solves it hard and without corrections where it is soft.
#pragma once

namespace lockstep::reference {

enum class Purpose { solve, relax };

}  // namespace lockstep::reference
