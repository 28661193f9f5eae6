// What elements do to light: means of the material over each, and what lies behind those that
// transmit.

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/radiosity/elements.h"

namespace lightbatch::radiosity {

namespace {

using Scatterer = optics::Optics::Scatterer;

/// Means by area: of coverage over all, of the rest over what is covered.
class Mean {
 public:
  /// sampled: the value is a sample of one that varies.
  void add(const Scatterer& s, double area, bool sampled) {
    area_ += area;
    if (sampled) least_ = std::min(least_, area);
    covered_.add(s, area * static_cast<double>(s.coverage));
    anywhere_.add(s, area);
  }
  /// Holes wherever samples fell: as much may be there as lies between these.
  Scatterer mean() const {
    if (!(area_ > 0)) return {};
    const bool found = covered_.weight > 0;
    const double unseen = std::isfinite(least_) ? 0.5 * least_ : 0.0;
    Scatterer s = found ? covered_.mean() : anywhere_.mean();
    s.coverage = static_cast<float>((found ? covered_.weight : unseen) / area_);
    return s;
  }

 private:
  struct Sums {
    Rgbd reflectance, transmittance;
    double weight = 0;
    void add(const Scatterer& s, double w) {
      reflectance += to_double(s.reflectance) * w;
      transmittance += to_double(s.diffuse_transmittance) * w;
      weight += w;
    }
    Scatterer mean() const {
      return {1, to_float(reflectance / weight), to_float(transmittance / weight), {}};
    }
  };
  Sums covered_, anywhere_;
  double area_ = 0;
  double least_ = std::numeric_limits<double>::infinity();
};

}  // namespace

/// Exact over the members of a group where they are uniform, sampled where a texture varies.
Scatterer Elements::mean_over(ElementId e, const optics::Optics& optics) const {
  constexpr int kTexturedSamples = 16;
  constexpr float kThird = 1.0f / 3;
  const auto varies = [&](std::uint32_t triangle) {
    return optics.textured_reflectance(triangle) &&
           optics.surfaces()[triangle] != rays::Surface::kClear;
  };
  Mean mean;
  if (is_cell(e)) {
    const ElementPoint first = point(e, 0.5f, 0.5f);
    if (!varies(first.triangle)) {
      return optics.scatterer(first.triangle, first.u, first.v);
    }
    Random random(item_seed(0x5eed, e));
    for (int s = 0; s < kTexturedSamples; ++s) {
      const float a = (static_cast<float>(s) + random.next_float()) / kTexturedSamples;
      const ElementPoint p = point(e, a, random.next_float());
      mean.add(optics.scatterer(p.triangle, p.u, p.v), 1, true);
    }
    return mean.mean();
  }
  float below = 0;
  for (std::uint32_t k = group_start_[e]; k < group_start_[e + 1]; ++k) {
    const std::uint32_t triangle = group_triangles_[k];
    const double share = group_cumulative_[k] - below;
    if (varies(triangle)) {
      for (int s = 0; s < 4; ++s) {
        const float u = s == 0 ? kThird : s == 1 ? 0.6f : 0.2f;
        const float v = s == 0 ? kThird : s == 2 ? 0.6f : 0.2f;
        mean.add(optics.scatterer(triangle, u, v), 0.25 * share, true);
      }
    } else {
      mean.add(optics.scatterer(triangle, kThird, kThird), share, false);
    }
    below = group_cumulative_[k];
  }
  return mean.mean();
}

void Elements::average_optics(const optics::Optics& optics) {
  const bool transmits = optics.any_diffuse_transmission();
  covered_area_.resize(count());
  if (transmits) transmittance_.resize(count());
  parallel_for(count(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Scatterer s = mean_over(static_cast<ElementId>(i), optics);
      covered_area_[i] = area_[i] * s.coverage;
      reflectance_[i] = s.reflectance;
      if (transmits) transmittance_[i] = s.diffuse_transmittance;
    }
  });
}

void Elements::find_behind() {
  if (!transmits()) return;
  behind_start_.push_back(0);
  std::size_t side = 0;
  for (ElementId e = 0; e < count(); ++e) {
    if (is_cell(e)) {
      while (side + 1 < grid_first_.size() && grid_first_[side + 1] <= e) ++side;
    }
    if (!transmittance_[e].is_black()) {
      if (is_cell(e)) {
        const std::size_t other = is_back(e) ? side - 1 : side + 1;
        behind_.push_back({grid_first_[other] + (e - grid_first_[side]), 1.0f});
      } else {
        float below = 0;
        for (std::uint32_t k = group_start_[e]; k < group_start_[e + 1]; ++k) {
          const Face& face = faces_[group_triangles_[k]];
          const ElementId other = is_back(e) ? face.front : face.back;
          const float share = group_cumulative_[k] - below;
          below = group_cumulative_[k];
          // Neighbours in a group mostly share what is behind them.
          const bool same =
              behind_.size() > behind_start_.back() && behind_.back().element == other;
          if (same) {
            behind_.back().share += share;
          } else if (other != kNoElement) {
            behind_.push_back({other, share});
          }
        }
      }
    }
    behind_start_.push_back(static_cast<std::uint32_t>(behind_.size()));
  }
}

}  // namespace lightbatch::radiosity
