#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>

#include <algorithm>
#include <set>

#include "core/image/codecs.h"
#include "core/image/exr_streams.h"
#include "core/image/formats.h"

namespace lightbatch::image {
namespace {

constexpr const char* kChannels[3] = {".R", ".G", ".B"};
/// Of max_pixels each, in all.
constexpr std::uint64_t kMostLayers = 16;

/// The layer's three channels as OpenEXR reads or writes them in place.
void insert(Imf::FrameBuffer& frame, const ExrLayer& layer) {
  auto* base = const_cast<char*>(reinterpret_cast<const char*>(layer.image.pixels.data()));
  for (std::size_t c = 0; c < 3; ++c) {
    frame.insert(layer.name + kChannels[c],
                 Imf::Slice(Imf::FLOAT, base + c * sizeof(float), sizeof(Rgb),
                            sizeof(Rgb) * static_cast<std::size_t>(layer.image.width)));
  }
}

/// Width and height of an image whose first pixel is (0, 0).
Status read_size(const Imf::InputFile& file, const std::string& place, std::uint64_t max_pixels,
                 int& width, int& height) {
  const Imath::Box2i window = file.header().dataWindow();
  const std::int64_t w = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t h = std::int64_t{window.max.y} - window.min.y + 1;
  LB_RETURN_IF_ERROR(check_size(w, h, max_pixels, place));
  if (window.min.x != 0 || window.min.y != 0) {
    return unsupported(place, "the EXR image does not begin at (0, 0)");
  }
  width = static_cast<int>(w);
  height = static_cast<int>(h);
  return {};
}

bool is_plain(const Imf::Channel* channel) {
  return channel != nullptr && channel->xSampling == 1 && channel->ySampling == 1;
}

Result<std::vector<ExrLayer>> decode_layers(std::span<const std::byte> bytes,
                                            const std::string& place, std::uint64_t max_pixels) {
  SpanStream stream(bytes);
  Imf::InputFile file(stream);
  int width = 0, height = 0;
  LB_RETURN_IF_ERROR(read_size(file, place, max_pixels, width, height));
  const Imf::ChannelList& channels = file.header().channels();
  std::set<std::string> names;
  channels.layers(names);
  if (names.size() * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) >
      kMostLayers * max_pixels) {
    return over_budget(place, "the layers of the EXR image are too many");
  }
  std::vector<ExrLayer> layers;
  Imf::FrameBuffer frame;
  for (const std::string& name : names) {
    for (const char* channel : kChannels) {
      if (is_plain(channels.findChannel(name + channel))) continue;
      return unsupported(place, "layer " + name + " of the EXR image is not plain R, G, B");
    }
    layers.push_back({name, ImageRgb(width, height)});
    insert(frame, layers.back());
  }
  file.setFrameBuffer(frame);
  file.readPixels(0, height - 1);
  for (const ExrLayer& layer : layers) {
    if (!std::all_of(layer.image.pixels.begin(), layer.image.pixels.end(),
                     [](const Rgb& p) { return is_finite(p); })) {
      return malformed(place, "the EXR image holds a value that is not finite");
    }
  }
  return layers;
}

Result<std::vector<float>> decode_alpha(std::span<const std::byte> bytes, const std::string& place,
                                        std::uint64_t max_pixels) {
  SpanStream stream(bytes);
  Imf::InputFile file(stream);
  int width = 0, height = 0;
  LB_RETURN_IF_ERROR(read_size(file, place, max_pixels, width, height));
  std::vector<float> alpha(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 1);
  const Imf::Channel* channel = file.header().channels().findChannel("A");
  if (channel == nullptr) return alpha;
  if (!is_plain(channel)) return unsupported(place, "the EXR image has subsampled channels");
  Imf::FrameBuffer frame;
  frame.insert("A", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(alpha.data()), sizeof(float),
                               sizeof(float) * static_cast<std::size_t>(width)));
  file.setFrameBuffer(frame);
  file.readPixels(0, height - 1);
  if (!std::all_of(alpha.begin(), alpha.end(), [](float a) { return a >= 0 && a <= 1; })) {
    return malformed(place, "alpha of the EXR image lies outside 0 to 1");
  }
  return alpha;
}

/// What OpenEXR throws becomes an error.
template <typename Decode>
auto guarded(const std::string& place, Decode decode) -> decltype(decode()) {
  try {
    return decode();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    return malformed(place, std::string("broken EXR: ") + error.what());
  }
}

}  // namespace

Result<Bytes> encode_exr_layers(std::span<const ExrLayer> layers) {
  if (layers.empty()) return bad_option("an EXR image needs a layer");
  const ImageRgb& first = layers.front().image;
  try {
    Imf::Header header(first.width, first.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer frame;
    for (const ExrLayer& layer : layers) {
      if (layer.image.width != first.width || layer.image.height != first.height) {
        return bad_option("the layers of an EXR image are of one size");
      }
      for (const char* channel : kChannels) {
        header.channels().insert(layer.name + channel, Imf::Channel(Imf::FLOAT));
      }
      insert(frame, layer);
    }
    BytesStream stream;
    {
      Imf::OutputFile file(stream, header, 0);
      file.setFrameBuffer(frame);
      file.writePixels(first.height);
    }
    return std::move(stream.bytes);
  } catch (const std::exception& error) {
    return Status(StatusCode::kInternal, "IMAGE_ENCODE_FAILED",
                  std::string("EXR image cannot be written: ") + error.what());
  }
}

Result<std::vector<ExrLayer>> decode_exr_layers(std::span<const std::byte> bytes,
                                                const std::string& place,
                                                std::uint64_t max_pixels) {
  return guarded(place, [&] { return decode_layers(bytes, place, max_pixels); });
}

Result<std::vector<float>> decode_exr_alpha(std::span<const std::byte> bytes,
                                            const std::string& place, std::uint64_t max_pixels) {
  return guarded(place, [&] { return decode_alpha(bytes, place, max_pixels); });
}

}  // namespace lightbatch::image
