// The constraint system of a scene's step as the oracles' models take it.
#pragma once

#include "cpu_reference/oracle/models/multibody.hpp"
#include "host/report/contact_system.hpp"

namespace lockstep {

/// Velocities become those without the impulses of the solve. Contacts keep their order, joints give one row for each
/// locked direction, and a dry row where they have friction. Throws Error for what these models do not have: contacts
/// that form friction patches, springs in joints, motors, limits.
oracle::models::Multibody multibody(const ContactSystem& system);

}  // namespace lockstep
