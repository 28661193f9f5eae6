#include "core/lightmap/dim.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/lightmap/texel_points.h"

namespace lightbatch::lightmap {
namespace {

constexpr double kDimmest = 0.005;  // of the mean

}  // namespace

double dim_share(double own, double mean, double exponent) {
  if (!(exponent > 0 && mean > 0)) return 1;
  return std::pow(std::clamp(own / mean, kDimmest, 1.0), exponent);
}

DimShares::DimShares(const BakeInput& input, const GatherSettings& settings)
    : mean_(input.mean_irradiance), exponent_(settings.dim) {
  const radiosity::Solution& solution = input.solution;
  if (!(exponent_ > 0) || solution.irradiance.empty()) return;
  whole_.resize(input.texels.texels.size());
  indirect_.resize(whole_.size());
  parallel_for(whole_.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const TexelPoints::Point p = central_point(input.texels, input.texels.texels[t]);
      const atlas::SurfacePoint at = surface_point(input.layout, p);
      const radiosity::ElementId e = input.elements.at(at.triangle, at.u, at.v, p.back);
      if (e == radiosity::kNoElement) continue;
      whole_[t] = solution.irradiance[e].sum() / 3;
      if (!solution.indirect.empty()) indirect_[t] = solution.indirect[e].sum() / 3;
    }
  });
}

double DimShares::at(std::uint32_t t) const {
  return whole_.empty() ? 1 : dim_share(static_cast<double>(whole_[t]), mean_, exponent_);
}

double DimShares::at(std::uint32_t t, const Rgb& direct) const {
  if (whole_.empty()) return 1;
  return dim_share(static_cast<double>(indirect_[t] + direct.sum() / 3), mean_, exponent_);
}

}  // namespace lightbatch::lightmap
