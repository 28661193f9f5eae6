#include "core/image/formats.h"

// clang-format off
#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <vector>

#include <jpeglib.h>  // needs size_t and FILE
#include <jerror.h>
// clang-format on

namespace lightbatch::image {
namespace {

/// A progressive file may hold any number of scans, each of which walks the whole image.
constexpr int kMostScans = 200;

/// libjpeg leaves by longjmp: all storage with a destructor lives here, made before setjmp.
struct JpegRead {
  jpeg_error_mgr errors{};
  jpeg_progress_mgr progress{};
  std::jmp_buf escape{};
  char message[JMSG_LENGTH_MAX] = {};
  jpeg_decompress_struct info{};
  Image8 image;
  std::vector<std::uint8_t> row;
};

void on_error(j_common_ptr common) {
  auto* state = static_cast<JpegRead*>(common->client_data);
  common->err->format_message(common, state->message);
  std::longjmp(state->escape, 1);  // NOLINT(cert-err52-cpp): libjpeg's only way out
}

/// Warnings are counted, except that of missing data, which is an error here.
void on_message(j_common_ptr common, int level) {
  if (level < 0 && common->err->msg_code == JWRN_JPEG_EOF) on_error(common);
}

void on_progress(j_common_ptr common) {
  auto* state = static_cast<JpegRead*>(common->client_data);
  if (common->is_decompressor != 0 && state->info.input_scan_number > kMostScans) {
    ERREXIT(common, JERR_NOTIMPL);
  }
}

void start(JpegRead* state) {
  state->info.err = jpeg_std_error(&state->errors);
  state->errors.error_exit = on_error;
  state->errors.emit_message = on_message;
  jpeg_create_decompress(&state->info);  // clears all but err
  state->info.client_data = state;
  state->progress.progress_monitor = on_progress;
  state->info.progress = &state->progress;
}

bool read_header(JpegRead* state, std::span<const std::byte> bytes) {
  if (setjmp(state->escape) != 0) return false;  // NOLINT(cert-err52-cpp)
  jpeg_mem_src(&state->info, reinterpret_cast<const unsigned char*>(bytes.data()),
               static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&state->info, TRUE);
  return true;
}

/// CMYK as Adobe stores it: inverted inks.
void cmyk_to_rgba(const std::uint8_t* cmyk, std::uint8_t* rgba, int width) {
  for (int x = 0; x < width; ++x, cmyk += 4, rgba += 4) {
    for (int c = 0; c < 3; ++c) rgba[c] = static_cast<std::uint8_t>(cmyk[c] * cmyk[3] / 255);
    rgba[3] = 255;
  }
}

bool read_pixels(JpegRead* state, bool cmyk) {
  if (setjmp(state->escape) != 0) return false;  // NOLINT(cert-err52-cpp)
  state->info.out_color_space = cmyk ? JCS_CMYK : JCS_EXT_RGBA;
  jpeg_start_decompress(&state->info);
  const std::size_t row_bytes = 4 * static_cast<std::size_t>(state->image.width);
  while (state->info.output_scanline < state->info.output_height) {
    std::uint8_t* out = state->image.rgba.data() + row_bytes * state->info.output_scanline;
    JSAMPROW row = cmyk ? state->row.data() : out;
    jpeg_read_scanlines(&state->info, &row, 1);
    if (cmyk) cmyk_to_rgba(state->row.data(), out, state->image.width);
  }
  jpeg_finish_decompress(&state->info);
  return true;
}

}  // namespace

Result<ImageSize> read_jpeg_size(std::span<const std::byte> bytes, const std::string& place) {
  JpegRead state;
  start(&state);
  Status status;
  if (!read_header(&state, bytes)) {
    status = malformed(place, std::string("broken JPEG: ") + state.message);
  } else {
    status = check_size(state.info.image_width, state.info.image_height, ~std::uint64_t{0}, place);
  }
  const ImageSize size{static_cast<int>(state.info.image_width),
                       static_cast<int>(state.info.image_height)};
  jpeg_destroy_decompress(&state.info);
  if (!status.ok()) return status;
  return size;
}

Result<Image8> decode_jpeg(std::span<const std::byte> bytes, const std::string& place,
                           std::uint64_t max_pixels) {
  JpegRead state;
  start(&state);
  Status status;
  if (!read_header(&state, bytes)) {
    status = malformed(place, std::string("broken JPEG: ") + state.message);
  } else {
    status = check_size(state.info.image_width, state.info.image_height, max_pixels, place);
  }
  if (status.ok()) {
    state.image.width = static_cast<int>(state.info.image_width);
    state.image.height = static_cast<int>(state.info.image_height);
    const std::size_t row_bytes = 4 * static_cast<std::size_t>(state.image.width);
    state.image.rgba.resize(row_bytes * static_cast<std::size_t>(state.image.height));
    const bool cmyk = state.info.num_components == 4;
    if (cmyk) state.row.resize(row_bytes);
    if (!read_pixels(&state, cmyk)) {
      status = malformed(place, std::string("broken JPEG: ") + state.message);
    }
  }
  jpeg_destroy_decompress(&state.info);
  if (!status.ok()) return status;
  return std::move(state.image);
}

}  // namespace lightbatch::image
