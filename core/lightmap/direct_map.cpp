// Direct light of every texel. Every texel gets a pilot: a few shadow rays to the emitters and one
// to each punctual light. Where the pilot is mixed, or differs from that of one of the eight
// neighbours in the chart, the texel is refined with many more; the neighbour test is what finds
// thin penumbrae. Unoccluded irradiance is exact (polygons, formulas), only visibility is sampled.

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/lightmap/bake.h"
#include "core/lightmap/texel_points.h"
#include "core/math/sobol.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {
namespace {

using radiosity::DirectLight;
using radiosity::EmitterTerms;
using radiosity::Receiver;
using radiosity::VisibilitySum;

constexpr std::size_t kGrain = 256;

/// Per texel, which lights it sees: emitters (2 bits) and a hash of the punctual lights' shares.
struct Pilot {
  std::uint8_t emitters = 0;  // 0 none asked, 1 dark, 2 lit, 3 mixed
  bool measured = false;
  bool mixed = false;  // some light is seen in part, by the pilot itself
  std::uint32_t punctual = 0;
  bool operator==(const Pilot& o) const { return emitters == o.emitters && punctual == o.punctual; }
};

/// Points of a texel used by the pilot: a spread of up to `wanted`.
std::uint32_t stride_for(const TexelPoints& points, std::uint32_t wanted) {
  return std::max(1u, points.count / std::max(1u, wanted));
}

/// Direct light of a texel, the emitters' part apart with what it would be without shadows.
struct Parts {
  Rgb punctual;
  Rgb emitted;
  Rgb open;
};

class DirectMap {
 public:
  DirectMap(const BakeInput& input, const GatherSettings& settings)
      : input_(input), settings_(settings), lights_(input.direct.sources().punctual()) {}

  /// Direct light from `wanted` points of the texel, with `rays` emitter shadow rays in all. One
  /// shadow ray a punctual light and point when `every_point`, else one a light.
  Parts measure(std::uint32_t t, std::uint32_t wanted, int rays, bool every_point, Pilot* pilot,
                BakeCounts& counts) const {
    const atlas::Texel& texel = input_.texels.texels[t];
    const TexelPoints points = texel_points(input_.texels, texel);
    const std::uint32_t stride = stride_for(points, wanted);
    const std::uint32_t used = (points.count + stride - 1) / stride;
    const int rays_each = std::max(1, rays / static_cast<int>(used));
    const auto seed = static_cast<std::uint32_t>(item_seed(input_.seed, t, 11));
    Rgbd emitted, open_emitted, punctual;
    VisibilitySum seen;
    bool any_terms = false;
    for (std::uint32_t i = 0; i < used; ++i) {
      const TexelPoints::Point& p =
          points.point[std::min(points.count - 1, i * stride + stride / 2)];
      const Receiver at = receiver_at(input_.scene, input_.layout, p, input_.direct.lift());
      const EmitterTerms terms =
          input_.direct.emitter_terms(at, item_seed(input_.seed, t, 200 + i), counts.rays);
      if (terms.count > 0) {
        any_terms = true;
        const VisibilitySum own = input_.direct.emitter_visibility(
            at, terms, rays_each, i * static_cast<std::uint32_t>(rays_each), seed, counts.rays);
        emitted += to_double(terms.total * own.share());
        open_emitted += to_double(terms.total);
        seen.add(own);
      }
    }
    if (pilot != nullptr) pilot->measured = true;
    if (pilot != nullptr && any_terms) {
      pilot->emitters = seen.none() ? 1 : seen.full() ? 2 : 3;
      pilot->mixed = pilot->mixed || pilot->emitters == 3;
    }
    const double scale = 1.0 / used;
    if (every_point) {
      punctual = refined_punctual(t, points, counts);
    } else {
      punctual = pilot_punctual(texel, points, used, stride, *pilot, counts) * scale;
    }
    return {to_float(punctual), to_float(emitted * scale), to_float(open_emitted * scale)};
  }

