#include "host/render/legend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/render/text.hpp"

namespace lockstep {

namespace {

constexpr Color ink = {0.13f, 0.15f, 0.18f}, paper = {1, 1, 1};
constexpr double paper_alpha = 0.78;

// Sizes in pixels that follow from that of the picture.
struct Layout {
  double text, number, line, pad;
  explicit Layout(const Picture& picture)
      : text(std::clamp(picture.height / 52.0, 7.0, 40.0)), number(0.85 * text), line(1.75 * text), pad(0.9 * text) {}
};

int whole(double x) { return static_cast<int>(std::lround(x)); }

std::vector<double> ticks(const Legend::Scale& scale) {
  const double range = scale.high - scale.low;
  const double step = scale.whole ? std::max(std::ceil(range / 5), 1.0) : range / 4;
  std::vector<double> at;
  for (int i = 0; i * step <= range * (1 + 1e-9); ++i) at.push_back(scale.low + i * step);
  return at;
}

std::string label(const Legend::Scale& scale, double value) {
  return fmt::format("{:.4g}{}", value, scale.exceeded && value >= scale.high * (1 - 1e-9) ? "+" : "");
}

double widest_label(const Legend::Scale& scale, const Layout& layout) {
  double width = 0;
  for (const double value : ticks(scale)) width = std::max(width, text_width(label(scale, value), layout.number));
  return width;
}

// Low values on the left, a mark and a number at each tick.
PixelRect draw_scale(Picture& picture, const Legend::Scale& scale, const Layout& layout, int x0, int y0, int width) {
  const PixelRect bar = {x0, y0, x0 + width, y0 + whole(1.1 * layout.text)};
  for (int x = bar.x0; x < bar.x1; ++x) picture.fill(x, bar.y0, x + 1, bar.y1, scale_color((x - bar.x0 + 0.5) / width));
  for (const double value : ticks(scale)) {
    const double share = scale.high > scale.low ? (value - scale.low) / (scale.high - scale.low) : 0;
    const double x = bar.x0 + share * (width - 1);
    picture.fill(whole(x), bar.y1, whole(x) + 1, bar.y1 + whole(0.4 * layout.text), ink);
    const std::string text = label(scale, value);
    draw_text(picture, x - 0.5 * text_width(text, layout.number), bar.y1 + 0.65 * layout.text, layout.number, ink,
              text);
  }
  return bar;
}

void draw_entry(Picture& picture, const Legend::Entry& entry, const Layout& layout, int x0, int y0) {
  const int side = whole(1.1 * layout.text);
  int x = x0;
  for (const Color& color : entry.colors) {
    picture.fill(x, y0, x + side, y0 + side, color);
    x += side;
  }
  draw_text(picture, x + 0.6 * layout.text, y0 + 0.05 * layout.text, layout.text, ink, entry.text);
}

}  // namespace

double round_scale(double value) {
  if (!(value > 0) || !std::isfinite(value)) return 1;
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 2.5, 5.0}) {
    if (value <= step * power * (1 + 1e-9)) return step * power;
  }
  return 10 * power;
}

PixelRect draw_legend(Picture& picture, const Legend& legend) {
  const Layout layout(picture);
  double width = text_width(legend.title, layout.text), number = 0;
  if (legend.scale) {
    number = widest_label(*legend.scale, layout);
    const double gaps = static_cast<double>(ticks(*legend.scale).size()) - 1;
    width = std::max({width, 15 * layout.text, gaps * (number + 0.8 * layout.text)});
  }
  for (const Legend::Entry& entry : legend.entries) {
    const double swatches = static_cast<double>(entry.colors.size()) * 1.1 * layout.text + 0.6 * layout.text;
    width = std::max(width, swatches + text_width(entry.text, layout.text));
  }
  double height = layout.text + (legend.scale ? layout.line + 1.5 * layout.text : 0) +
                  layout.line * static_cast<double>(legend.entries.size());
  const double side = layout.pad + 0.5 * number;  // half of a number stands out at either end of its scale
  const int x1 = static_cast<int>(picture.width) - whole(layout.pad), y0 = whole(layout.pad);
  const int x0 = x1 - whole(width + 2 * side);
  picture.fill(x0, y0, x1, y0 + whole(height + 2 * layout.pad), paper, paper_alpha);
  double y = y0 + layout.pad;
  const int left = x0 + whole(side);
  draw_text(picture, left, y, layout.text, ink, legend.title);
  y += layout.line;
  PixelRect bar;
  if (legend.scale) {
    bar = draw_scale(picture, *legend.scale, layout, left, whole(y), whole(width));
    y += layout.line + 1.5 * layout.text;
  }
  for (const Legend::Entry& entry : legend.entries) {
    draw_entry(picture, entry, layout, left, whole(y));
    y += layout.line;
  }
  return bar;
}

void draw_caption(Picture& picture, const std::vector<std::string>& lines) {
  if (lines.empty()) return;
  const Layout layout(picture);
  double width = 0;
  for (const std::string& line : lines) width = std::max(width, text_width(line, layout.text));
  const double height = layout.text + layout.line * static_cast<double>(lines.size() - 1);
  const int x0 = whole(layout.pad), y1 = static_cast<int>(picture.height) - whole(layout.pad);
  const int y0 = y1 - whole(height + 2 * layout.pad);
  picture.fill(x0, y0, x0 + whole(width + 2 * layout.pad), y1, paper, paper_alpha);
  double y = y0 + layout.pad;
  for (const std::string& line : lines) {
    draw_text(picture, x0 + layout.pad, y, layout.text, ink, line);
    y += layout.line;
  }
}

}  // namespace lockstep
