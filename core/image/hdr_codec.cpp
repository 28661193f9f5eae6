/// Radiance picture format. Greg Ward, "Real Pixels", Graphics Gems II, 1991, and the description
/// in the Radiance file format document: a text header, a resolution line, and scan lines of RGBE
/// pixels, plain, old run lengths, or new run lengths per component. Deviation: the mantissa is
/// taken as m / 256, without the half step, as stb_image and OpenImageIO do.
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "core/image/formats.h"

namespace lightbatch::image {
namespace {

using Rgbe = std::array<std::uint8_t, 4>;

struct Orientation {
  std::int64_t width = 0;
  std::int64_t height = 0;
  bool bottom_up = false;
  bool right_to_left = false;
};

/// "-Y 512 +X 1024": rows from the top; the column-major forms (X first) are not used by anyone.
bool parse_resolution(std::string_view line, Orientation* out) {
  const auto parse = [&line](char axis, std::int64_t* value, bool* negative) {
    if (line.size() < 4 || (line[0] != '-' && line[0] != '+') || line[1] != axis ||
        line[2] != ' ') {
      return false;
    }
    *negative = line[0] == '-';
    const auto [end, error] = std::from_chars(line.data() + 3, line.data() + line.size(), *value);
    if (error != std::errc() || *value < 0) return false;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    while (!line.empty() && line[0] == ' ') line.remove_prefix(1);
    return true;
  };
  bool y_negative = false;
  bool x_negative = false;
  if (!parse('Y', &out->height, &y_negative) || !parse('X', &out->width, &x_negative)) return false;
  out->bottom_up = !y_negative;
  out->right_to_left = x_negative;
  return line.empty();
}

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::size_t offset() const { return offset_; }
  bool line(std::string_view* out) {
    const std::string_view rest = as_text(bytes_.subspan(offset_));
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos) return false;
    *out = rest.substr(0, end);
    if (out->ends_with('\r')) out->remove_suffix(1);
    offset_ += end + 1;
    return true;
  }
  bool pixel(Rgbe* out) {
    if (bytes_.size() - offset_ < 4) return false;
    for (std::uint8_t& value : *out) value = next();
    return true;
  }
  bool byte(std::uint8_t* out) {
    if (offset_ == bytes_.size()) return false;
    *out = next();
    return true;
  }

 private:
  std::uint8_t next() { return std::to_integer<std::uint8_t>(bytes_[offset_++]); }

  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
};

/// New run lengths: each component of the row on its own; count > 128 is a run of count - 128.
bool read_components(Reader& reader, std::vector<Rgbe>& row) {
  for (std::size_t component = 0; component < 4; ++component) {
    for (std::size_t x = 0; x < row.size();) {
      std::uint8_t count = 0;
      std::uint8_t value = 0;
      if (!reader.byte(&count) || count == 0) return false;
      const bool run = count > 128;
      const std::size_t length = run ? count - 128u : count;
      if (length > row.size() - x) return false;
      if (run && !reader.byte(&value)) return false;
      for (std::size_t i = 0; i < length; ++i, ++x) {
        if (!run && !reader.byte(&value)) return false;
        row[x][component] = value;
      }
    }
  }
  return true;
}

/// Plain pixels with old run lengths: (1, 1, 1, n) repeats the last pixel n << 8 k times.
bool read_plain(Reader& reader, std::vector<Rgbe>& row, const Rgbe& first) {
  unsigned shift = 0;
  Rgbe pixel = first;
  for (std::size_t x = 0;;) {
    if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
      if (x == 0 || shift > 16) return false;
      const std::size_t length = static_cast<std::size_t>(pixel[3]) << shift;
      if (length > row.size() - x) return false;
      for (std::size_t i = 0; i < length; ++i, ++x) row[x] = row[x - 1];
      shift += 8;
    } else {
      row[x++] = pixel;
      shift = 0;
    }
    if (x == row.size()) return true;
    if (!reader.pixel(&pixel)) return false;
  }
}

bool read_row(Reader& reader, std::vector<Rgbe>& row) {
  Rgbe first{};
  if (!reader.pixel(&first)) return false;
  const bool by_component = first[0] == 2 && first[1] == 2 && (first[2] & 0x80) == 0 &&
                            row.size() >= 8 && row.size() < 32768;
  if (!by_component) return read_plain(reader, row, first);
  if (static_cast<std::size_t>(first[2] << 8 | first[3]) != row.size()) return false;
  return read_components(reader, row);
}

Rgb to_rgb(const Rgbe& pixel, float scale) {
  if (pixel[3] == 0) return {};
  const float unit = std::ldexp(1.0f, static_cast<int>(pixel[3]) - (128 + 8)) * scale;
  return {static_cast<float>(pixel[0]) * unit, static_cast<float>(pixel[1]) * unit,
          static_cast<float>(pixel[2]) * unit};
}

}  // namespace

Result<ImageRgb> decode_hdr(std::span<const std::byte> bytes, const std::string& place,
                            std::uint64_t max_pixels) {
  Reader reader(bytes);
  std::string_view line;
  double exposure = 1;
  do {
    if (!reader.line(&line)) return malformed(place, "broken HDR: the header has no end");
    if (line.starts_with("FORMAT=") && line != "FORMAT=32-bit_rle_rgbe") {
      return unsupported(place, "the HDR image is not stored as RGBE");
    }
    if (line.starts_with("EXPOSURE=")) {
      double value = 0;
      std::string_view number = line.substr(9);
      while (number.starts_with(' ')) number.remove_prefix(1);
      const auto parsed = std::from_chars(number.data(), number.data() + number.size(), value);
      if (parsed.ec != std::errc() || !(value > 0) || !std::isfinite(value)) {
        return malformed(place, "broken HDR: EXPOSURE must be a positive number");
      }
      exposure *= value;
    }
  } while (!line.empty());
  Orientation size;
  if (!reader.line(&line) || !parse_resolution(line, &size)) {
    return malformed(place, "broken HDR: no resolution line such as \"-Y 512 +X 1024\"");
  }
  LB_RETURN_IF_ERROR(check_size(size.width, size.height, max_pixels, place));
  const float scale = static_cast<float>(1 / exposure);
  if (!std::isfinite(scale)) return malformed(place, "broken HDR: EXPOSURE is out of range");

  ImageRgb image(static_cast<int>(size.width), static_cast<int>(size.height));
  std::vector<Rgbe> row(static_cast<std::size_t>(size.width));
  for (int y = 0; y < image.height; ++y) {
    if (!read_row(reader, row)) {
      return malformed(place + "@" + std::to_string(reader.offset()),
                       "broken HDR: row " + std::to_string(y) + " is cut off or overlong");
    }
    const int to_y = size.bottom_up ? image.height - 1 - y : y;
    for (int x = 0; x < image.width; ++x) {
      const int to_x = size.right_to_left ? image.width - 1 - x : x;
      const Rgb value = to_rgb(row[static_cast<std::size_t>(x)], scale);
      if (!is_finite(value)) return malformed(place, "broken HDR: a value is out of range");
      image.at(to_x, to_y) = value;
    }
  }
  return image;
}

}  // namespace lightbatch::image