 private:
  /// Punctual light by formula at the used points, one shadow ray a light from the central one;
  /// returns the sum over the points.
  Rgbd pilot_punctual(const atlas::Texel& texel, const TexelPoints& points, std::uint32_t used,
                      std::uint32_t stride, Pilot& pilot, BakeCounts& counts) const {
    Rgbd sum;
    if (lights_.empty()) return sum;
    const float lift = input_.direct.lift();
    const Receiver centre =
        receiver_at(input_.scene, input_.layout, central_point(input_.texels, texel), lift);
    std::array<Receiver, 16> at;
    for (std::uint32_t i = 0; i < used; ++i) {
      at[i] = receiver_at(input_.scene, input_.layout,
                          points.point[std::min(points.count - 1, i * stride + stride / 2)], lift);
    }
    std::uint32_t hash = 1;
    for (const auto& light : lights_) {
      Rgbd open;
      int dark = 0;
      for (std::uint32_t i = 0; i < used; ++i) {
        const Rgb value = light.irradiance(at[i].frame.position, at[i].frame.normal);
        dark += value.is_black() ? 1 : 0;
        open += to_double(value);
      }
      if (open.is_black()) {
        hash = hash * 0x9e3779b1u + 1;
        continue;
      }
      if (dark > 0) pilot.mixed = true;  // the edge of a cone or of a range
      const Rgb share = input_.direct.punctual_visibility(centre, light, counts.rays);
      if (!(share == Rgb{1, 1, 1}) && !share.is_black()) pilot.mixed = true;
      hash = hash * 0x9e3779b1u + (share.is_black() ? 2 : 3);
      sum += open * to_double(share);
    }
    pilot.punctual = hash;
    return sum;
  }

  /// Mean punctual light over the texel: one shadow ray a light from every point; where a shadow's
  /// edge runs through the texel, more rounds from points moved (Owen-Sobol) within their share of
  /// it.
  Rgbd refined_punctual(std::uint32_t t, const TexelPoints& points, BakeCounts& counts) const {
    Rgbd total;
    if (lights_.empty()) return total;
    const float lift = input_.direct.lift();
    std::array<Receiver, 16> at;
    for (std::uint32_t i = 0; i < points.count; ++i) {
      at[i] = receiver_at(input_.scene, input_.layout, points.point[i], lift);
    }
    const int extra = settings_.edge_rounds;
    for (std::size_t l = 0; l < lights_.size(); ++l) {
      const auto& light = lights_[l];
      const auto arrives = [&](const Receiver& from, Rgbd& sum, bool& dark, bool& lit) {
        const Rgb open = light.irradiance(from.frame.position, from.frame.normal);
        const Rgb share =
            open.is_black() ? Rgb{} : input_.direct.punctual_visibility(from, light, counts.rays);
        (share.is_black() ? dark : lit) = true;
        sum += to_double(open * share);
      };
      Rgbd sum;
      bool dark = false, lit = false;
      for (std::uint32_t i = 0; i < points.count; ++i) arrives(at[i], sum, dark, lit);
      std::uint32_t taken = points.count;
      if (dark && lit) {
        for (std::uint32_t i = 0; i < points.count; ++i) {
          const OwenSobol2 shift(
              static_cast<std::uint32_t>(item_seed(input_.seed, t, 300 + 16 * l + i)));
          for (std::uint32_t round = 0; round < static_cast<std::uint32_t>(extra); ++round) {
            const TexelPoints::Point moved =
                moved_within(input_.layout, points.point[i], shift.point(round));
            arrives(receiver_at(input_.scene, input_.layout, moved, lift), sum, dark, lit);
          }
        }
        taken += points.count * static_cast<std::uint32_t>(extra);
      }
      total += sum / static_cast<double>(taken);
    }
    return total;
  }

  const BakeInput& input_;
  const GatherSettings& settings_;
  const std::vector<radiosity::PunctualLight>& lights_;
};

/// Visits the texel's eight neighbours in its own chart.
template <typename Visit>
void for_each_neighbour(const atlas::TexelMap& map, const atlas::Layout& layout, std::uint32_t t,
                        Visit visit) {
  const atlas::Texel& texel = map.texels[t];
  const atlas::Page& page = layout.pages[texel.page];
  const auto& index = map.index[texel.page];
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int x = texel.x + dx;
      const int y = texel.y + dy;
      if ((dx == 0 && dy == 0) || x < 0 || y < 0 || x >= page.width || y >= page.height) continue;
      const std::uint32_t other = index[static_cast<std::size_t>(y * page.width + x)];
      if (other != scene::kNone && map.texels[other].chart == texel.chart) visit(dx, dy, other);
    }
  }
}

/// A texel whose pilot differs from a neighbour's of the same chart.
bool differs_from_neighbour(const atlas::TexelMap& map, const atlas::Layout& layout,
                            const std::vector<Pilot>& pilots, std::uint32_t t) {
  bool differs = false;
  for_each_neighbour(map, layout, t, [&](int, int, std::uint32_t other) {
    if (!pilots[other].measured) return;
    differs = differs || !(pilots[other] == pilots[t]) || pilots[other].mixed;
  });
  return differs;
}

