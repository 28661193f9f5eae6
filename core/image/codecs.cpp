#include "core/image/codecs.h"

#include <string_view>

#include "core/image/formats.h"

namespace lightbatch::image {
namespace {

constexpr std::int64_t kLargestSide = 65535;

const char* name_of(Format format) {
  switch (format) {
    case Format::kPng:
      return "PNG";
    case Format::kJpeg:
      return "JPEG";
    case Format::kWebp:
      return "WebP";
    case Format::kKtx2:
      return "KTX2";
    case Format::kHdr:
      return "Radiance HDR";
    case Format::kExr:
      return "OpenEXR";
    case Format::kUnknown:
      break;
  }
  return "unknown";
}

/// Why bytes that are neither PNG, JPEG nor WebP are no texture for us.
Status not_decodable(std::span<const std::byte> bytes, const std::string& place) {
  if (bytes.empty()) return malformed(place, "the image has no bytes");
  const Format format = detect_format(bytes);
  if (format == Format::kKtx2) {
    return unsupported(place, "KTX2 images are passed through, not decoded");
  }
  if (format != Format::kUnknown) {
    return unsupported(place, std::string(name_of(format)) + " images are no glTF textures");
  }
  return unsupported(place, "the image is not PNG, JPEG or WebP by its first bytes");
}

}  // namespace

Status check_size(std::int64_t width, std::int64_t height, std::uint64_t max_pixels,
                  const std::string& place) {
  if (width <= 0 || height <= 0) return malformed(place, "the image has no pixels");
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  if (width > kLargestSide || height > kLargestSide) {
    return over_budget(place, "the image is " + size + "; at most 65535 a side are read");
  }
  if (static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) > max_pixels) {
    return over_budget(place, "the image is " + size + "; at most " + std::to_string(max_pixels) +
                                  " pixels are allowed");
  }
  return {};
}

Format detect_format(std::span<const std::byte> bytes) {
  const std::string_view text = as_text(bytes);
  if (text.starts_with("\x89PNG\r\n\x1a\n")) return Format::kPng;
  if (text.starts_with("\xff\xd8\xff")) return Format::kJpeg;
  if (text.size() >= 12 && text.starts_with("RIFF") && text.substr(8, 4) == "WEBP") {
    return Format::kWebp;
  }
  if (text.starts_with("\xabKTX 20\xbb\r\n\x1a\n")) return Format::kKtx2;
  if (text.starts_with("#?RADIANCE") || text.starts_with("#?RGBE")) return Format::kHdr;
  if (text.starts_with("\x76\x2f\x31\x01")) return Format::kExr;
  return Format::kUnknown;
}

Result<Image8> decode_image8(std::span<const std::byte> bytes, const std::string& place,
                             std::uint64_t max_pixels) {
  switch (detect_format(bytes)) {
    case Format::kPng:
      return decode_png(bytes, place, max_pixels);
    case Format::kJpeg:
      return decode_jpeg(bytes, place, max_pixels);
    case Format::kWebp:
      return decode_webp(bytes, place, max_pixels);
    default:
      return not_decodable(bytes, place);
  }
}

Result<ImageSize> read_image8_size(std::span<const std::byte> bytes, const std::string& place) {
  switch (detect_format(bytes)) {
    case Format::kPng:
      return read_png_size(bytes, place);
    case Format::kJpeg:
      return read_jpeg_size(bytes, place);
    case Format::kWebp:
      return read_webp_size(bytes, place);
    default:
      return not_decodable(bytes, place);
  }
}

Result<ImageRgb> decode_image_rgb(std::span<const std::byte> bytes, const std::string& place,
                                  std::uint64_t max_pixels) {
  const Format format = detect_format(bytes);
  if (format == Format::kHdr) return decode_hdr(bytes, place, max_pixels);
  if (format == Format::kExr) return decode_exr(bytes, place, max_pixels);
  if (bytes.empty()) return malformed(place, "the image has no bytes");
  return unsupported(place,
                     std::string("an environment map must be Radiance .hdr or OpenEXR .exr, ") +
                         "this one is " + name_of(format) + " by its first bytes");
}

}  // namespace lightbatch::image
