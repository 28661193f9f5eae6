// Bent by a normal map of ordinary strength, irradiance changes by a fraction of itself only, and
// where light comes from changes slowly over a chart, punctual lights' shadows apart: a few rays a
// texel are enough, whose sums are averaged with those of the texels around.

#include "core/lightmap/directional.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/lightmap/gather.h"
#include "core/lightmap/incident.h"
#include "core/lightmap/neighbours.h"
#include "core/lightmap/texel_points.h"

namespace lightbatch::lightmap {
namespace {

constexpr std::size_t kGrain = 256;
/// Rays of a texel against those of its irradiance, and at least.
constexpr int kShareOfRays = 32;
constexpr int kFewestRays = 4;
/// Sums of rays are averaged over 3 x 3 texels so often; not over folds, where less than this is
/// the cosine between normals.
constexpr int kRounds = 2;
constexpr float kSameNormal = 0.9f;
/// Punctual lights are asked from so many points of a texel; from its middle where there are many.
constexpr std::uint32_t kLightPoints = 8;
constexpr std::size_t kFewLights = 8;

/// Integrals of luminance, and of luminance times direction.
struct Moments {
  double all = 0;
  Vec3d towards{0, 0, 0};

  void add(const Vec3f& direction, double light) {
    all += light;
    towards = towards + to_double(direction) * light;
  }
  Moments& operator+=(const Moments& o) {
    all += o.all;
    towards = towards + o.towards;
    return *this;
  }
};

/// Light at the texels by where it is taken from.
struct Measured {
  explicit Measured(std::size_t texels)
      : punctual(texels), sampled(texels), normal(texels, Vec3f{0, 0, 0}) {}
  std::vector<Moments> punctual, sampled;
  std::vector<Vec3f> normal;  // 0: not measured
};

class DirectionalTexels {
 public:
  DirectionalTexels(const BakeInput& input, const GatherSettings& settings)
      : input_(input),
        gather_(input, settings),
        incident_(input, gather_),
        rays_(static_cast<std::uint32_t>(directional_rays(settings.rays))) {}

  void measure(std::uint32_t t, Measured& light, BakeCounts& counts) const {
    const atlas::Texel& texel = input_.texels.texels[t];
    const TexelPoints points = texel_points(input_.texels, texel);
    const TexelPoints::Point middle = central_point(input_.texels, texel);
    light.normal[t] = receiver(middle).frame.normal;
    add_punctual(t, points, middle, counts, light.punctual[t]);
    add_sampled(t, points, counts, light.sampled[t]);
  }

 private:
  radiosity::Receiver receiver(const TexelPoints::Point& point) const {
    return receiver_at(input_.scene, input_.layout, point, input_.direct.lift());
  }

  void add_punctual(std::uint32_t t, const TexelPoints& points, const TexelPoints::Point& middle,
                    BakeCounts& counts, Moments& sum) const {
    const bool few = input_.direct.sources().punctual().size() <= kFewLights;
    const std::uint32_t wanted = few ? std::min(points.count, kLightPoints) : 1;
    const OwenSobol2 on_sun(static_cast<std::uint32_t>(item_seed(input_.seed, t, 52)));
    for (std::uint32_t i = 0; i < wanted; ++i) {
      const TexelPoints::Point& at = wanted == 1 ? middle : points.point[i];
      incident_.punctual(
          receiver(at), on_sun.point(i), counts, [&](const radiosity::Incident& light) {
            sum.add(light.direction, static_cast<double>(luminance(light.light)) / wanted);
          });
    }
  }

  void add_sampled(std::uint32_t t, const TexelPoints& points, BakeCounts& counts,
                   Moments& sum) const {
    const bool emitters = !input_.direct.sources().emitters().empty();
    if (!emitters && !input_.indirect) return;
    const std::uint64_t seed = item_seed(input_.seed, t, 51);
    const OwenSobol8 sequence(static_cast<std::uint32_t>(seed));
    for (std::uint32_t k = 0; k < rays_; ++k) {
      const auto i = std::min(
          points.count - 1,
          static_cast<std::uint32_t>(sequence.coordinate(k, 7) * static_cast<float>(points.count)));
      const radiosity::Receiver at = receiver(points.point[i]);
      if (emitters) {
        const radiosity::Incident light = incident_.emitter(at, sequence, k, seed, counts);
        sum.add(light.direction, static_cast<double>(luminance(light.light)) / rays_);
      }
      if (input_.indirect) {
        const IncidentLight::Ray ray = incident_.ray(at, sequence, k, seed, counts);
        sum.add(ray.direction, 2 * kPiDouble * luminance(ray.luminance) / rays_);
      }
    }
  }

  const BakeInput& input_;
  const Gather gather_;
  const IncidentLight incident_;
  const std::uint32_t rays_;
};

/// Sums of a texel's rays and of those around it.
Moments averaged(const BakeInput& input, const Measured& light, std::uint32_t t) {
  Moments sum;
  int texels = 0;
  for (const std::uint32_t other : neighbourhood(input.texels, input.layout, t)) {
    if (other == scene::kNone || !(dot(light.normal[other], light.normal[t]) > kSameNormal))
      continue;
    sum += light.sampled[other];
    ++texels;
  }
  return texels > 0 ? Moments{sum.all / texels, sum.towards / texels} : sum;
}

}  // namespace

int directional_rays(int rays) { return std::max(kFewestRays, rays / kShareOfRays); }

std::vector<std::uint8_t> charts_with_normal_maps(const scene::Scene& scene,
                                                  const atlas::Layout& layout) {
  std::vector<std::uint8_t> charts(layout.charts.size());
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const std::uint32_t chart = layout.chart_of[i];
    if (chart != scene::kNone && scene.material_of(i).has_normal_map) charts[chart] = 1;
  }
  return charts;
}

Result<DirectionalMap> bake_directional(const BakeInput& input, const GatherSettings& settings,
                                        const std::vector<std::uint8_t>& charts,
                                        const Progress& progress) {
  const auto& texels = input.texels.texels;
  DirectionalMap map;
  map.direction.resize(texels.size());
  const DirectionalTexels measure(input, settings);
  struct Block {
    BakeCounts counts;
    std::uint64_t texels = 0;
  };
  std::vector<Block> blocks((texels.size() + kGrain - 1) / kGrain);
  Measured light(texels.size());
  const auto for_texels = [&](const auto& visit) {
    parallel_for(texels.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end && !progress.cancelled(); ++t) {
        const bool wanted = input.selected == nullptr || (*input.selected)[t] != 0;
        if (!wanted || charts[texels[t].chart] == 0) continue;
        visit(static_cast<std::uint32_t>(t), blocks[begin / kGrain]);
      }
    });
  };
  for_texels([&](std::uint32_t t, Block& block) {
    measure.measure(t, light, block.counts);
    ++block.texels;
  });
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Moments> next(texels.size());
    for_texels([&](std::uint32_t t, Block&) { next[t] = averaged(input, light, t); });
    light.sampled.swap(next);
  }
  for_texels([&](std::uint32_t t, Block&) {
    Moments sum = light.punctual[t];
    sum += light.sampled[t];
    if (sum.all > 0) map.direction[t] = to_float(sum.towards / sum.all);
  });
  if (progress.cancelled()) return cancelled();
  for (const Block& block : blocks) {
    map.counts += block.counts;
    map.texels += block.texels;
  }
  return map;
}

}  // namespace lightbatch::lightmap
