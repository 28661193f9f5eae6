// What elements do to light: means of the material over each, and what lies behind those that
// transmit.

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/radiosity/elements.h"

namespace lightbatch::radiosity {

/// Area mean of value(triangle, u, v): exact over the members of a group where they are uniform,
/// sampled where a texture varies.
template <typename Value>
Rgb Elements::mean_over(ElementId e, const optics::Optics& optics, Value value) const {
  constexpr int kTexturedSamples = 16;
  constexpr float kThird = 1.0f / 3;
  Rgbd sum;
  if (is_cell(e)) {
    const ElementPoint first = point(e, 0.5f, 0.5f);
    if (!optics.textured_reflectance(first.triangle))
      return value(first.triangle, first.u, first.v);
    Random random(item_seed(0x5eed, e));
    for (int s = 0; s < kTexturedSamples; ++s) {
      const float a = (static_cast<float>(s) + random.next_float()) / kTexturedSamples;
      const ElementPoint p = point(e, a, random.next_float());
      sum += to_double(value(p.triangle, p.u, p.v)) / kTexturedSamples;
    }
    return to_float(sum);
  }
  float below = 0;
  for (std::uint32_t k = group_start_[e]; k < group_start_[e + 1]; ++k) {
    const std::uint32_t triangle = group_triangles_[k];
    Rgbd mean;
    if (optics.textured_reflectance(triangle)) {
      for (int s = 0; s < 4; ++s) {
        const float u = s == 0 ? kThird : s == 1 ? 0.6f : 0.2f;
        const float v = s == 0 ? kThird : s == 2 ? 0.6f : 0.2f;
        mean += to_double(value(triangle, u, v)) * 0.25;
      }
    } else {
      mean = to_double(value(triangle, kThird, kThird));
    }
    sum += mean * static_cast<double>(group_cumulative_[k] - below);
    below = group_cumulative_[k];
  }
  return to_float(sum);
}

void Elements::average_reflectance(const optics::Optics& optics) {
  const bool transmits = optics.any_diffuse_transmission();
  if (transmits) transmittance_.resize(count());
  parallel_for(count(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto e = static_cast<ElementId>(i);
      reflectance_[i] = mean_over(e, optics, [&](std::uint32_t t, float u, float v) {
        return optics.reflectance(t, u, v);
      });
      if (!transmits) continue;
      transmittance_[i] = mean_over(e, optics, [&](std::uint32_t t, float u, float v) {
        return optics.diffuse_transmittance(t, u, v);
      });
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
