#include "core/lightmap/pages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/image/codecs.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {
namespace {

/// Squared distance from a texel's centre to the surface that a covered neighbour holds.
float distance_to_surface(const atlas::TexelMap& map, std::uint32_t texel, int x, int y) {
  float nearest = std::numeric_limits<float>::infinity();
  for (const atlas::Fragment& f : map.fragments_of(map.texels[texel])) {
    const float dx = f.centroid.x - (static_cast<float>(x) + 0.5f);
    const float dy = f.centroid.y - (static_cast<float>(y) + 0.5f);
    nearest = std::min(nearest, dx * dx + dy * dy);
  }
  return nearest;
}

constexpr std::array<std::array<int, 2>, 8> kNeighbours{
    {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

/// 4 x 4 Bayer matrix: thresholds (k + 1/2) / 16.
constexpr std::array<std::array<int, 4>, 4> kBayer{
    {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}}};

}  // namespace

std::vector<PageImage> make_pages(const atlas::Layout& layout, const atlas::TexelMap& map,
                                  const std::vector<Rgb>& irradiance, int rings) {
  std::vector<PageImage> pages;
  std::vector<std::vector<std::uint32_t>> owner(layout.pages.size());  // chart, or kNone
  for (std::size_t p = 0; p < layout.pages.size(); ++p) {
    PageImage page{image::ImageRgb(layout.pages[p].width, layout.pages[p].height), {}};
    page.coverage.assign(page.irradiance.pixels.size(), 0.0f);
    owner[p].assign(page.irradiance.pixels.size(), scene::kNone);
    pages.push_back(std::move(page));
  }
  for (std::size_t t = 0; t < map.texels.size(); ++t) {
    const atlas::Texel& texel = map.texels[t];
    PageImage& page = pages[texel.page];
    const auto at =
        static_cast<std::size_t>(texel.y) * static_cast<std::size_t>(page.irradiance.width) +
        texel.x;
    page.irradiance.pixels[at] = irradiance[t];
    page.coverage[at] = std::clamp(texel.coverage, 1.0f / 255, 1.0f);
    owner[texel.page][at] = texel.chart;
  }
  for (std::size_t p = 0; p < pages.size(); ++p) {
    PageImage& page = pages[p];
    const int width = page.irradiance.width;
    const int height = page.irradiance.height;
    for (int ring = 0; ring < rings; ++ring) {
      struct Filled {
        std::size_t at;
        std::uint32_t chart;
        Rgb value;
      };
      std::vector<Filled> filled;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const auto at = static_cast<std::size_t>(y * width + x);
          if (owner[p][at] != scene::kNone) continue;
          std::uint32_t best = scene::kNone;
          float nearest = std::numeric_limits<float>::infinity();
          for (const auto& d : kNeighbours) {
            const int nx = x + d[0], ny = y + d[1];
            if (nx < 0 || ny < 0 || nx >= width || ny >= height) continue;
            const auto n = static_cast<std::size_t>(ny * width + nx);
            if (owner[p][n] == scene::kNone) continue;
            const std::uint32_t texel = map.index[p][n];
            const float distance = texel != scene::kNone
                                       ? distance_to_surface(map, texel, x, y)
                                       : static_cast<float>(4 + d[0] * d[0] + d[1] * d[1]);
            if (distance < nearest) {
              nearest = distance;
              best = owner[p][n];
            }
          }
          if (best == scene::kNone) continue;
          Rgbd sum;
          double weight = 0;
          for (const auto& d : kNeighbours) {
            const int nx = x + d[0], ny = y + d[1];
            if (nx < 0 || ny < 0 || nx >= width || ny >= height) continue;
            const auto n = static_cast<std::size_t>(ny * width + nx);
            if (owner[p][n] != best) continue;
            const double w = d[0] == 0 || d[1] == 0 ? 1.0 : 0.25;
            sum += to_double(page.irradiance.pixels[n]) * w;
            weight += w;
          }
          filled.push_back({at, best, to_float(sum / weight)});
        }
      }
      for (const Filled& f : filled) {
        page.irradiance.pixels[f.at] = f.value;
        owner[p][f.at] = f.chart;
      }
    }
  }
  return pages;
}

Result<EncodedPage> encode_page(const PageImage& page, double cut) {
  EncodedPage encoded;
  std::vector<float> values;
  float highest = 0;
  for (std::size_t i = 0; i < page.coverage.size(); ++i) {
    if (page.coverage[i] <= 0) continue;
    values.push_back(page.irradiance.pixels[i].max());
    highest = std::max(highest, values.back());
  }
  float scale = highest;
  if (!values.empty()) {
    const auto rank =
        static_cast<std::size_t>((1.0 - cut) * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank),
                     values.end());
    if (values[rank] > 0 && highest > 4 * values[rank]) scale = values[rank];
  }
  encoded.intensity = scale > 0 ? scale : 1.0f;
  image::Image8 pixels{page.irradiance.width, page.irradiance.height, {}};
  pixels.rgba.resize(4 * page.irradiance.pixels.size());
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      const auto i = static_cast<std::size_t>(y * pixels.width + x);
      const Rgb& value = page.irradiance.pixels[i];
      if (page.coverage[i] > 0 && value.max() > encoded.intensity) ++encoded.clipped_texels;
      const float threshold =
          (static_cast<float>(
               kBayer[static_cast<std::size_t>(y & 3)][static_cast<std::size_t>(x & 3)]) +
           0.5f) /
          16.0f;
      const auto byte = [&](float v) {
        const float level = std::clamp(v / encoded.intensity, 0.0f, 1.0f) * 255.0f;
        return static_cast<std::uint8_t>(std::min(255.0f, std::floor(level + threshold)));
      };
      pixels.rgba[4 * i] = byte(value.r);
      pixels.rgba[4 * i + 1] = byte(value.g);
      pixels.rgba[4 * i + 2] = byte(value.b);
      pixels.rgba[4 * i + 3] = 255;
    }
  }
  encoded.png = image::encode_png(pixels, false);
  return encoded;
}

Result<Bytes> encode_exr(const PageImage& page) {
  return image::encode_exr(page.irradiance, page.coverage);
}

image::Image8 preview(const PageImage& page) {
  std::vector<float> values;
  for (std::size_t i = 0; i < page.coverage.size(); ++i) {
    if (page.coverage[i] > 0) values.push_back(luminance(page.irradiance.pixels[i]));
  }
  float white = 1;
  if (!values.empty()) {
    const auto rank = static_cast<std::size_t>(0.99 * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank),
                     values.end());
    white = std::max(values[rank], 1e-20f);
  }
  image::Image8 picture{page.irradiance.width, page.irradiance.height, {}};
  picture.rgba.resize(4 * page.irradiance.pixels.size());
  for (std::size_t i = 0; i < page.irradiance.pixels.size(); ++i) {
    const Rgb value = page.irradiance.pixels[i];
    const auto byte = [&](float v) {
      return static_cast<std::uint8_t>(
          std::lround(255.0f * linear_to_srgb(std::clamp(v / white, 0.0f, 1.0f))));
    };
    const bool covered = page.coverage[i] > 0;
    picture.rgba[4 * i] = covered ? byte(value.r) : 24;
    picture.rgba[4 * i + 1] = covered ? byte(value.g) : 24;
    picture.rgba[4 * i + 2] = covered ? byte(value.b) : 28;
    picture.rgba[4 * i + 3] = 255;
  }
  return picture;
}

}  // namespace lightbatch::lightmap