/// Visible share of the emitters, per channel mean.
float visible_share(const Parts& p) {
  return p.open.sum() > 0 ? p.emitted.sum() / p.open.sum() : 0;
}

/// Evens out the noise of visibility between refined neighbours: the share becomes the mean over
/// opposite pairs of neighbours (which keeps gradients), where all differ by no more than noise of
/// `rays` stratified samples explains; edges sharper than that stay as they are.
std::vector<Parts> smooth_visibility(const BakeInput& input, const std::vector<Parts>& parts,
                                     const std::vector<std::uint32_t>& refined,
                                     const std::vector<std::uint8_t>& is_refined, int rays) {
  // Owen-Sobol samples of an edge: standard error about 0.5 N^-0.75; three of them.
  const float slack = 1.5f * std::pow(static_cast<float>(rays), -0.75f);
  std::vector<Parts> smooth(refined.size());
  parallel_for(refined.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t t = refined[i];
      smooth[i] = parts[t];
      const float own = visible_share(parts[t]);
      if (parts[t].open.is_black()) continue;
      std::array<std::uint32_t, 9> at;
      at.fill(scene::kNone);
      for_each_neighbour(input.texels, input.layout, t, [&](int dx, int dy, std::uint32_t n) {
        at[static_cast<std::size_t>(3 * (dy + 1) + dx + 1)] = n;
      });
      float sum = own, weight = 1;
      for (std::size_t k = 0; k < 4; ++k) {
        const std::uint32_t a = at[k], b = at[8 - k];
        if (a == scene::kNone || b == scene::kNone || !is_refined[a] || !is_refined[b]) continue;
        const float va = visible_share(parts[a]), vb = visible_share(parts[b]);
        if (std::fabs(va + vb - 2 * own) > 2 * slack || std::fabs(va - vb) > 6 * slack) continue;
        sum += va + vb;
        weight += 2;
      }
      if (own > 0) smooth[i].emitted = parts[t].emitted * (sum / weight / own);
    }
  });
  return smooth;
}

}  // namespace

std::vector<Rgb> bake_direct(const BakeInput& input, const GatherSettings& settings,
                             BakeCounts& counts, const Progress& progress) {
  const std::size_t count = input.texels.texels.size();
  std::vector<Rgb> direct(count);
  if (!input.direct_lights || count == 0) return direct;
  const DirectMap map(input, settings);
  std::vector<Pilot> pilots(count);
  std::vector<BakeCounts> block((count + kGrain - 1) / kGrain);
  const auto pilot_points = static_cast<std::uint32_t>(std::clamp(settings.pilot_rays, 1, 16));
  const auto wanted = [&](std::size_t t) {
    return input.selected == nullptr || (*input.selected)[t] != 0;
  };
  std::vector<Parts> parts(count);
  parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    if (progress.cancelled()) return;
    for (std::size_t i = begin; i < end; ++i) {
      if (!wanted(i)) continue;
      parts[i] = map.measure(static_cast<std::uint32_t>(i), pilot_points, settings.pilot_rays,
                             false, &pilots[i], block[begin / kGrain]);
    }
  });
  std::vector<std::uint32_t> refined;
  std::vector<std::uint8_t> is_refined(count, 0);
  for (std::uint32_t t = 0; t < count; ++t) {
    if (!wanted(t)) continue;
    if (pilots[t].mixed || differs_from_neighbour(input.texels, input.layout, pilots, t)) {
      refined.push_back(t);
      is_refined[t] = 1;
    }
  }
  parallel_for(refined.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    if (progress.cancelled()) return;
    for (std::size_t i = begin; i < end; ++i) {
      parts[refined[i]] =
          map.measure(refined[i], 16, settings.refined_rays, true, nullptr, block[begin / kGrain]);
    }
  });
  const std::vector<Parts> smooth =
      smooth_visibility(input, parts, refined, is_refined, settings.refined_rays);
  for (std::size_t i = 0; i < refined.size(); ++i) parts[refined[i]] = smooth[i];
  for (std::size_t t = 0; t < count; ++t) direct[t] = parts[t].punctual + parts[t].emitted;
  for (const BakeCounts& c : block) counts += c;
  counts.refined_texels += refined.size();
  return direct;
}

}  // namespace lightbatch::lightmap
