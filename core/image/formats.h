#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/base/status.h"
#include "core/image/codecs.h"
#include "core/image/image.h"

/// One decoder per file format, behind detect_format(). Every decoder reads the header, asks
/// check_size(), and only then allocates pixels.
namespace lightbatch::image {

/// INPUT_MALFORMED for an empty image, INPUT_OVER_BUDGET beyond max_pixels (or 2^16 - 1 a side).
Status check_size(std::int64_t width, std::int64_t height, std::uint64_t max_pixels,
                  const std::string& place);

/// Sizes from the headers, checked by check_size() with its limit of a side only.
Result<ImageSize> read_png_size(std::span<const std::byte> bytes, const std::string& place);
Result<ImageSize> read_jpeg_size(std::span<const std::byte> bytes, const std::string& place);
Result<ImageSize> read_webp_size(std::span<const std::byte> bytes, const std::string& place);

Result<Image8> decode_png(std::span<const std::byte> bytes, const std::string& place,
                          std::uint64_t max_pixels);
Result<Image8> decode_jpeg(std::span<const std::byte> bytes, const std::string& place,
                           std::uint64_t max_pixels);
Result<Image8> decode_webp(std::span<const std::byte> bytes, const std::string& place,
                           std::uint64_t max_pixels);
Result<ImageRgb> decode_hdr(std::span<const std::byte> bytes, const std::string& place,
                            std::uint64_t max_pixels);
Result<ImageRgb> decode_exr(std::span<const std::byte> bytes, const std::string& place,
                            std::uint64_t max_pixels);

}  // namespace lightbatch::image
