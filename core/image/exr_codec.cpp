#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <half.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <vector>

#include "core/image/codecs.h"
#include "core/image/exr_streams.h"
#include "core/image/formats.h"

namespace lightbatch::image {
namespace {

constexpr float kLargestHalf = 65504.0f;
/// Here half a step, 2^-25, is 0.1 %.
constexpr float kDimmestHalf = 3e-5f;

/// A slice that reads component `channel` of image (whose first pixel is at the data window's
/// corner) as float. OpenEXR wants the address of pixel (0, 0), which may lie outside.
Imf::Slice float_slice(ImageRgb& image, const Imath::Box2i& window, std::size_t channel) {
  const auto stride = static_cast<std::ptrdiff_t>(sizeof(Rgb));
  const std::ptrdiff_t row = stride * image.width;
  auto* base = reinterpret_cast<char*>(image.pixels.data()) + channel * sizeof(float);
  const std::uintptr_t origin =
      reinterpret_cast<std::uintptr_t>(base) -
      static_cast<std::uintptr_t>(window.min.x * stride + window.min.y * row);
  return {Imf::FLOAT, reinterpret_cast<char*>(origin), static_cast<std::size_t>(stride),
          static_cast<std::size_t>(row)};
}

Result<ImageRgb> decode(std::span<const std::byte> bytes, const std::string& place,
                        std::uint64_t max_pixels) {
  SpanStream stream(bytes);
  Imf::InputFile file(stream);
  const Imf::Header& header = file.header();
  const Imath::Box2i window = header.dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  LB_RETURN_IF_ERROR(check_size(width, height, max_pixels, place));

  const Imf::ChannelList& channels = header.channels();
  const bool colour = channels.findChannel("R") != nullptr &&
                      channels.findChannel("G") != nullptr && channels.findChannel("B") != nullptr;
  if (!colour && channels.findChannel("Y") == nullptr) {
    return unsupported(place, "the EXR image has neither R, G, B nor Y channels");
  }
  const char* names[3] = {colour ? "R" : "Y", "G", "B"};
  ImageRgb image(static_cast<int>(width), static_cast<int>(height));
  Imf::FrameBuffer frame;
  for (std::size_t i = 0; i < (colour ? 3u : 1u); ++i) {
    const Imf::Channel* channel = channels.findChannel(names[i]);
    if (channel->xSampling != 1 || channel->ySampling != 1) {
      return unsupported(place, "the EXR image has subsampled channels");
    }
    frame.insert(names[i], float_slice(image, window, i));
  }
  file.setFrameBuffer(frame);
  file.readPixels(window.min.y, window.max.y);
  for (Rgb& pixel : image.pixels) {
    if (!colour) pixel = Rgb::grey(pixel.r);
    if (!is_finite(pixel))
      return malformed(place, "the EXR image holds a value that is not finite");
  }
  return image;
}

}  // namespace

Result<ImageRgb> decode_exr(std::span<const std::byte> bytes, const std::string& place,
                            std::uint64_t max_pixels) {
  try {
    return decode(bytes, place, max_pixels);
  } catch (const std::exception& error) {
    return malformed(place, std::string("broken EXR: ") + error.what());
  }
}

namespace {

template <typename Value>
Bytes encode_exr_as(const ImageRgb& image, std::span<const float> alpha, Imf::PixelType type) {
  struct Pixel {
    Value r, g, b, a;
  };
  const auto value = [](float v) { return Value(std::isnan(v) ? 0.0f : v); };
  std::vector<Pixel> pixels(image.pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Rgb& rgb = image.pixels[i];
    pixels[i] = {value(rgb.r), value(rgb.g), value(rgb.b), value(alpha.empty() ? 1.0f : alpha[i])};
  }
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer frame;
  const char* names[4] = {"R", "G", "B", "A"};
  for (std::size_t i = 0; i < 4; ++i) {
    header.channels().insert(names[i], Imf::Channel(type));
    frame.insert(names[i],
                 Imf::Slice(type, reinterpret_cast<char*>(pixels.data()) + i * sizeof(Value),
                            sizeof(Pixel), sizeof(Pixel) * static_cast<std::size_t>(image.width)));
  }
  BytesStream stream;
  {
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(frame);
    file.writePixels(image.height);
  }
  return std::move(stream.bytes);
}

/// Whether half floats hold the light to 0.1 %: nothing is beyond them, and at most one covered
/// pixel in a thousand that is not black is so dim that their steps are larger.
bool fits_half(const ImageRgb& image, std::span<const float> alpha) {
  std::size_t lit = 0, dim = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const Rgb& p = image.pixels[i];
    const float value = std::max({std::fabs(p.r), std::fabs(p.g), std::fabs(p.b)});
    if (value > kLargestHalf) return false;
    if (value <= 0 || (!alpha.empty() && alpha[i] <= 0)) continue;
    ++lit;
    if (value < kDimmestHalf) ++dim;
  }
  return 1000 * dim <= lit;
}

}  // namespace

Result<Bytes> encode_exr(const ImageRgb& image, std::span<const float> alpha) {
  if (image.width <= 0 || image.height <= 0) return bad_option("an EXR image needs pixels");
  if (!alpha.empty() && alpha.size() != image.pixels.size()) {
    return bad_option("coverage needs one value a pixel");
  }
  try {
    return fits_half(image, alpha) ? encode_exr_as<half>(image, alpha, Imf::HALF)
                                   : encode_exr_as<float>(image, alpha, Imf::FLOAT);
  } catch (const std::exception& error) {
    return Status(StatusCode::kInternal, "IMAGE_ENCODE_FAILED",
                  std::string("EXR image cannot be written: ") + error.what());
  }
}

}  // namespace lightbatch::image
