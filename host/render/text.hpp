// Text on a picture: the printable characters of ASCII, in any size.
#pragma once

#include <string_view>

#include "host/render/picture.hpp"

namespace lockstep {

/// Width in pixels of a line whose capital letters are `height` pixels high.
double text_width(std::string_view text, double height);

/// Draws a line of text; (x, y) is the top left corner of its capital letters. Characters that are not there become
/// question marks.
void draw_text(Picture& picture, double x, double y, double height, const Color& color, std::string_view text);

}  // namespace lockstep
