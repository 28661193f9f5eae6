#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/status.h"
#include "core/image/image.h"

namespace lightbatch::image {

/// What the first bytes say; kUnknown is not an error by itself.
enum class Format { kUnknown, kPng, kJpeg, kWebp, kKtx2, kHdr, kExr };
Format detect_format(std::span<const std::byte> bytes);

/// Decodes PNG, JPEG or WebP to 8-bit RGBA. The header is read and checked against max_pixels
/// before anything is allocated. INPUT_MALFORMED / INPUT_OVER_BUDGET / INPUT_UNSUPPORTED (KTX2 and
/// others). `place` names the image in errors.
Result<Image8> decode_image8(std::span<const std::byte> bytes, const std::string& place,
                             std::uint64_t max_pixels = std::uint64_t{1} << 26);

/// Width and height that the header of a PNG, JPEG or WebP states, nothing decoded. Same errors.
struct ImageSize {
  int width = 0;
  int height = 0;
  std::uint64_t pixels() const {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  }
};
Result<ImageSize> read_image8_size(std::span<const std::byte> bytes, const std::string& place);

/// Decodes Radiance .hdr or OpenEXR to linear float RGB (environment maps). Same errors.
Result<ImageRgb> decode_image_rgb(std::span<const std::byte> bytes, const std::string& place,
                                  std::uint64_t max_pixels = std::uint64_t{1} << 26);

/// PNG, 8 bits, RGBA or (alpha = false) RGB. Deterministic bytes.
Bytes encode_png(const Image8& image, bool alpha);

/// OpenEXR, R, G, B and A (coverage in [0, 1]; one value a pixel, or empty for 1), ZIP compression,
/// row 0 on top: half float, or float where a value is beyond half float's 65504 (full sunlight is
/// 100,000 lux) or too many are below 3e-5, where its steps are coarse. Deterministic bytes.
Result<Bytes> encode_exr(const ImageRgb& image, std::span<const float> alpha);

/// One layer of an OpenEXR image: channels NAME.R, NAME.G, NAME.B. Names without dots.
struct ExrLayer {
  std::string name;
  ImageRgb image;
};

/// Float, ZIP compression; layers of one size, each name once. Deterministic bytes.
Result<Bytes> encode_exr_layers(std::span<const ExrLayer> layers);
/// All layers, by name. Errors as of decode_image_rgb.
Result<std::vector<ExrLayer>> decode_exr_layers(std::span<const std::byte> bytes,
                                                const std::string& place,
                                                std::uint64_t max_pixels = std::uint64_t{1} << 26);
/// Channel A, in [0, 1]; 1 where there is none.
Result<std::vector<float>> decode_exr_alpha(std::span<const std::byte> bytes,
                                            const std::string& place,
                                            std::uint64_t max_pixels = std::uint64_t{1} << 26);

}  // namespace lightbatch::image
