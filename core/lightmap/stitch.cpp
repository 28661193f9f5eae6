// Sylvan 2010 (Fixing Lightmap Seams): the values of texels along borders are changed as little as
// possible, in least squares, so that bilinear look-ups on both sides agree. Here what no surface
// lies in gives way first, and texels with more surface less; conjugate gradients, preconditioned
// by the diagonal.

#include "core/lightmap/stitch.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/lightmap/look_up.h"

namespace lightbatch::lightmap {
namespace {

/// How firmly a covered texel keeps its value, against an agreement along a texel of border: at
/// first, a step through the middle of two texels is left at a twentieth.
constexpr double kFirmness = 0.1;
constexpr double kFirmer = 4;  // where that changes too much, until ...
constexpr double kFirmest = 100;
/// A texel of the gutter.
constexpr double kGutter = 0.01;
/// Below this share of the light on the other side it is dark.
constexpr float kDark = 1e-3f;
constexpr int kMostIterations = 100;
constexpr double kTolerance = 1e-4;  // of the residual, against the first
constexpr std::size_t kGrain = 4096;

double dot(const std::vector<Rgbd>& a, const std::vector<Rgbd>& b) {
  return deterministic_reduce(
      a.size(), kGrain, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
          sum += a[i].r * b[i].r + a[i].g * b[i].g + a[i].b * b[i].b;
        }
        return sum;
      },
      [](double x, double y) { return x + y; });
}

}  // namespace

Stitches::Stitches(const atlas::Layout& layout, const Borders& borders,
                   const std::vector<PageImage>& pages, double allowed) {
  std::vector<std::vector<std::uint32_t>> known(pages.size());
  double covered = 0;
  for (std::size_t p = 0; p < pages.size(); ++p) {
    known[p].assign(pages[p].coverage.size(), scene::kNone);
    for (const float coverage : pages[p].coverage) covered += static_cast<double>(coverage);
  }
  for (const BorderPoint& point : borders.points) add_row(layout, point, pages, known);
  index_uses();
  const Light values = values_of(pages);
  for (double firmness = kFirmness; firmness < kFirmest; firmness *= kFirmer) {
    hold_covered(firmness);
    const Light change = changes(values);
    double squares = 0;
    for (std::size_t i = 0; i < change.size(); ++i) {
      const Rgbd& c = change[i];
      squares += static_cast<double>(coverage_[i]) * (c.r * c.r + c.g * c.g + c.b * c.b) / 3;
    }
    if (squares <= allowed * allowed * covered) break;
  }
}

void Stitches::add_row(const atlas::Layout& layout, const BorderPoint& point,
                       const std::vector<PageImage>& pages,
                       std::vector<std::vector<std::uint32_t>>& known) {
  const std::array<atlas::SurfacePoint, 2> sides{point.here, point.there};
  std::array<std::uint32_t, 2> page{};
  std::array<Taps, 2> taps;
  std::array<float, 2> shown{};
  for (std::size_t side = 0; side < 2; ++side) {
    const atlas::SurfacePoint& at = sides[side];
    page[side] = layout.charts[layout.chart_of[at.triangle]].page;
    const PageImage& image = pages[page[side]];
    taps[side] = taps_at(image, page_place(layout, at.triangle, at.u, at.v));
    shown[side] = look_up(image, taps[side]).sum();
  }
  if (!(std::min(shown[0], shown[1]) > kDark * std::max(shown[0], shown[1]))) return;
  Row row;
  row.texels = point.metres * layout.texels_per_metre;
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t at = taps[side].pixel[k];
      std::uint32_t& pixel = known[page[side]][at];
      if (pixel == scene::kNone) {
        pixel = static_cast<std::uint32_t>(held_.size());
        held_.push_back({page[side], at});
        coverage_.push_back(pages[page[side]].coverage[at]);
      }
      row.pixel[4 * side + k] = pixel;
      row.weight[4 * side + k] = side == 0 ? taps[side].weight[k] : -taps[side].weight[k];
    }
  }
  rows_.push_back(row);
}

