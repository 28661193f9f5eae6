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
  const Format format = detect_format(bytes);
  switch (format) {
    case Format::kPng:
      return decode_png(bytes, place, max_pixels);
    case Format::kJpeg:
      return decode_jpeg(bytes, place, max_pixels);
    case Format::kWebp:
      return decode_webp(bytes, place, max_pixels);
    case Format::kKtx2:
      return unsupported(place, "KTX2 images are passed through, not decoded");
    case Format::kHdr:
    case Format::kExr:
      return unsupported(place, std::string(name_of(format)) + " images are no glTF textures");
    case Format::kUnknown:
      break;
  }
  if (bytes.empty()) return malformed(place, "the image has no bytes");
  return unsupported(place, "the image is not PNG, JPEG or WebP by its first bytes");
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
