#include <webp/decode.h>

#include "core/image/formats.h"

namespace lightbatch::image {

Result<ImageSize> read_webp_size(std::span<const std::byte> bytes, const std::string& place) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK) {
    return malformed(place, "broken WebP: the header cannot be read");
  }
  if (features.has_animation != 0) return unsupported(place, "the WebP image is animated");
  LB_RETURN_IF_ERROR(check_size(features.width, features.height, ~std::uint64_t{0}, place));
  return ImageSize{features.width, features.height};
}

Result<Image8> decode_webp(std::span<const std::byte> bytes, const std::string& place,
                           std::uint64_t max_pixels) {
  LB_ASSIGN_OR_RETURN(const ImageSize size, read_webp_size(bytes, place));
  LB_RETURN_IF_ERROR(check_size(size.width, size.height, max_pixels, place));
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  Image8 image;
  image.width = size.width;
  image.height = size.height;
  image.rgba.resize(4 * static_cast<std::size_t>(image.width) *
                    static_cast<std::size_t>(image.height));
  if (WebPDecodeRGBAInto(data, bytes.size(), image.rgba.data(), image.rgba.size(),
                         4 * image.width) == nullptr) {
    return malformed(place, "broken WebP: the pixels cannot be decoded");
  }
  return image;
}

}  // namespace lightbatch::image