void Stitches::index_uses() {
  first_use_.assign(held_.size() + 1, 0);
  for (const Row& row : rows_) {
    for (const std::uint32_t pixel : row.pixel) ++first_use_[pixel + 1];
  }
  for (std::size_t i = 0; i < held_.size(); ++i) first_use_[i + 1] += first_use_[i];
  use_.resize(8 * rows_.size());
  std::vector<std::uint32_t> next(first_use_.begin(), first_use_.end() - 1);
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    for (std::size_t k = 0; k < 8; ++k) {
      use_[next[rows_[r].pixel[k]]++] = static_cast<std::uint32_t>(8 * r + k);
    }
  }
}

void Stitches::hold_covered(double firmness) {
  hold_.resize(held_.size());
  for (std::size_t i = 0; i < held_.size(); ++i) {
    hold_[i] = std::max(kGutter, firmness * static_cast<double>(coverage_[i]));
  }
  diagonal_ = hold_;
  for (const Row& row : rows_) {
    for (std::size_t k = 0; k < 8; ++k) {
      const auto weight = static_cast<double>(row.weight[k]);
      diagonal_[row.pixel[k]] += row.texels * weight * weight;
    }
  }
}

Stitches::Light Stitches::values_of(const std::vector<PageImage>& pages) const {
  Light values(held_.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = to_double(pages[held_[i].page].irradiance.pixels[held_[i].at]);
  }
  return values;
}

Stitches::Light Stitches::difference(const Light& values) const {
  Light result(rows_.size());
  parallel_for(rows_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      for (std::size_t k = 0; k < 8; ++k) {
        result[r] += values[rows_[r].pixel[k]] * static_cast<double>(rows_[r].weight[k]);
      }
    }
  });
  return result;
}

Stitches::Light Stitches::spread(const Light& differences) const {
  Light result(held_.size());
  parallel_for(held_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (std::uint32_t u = first_use_[i]; u < first_use_[i + 1]; ++u) {
        const Row& row = rows_[use_[u] / 8];
        const auto weight = static_cast<double>(row.weight[use_[u] % 8]);
        result[i] += differences[use_[u] / 8] * (row.texels * weight);
      }
    }
  });
  return result;
}

Stitches::Light Stitches::times_matrix(const Light& x) const {
  Light result = spread(difference(x));
  for (std::size_t i = 0; i < x.size(); ++i) result[i] += x[i] * hold_[i];
  return result;
}

Stitches::Light Stitches::changes(const Light& values) const {
  const std::size_t count = held_.size();
  // (S' S + H) change = -S' S values.
  Light residual = spread(difference(values));
  for (Rgbd& r : residual) r = r * -1.0;
  Light change(count), scaled(count);
  const auto precondition = [&] {
    for (std::size_t i = 0; i < count; ++i) scaled[i] = residual[i] * (1 / diagonal_[i]);
  };
  precondition();
  Light direction = scaled;
  double size = dot(residual, scaled);
  const double enough = kTolerance * kTolerance * size;
  for (int iteration = 0; iteration < kMostIterations && size > enough; ++iteration) {
    const Light image = times_matrix(direction);
    const double along = size / dot(direction, image);
    for (std::size_t i = 0; i < count; ++i) {
      change[i] += direction[i] * along;
      residual[i] += image[i] * -along;
    }
    precondition();
    const double next = dot(residual, scaled);
    for (std::size_t i = 0; i < count; ++i) direction[i] = scaled[i] + direction[i] * (next / size);
    size = next;
  }
  return change;
}

void Stitches::apply(std::vector<PageImage>& pages) const {
  const Light values = values_of(pages);
  const Light change = changes(values);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Rgbd v = values[i] + change[i];
    pages[held_[i].page].irradiance.pixels[held_[i].at] =
        to_float(Rgbd{std::max(0.0, v.r), std::max(0.0, v.g), std::max(0.0, v.b)});
  }
}

}  // namespace lightbatch::lightmap
