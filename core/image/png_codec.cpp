#include <png.h>

#include <csetjmp>
#include <cstring>
#include <vector>

#include "core/base/check.h"
#include "core/image/codecs.h"
#include "core/image/formats.h"

namespace lightbatch::image {
namespace {

/// What libpng's callbacks see. libpng leaves by longjmp, so nothing with a destructor may be
/// created between setjmp and the last libpng call: all storage lives here, made beforehand.
struct PngRead {
  std::span<const std::byte> bytes;
  std::size_t offset = 0;
  std::string error;
  bool truncated = false;
  int width = 0;
  int height = 0;
  Image8 image;
  std::vector<png_bytep> rows;
};

void read_bytes(png_structp png, png_bytep out, std::size_t count) {
  auto* state = static_cast<PngRead*>(png_get_io_ptr(png));
  if (count > state->bytes.size() - state->offset) {
    state->truncated = true;
    png_error(png, "the data ends too early");
  }
  std::memcpy(out, state->bytes.data() + state->offset, count);
  state->offset += count;
}

void on_read_error(png_structp png, png_const_charp message) {
  static_cast<PngRead*>(png_get_error_ptr(png))->error = message;
  std::longjmp(png_jmpbuf(png), 1);  // NOLINT(cert-err52-cpp): libpng's only way out
}

void on_warning(png_structp, png_const_charp) {}

/// Header only: size, and the transformations that make every PNG 8-bit RGBA. glTF 3.9.2 asks to
/// ignore gamma and profile chunks, so no colour transformation is set.
bool read_header(png_structp png, png_infop info, PngRead* state) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT(cert-err52-cpp)
  png_set_read_fn(png, state, read_bytes);
  png_set_user_limits(png, 65535, 65535);
  png_read_info(png, info);
  state->width = static_cast<int>(png_get_image_width(png, info));
  state->height = static_cast<int>(png_get_image_height(png, info));
  png_set_scale_16(png);
  png_set_expand(png);
  png_set_gray_to_rgb(png);
  png_set_add_alpha(png, 0xff, PNG_FILLER_AFTER);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != 4 * static_cast<std::size_t>(state->width)) {
    png_error(png, "the rows do not turn into RGBA");
  }
  return true;
}

bool read_pixels(png_structp png, png_infop info, PngRead* state) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT(cert-err52-cpp)
  png_read_image(png, state->rows.data());
  png_read_end(png, info);
  return true;
}

struct PngWrite {
  Bytes bytes;
};

void write_bytes(png_structp png, png_bytep data, std::size_t count) {
  auto* state = static_cast<PngWrite*>(png_get_io_ptr(png));
  const auto* first = reinterpret_cast<const std::byte*>(data);
  state->bytes.insert(state->bytes.end(), first, first + count);
}

void on_write_error(png_structp, png_const_charp message) { LB_CHECK(false, message); }

}  // namespace

Result<ImageSize> read_png_size(std::span<const std::byte> bytes, const std::string& place) {
  // After the signature of 8 bytes comes IHDR: length, name, width, height, both big-endian.
  const auto number = [&bytes](std::size_t at) {
    std::int64_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      value = value << 8 | std::to_integer<std::int64_t>(bytes[at + i]);
    }
    return value;
  };
  if (bytes.size() < 24 || as_text(bytes).substr(12, 4) != "IHDR") {
    return malformed(place, "broken PNG: no header");
  }
  const std::int64_t width = number(16);
  const std::int64_t height = number(20);
  LB_RETURN_IF_ERROR(check_size(width, height, ~std::uint64_t{0}, place));
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

Result<Image8> decode_png(std::span<const std::byte> bytes, const std::string& place,
                          std::uint64_t max_pixels) {
  PngRead state;
  state.bytes = bytes;
  png_structp png =
      png_create_read_struct(PNG_LIBPNG_VER_STRING, &state, on_read_error, on_warning);
  LB_CHECK(png != nullptr, "libpng cannot start");
  png_infop info = png_create_info_struct(png);
  LB_CHECK(info != nullptr, "libpng cannot start");

  Status status;
  if (!read_header(png, info, &state)) {
    status = malformed(place, "broken PNG: " + state.error);
  } else {
    status = check_size(state.width, state.height, max_pixels, place);
  }
  if (status.ok()) {
    const std::size_t row_bytes = 4 * static_cast<std::size_t>(state.width);
    state.image.width = state.width;
    state.image.height = state.height;
    state.image.rgba.resize(row_bytes * static_cast<std::size_t>(state.height));
    for (int y = 0; y < state.height; ++y) {
      state.rows.push_back(state.image.rgba.data() + row_bytes * static_cast<std::size_t>(y));
    }
    if (!read_pixels(png, info, &state)) status = malformed(place, "broken PNG: " + state.error);
  }
  png_destroy_read_struct(&png, &info, nullptr);
  if (!status.ok()) return status;
  return std::move(state.image);
}

Bytes encode_png(const Image8& image, bool alpha) {
  LB_CHECK(image.width > 0 && image.height > 0, "an image needs pixels");
  PngWrite state;
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, on_write_error, on_warning);
  LB_CHECK(png != nullptr, "libpng cannot start");
  png_infop info = png_create_info_struct(png);
  LB_CHECK(info != nullptr, "libpng cannot start");
  png_set_write_fn(png, &state, write_bytes, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width),
               static_cast<png_uint_32>(image.height), 8,
               alpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  // Fixed settings: the same pixels give the same bytes.
  png_set_compression_level(png, 6);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_ALL_FILTERS);
  png_write_info(png, info);
  if (!alpha) png_set_filler(png, 0, PNG_FILLER_AFTER);
  for (int y = 0; y < image.height; ++y) png_write_row(png, image.pixel(0, y));
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return std::move(state.bytes);
}

}  // namespace lightbatch::image
