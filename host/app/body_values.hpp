// A number for each body, to colour it by.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/backends/backend.hpp"

namespace lockstep::app {

enum class ColorBy { body, speed, contacts, color, penetration, residual };
inline constexpr std::pair<const char*, ColorBy> color_by_names[] = {{"body", ColorBy::body},
                                                                     {"speed", ColorBy::speed},
                                                                     {"contacts", ColorBy::contacts},
                                                                     {"color", ColorBy::color},
                                                                     {"penetration", ColorBy::penetration},
                                                                     {"residual", ColorBy::residual}};

/// What a number means, with its unit.
std::string title_of(ColorBy by);
/// Whether it takes more than what a recording holds.
bool needs_contacts(ColorBy by);

/// What body_values() reads in a scene of these features.
std::vector<Buffer> value_buffers(ColorBy by, Features features);

/// A number a body; NaN where a body touches nothing and it takes a contact.
///   speed        of the centre of mass, m/s
///   contacts     points at which it touches others
///   color        the last colour in which the solver solves one of its contacts
///   penetration  the deepest, mm
///   residual     the largest defect velocity of its contacts and joints (docs/reference/error_measures.md), m/s
template <class real>
std::vector<float> body_values(ColorBy by, const Buffers<real>& buffers, u32 bodies, Features features,
                               const Counters& counters);

}  // namespace lockstep::app
