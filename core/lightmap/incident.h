#pragma once

#include "core/base/random.h"
#include "core/lightmap/bake.h"
#include "core/lightmap/gather.h"
#include "core/math/sampling.h"
#include "core/math/sobol.h"

namespace lightbatch::lightmap {

/// Light that arrives at a point, direction by direction: what the irradiance of a texel does not
/// tell. The same first stage, lights and sky as every texel's. Thread-safe.
class IncidentLight {
 public:
  /// Both outlive it.
  IncidentLight(const BakeInput& input, const Gather& gather) : input_(input), gather_(gather) {}

  /// Punctual lights, unless viewers add them: deliver(radiosity::Incident) for each that reaches
  /// the point. on_sun: of suns of the sky, in [0, 1).
  template <typename Deliver>
  void punctual(const radiosity::Receiver& at, Vec2f on_sun, BakeCounts& counts,
                Deliver deliver) const {
    for (const radiosity::PunctualLight& light : input_.direct.sources().punctual()) {
      if (!input_.bakes_direct(light)) continue;
      const radiosity::Incident incident = input_.direct.punctual(at, light, on_sun, counts.rays);
      if (!incident.light.is_black()) deliver(incident);
    }
  }

  /// One emitter at random: the k-th of a sequence, each alone unbiased for all of them.
  radiosity::Incident emitter(const radiosity::Receiver& at, const OwenSobol8& sequence,
                              std::uint32_t k, std::uint64_t seed, BakeCounts& counts) const {
    // Sobol numbers have 24 bits; among many emitters the pick needs more.
    const double pick = static_cast<double>(sequence.coordinate(k, 2)) +
                        Random(item_seed(seed, k, 1)).next_double() * 0x1p-24;
    return input_.direct.sampled_emitter(at, 0, pick, sequence.pair(k, 3), counts.rays);
  }

  /// Surfaces and sky along the k-th of a sequence of rays, uniform over the hemisphere of the
  /// receiver's normal, or over the sphere where it is in space.
  struct Ray {
    Vec3f direction;
    Rgbd luminance;
    bool meets_back = false;
  };
  Ray ray(const radiosity::Receiver& at, const OwenSobol8& sequence, std::uint32_t k,
          std::uint64_t seed, BakeCounts& counts) const {
    const Vec2f square = sequence.pair(k, 0);
    Ray ray;
    ray.direction = at.is_in_space()
                        ? uniform_sphere(square)
                        : Frame::about(at.frame.normal).to_world(uniform_hemisphere(square));
    const Gather::Along along =
        gather_.along({at.frame.origin, ray.direction}, at.triangle,
                      {item_seed(seed, k), sequence.pair(k, 5)}, {}, counts);
    ray.luminance = along.radiosity / kPiDouble;
    ray.meets_back = along.meets_back;
    return ray;
  }

 private:
  const BakeInput& input_;
  const Gather& gather_;
};

}  // namespace lightbatch::lightmap
