#include "host/render/picture.hpp"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "host/error.hpp"

namespace lockstep {

namespace {

// Frames are many and look at what is beside a pixel: a higher level takes twice the time for a tenth of the bytes.
constexpr int png_level = 4;

// What libpng calls with what it has made; it is in C, and catches nothing.
void append(png_structp png, png_bytep data, std::size_t count) {
  auto* bytes = static_cast<std::vector<unsigned char>*>(png_get_io_ptr(png));
  try {
    bytes->insert(bytes->end(), data, data + count);
  } catch (const std::bad_alloc&) {
    png_error(png, "out of memory");
  }
}

// Writing to memory fails where there is no more of it.
[[noreturn]] void fail(png_structp, png_const_charp what) {
  throw Error(Failure::device, "render", std::string("no PNG can be made: ") + what);
}

}  // namespace

void Picture::blend(int x, int y, const Color& color, double alpha) {
  if (x < 0 || y < 0 || x >= static_cast<int>(width) || y >= static_cast<int>(height) || alpha <= 0) return;
  unsigned char* pixel = at(static_cast<u32>(x), static_cast<u32>(y));
  for (int i = 0; i < 3; ++i) {
    const double mixed = pixel[i] + std::min(alpha, 1.0) * (255 * double(color[i]) - pixel[i]);
    pixel[i] = static_cast<unsigned char>(std::lround(std::clamp(mixed, 0.0, 255.0)));
  }
}

void Picture::fill(int x0, int y0, int x1, int y1, const Color& color, double alpha) {
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) blend(x, y, color, alpha);
  }
}

std::vector<unsigned char> encode_png(const Picture& picture) {
  std::vector<unsigned char> bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, nullptr);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info == nullptr) throw std::bad_alloc();
  png_set_write_fn(png, &bytes, append, nullptr);
  png_set_IHDR(png, info, picture.width, picture.height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(png, png_level);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB | PNG_FILTER_UP);
  png_write_info(png, info);
  for (u32 y = 0; y < picture.height; ++y) png_write_row(png, picture.at(0, y));
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

}  // namespace lockstep
