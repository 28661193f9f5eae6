#include "core/plan/sky_probes.h"

#include <algorithm>
#include <vector>

#include "core/base/random.h"
#include "core/math/sampling.h"
#include "core/optics/surface_frame.h"

namespace lightbatch::plan {
namespace {

using scene::Scene;

/// Probes are cast in rounds, each as many again as all before it, until one escapes.
constexpr int kFirstRound = 4096;
constexpr int kMostProbes = 65536;

bool escapes(const rays::Caster& caster, const optics::Optics& optics, const rays::Ray& ray,
             std::uint32_t from) {
  optics::ShadowFilter filter(optics);
  return !caster.occluded(ray, from, rays::kNoTriangle, &filter);
}

template <typename Probe>
SkyProbes probe_until_found(Probe probe) {
  SkyProbes found;
  for (int end = kFirstRound; end <= kMostProbes && found.escaped == 0; end *= 2) {
    for (; found.cast < end; ++found.cast) found.escaped += probe(found.cast) ? 1 : 0;
  }
  return found;
}

/// Areas of all triangles up to each, in square metres.
std::vector<double> areas_up_to(const Scene& scene) {
  std::vector<double> sums(scene.triangles.size());
  double sum = 0;
  for (std::uint32_t i = 0; i < sums.size(); ++i) {
    sum += scene.area(i);
    sums[i] = sum;
  }
  return sums;
}

/// Draws one of the triangles [first, last) by area.
std::uint32_t by_area(const std::vector<double>& sums, std::size_t first, std::size_t last,
                      Random& random) {
  const double below = first > 0 ? sums[first - 1] : 0;
  const double at = below + random.next_double() * (sums[last - 1] - below);
  const auto begin = sums.begin() + static_cast<std::ptrdiff_t>(first);
  const auto end = sums.begin() + static_cast<std::ptrdiff_t>(last - 1);
  return static_cast<std::uint32_t>(std::upper_bound(begin, end, at) - sums.begin());
}

}  // namespace

SkyProbes probe_surfaces(const Scene& scene, const optics::Optics& optics,
                         const rays::Caster& caster) {
  if (scene.triangles.empty()) return {};
  const float lift = optics::lift_of(scene);
  const std::vector<double> sums = areas_up_to(scene);
  Random random(0x517);
  return probe_until_found([&](int k) {
    std::uint32_t triangle = 0;
    if (k % 3 == 0) {
      triangle = by_area(sums, 0, sums.size(), random);
    } else if (k % 3 == 1) {
      triangle = static_cast<std::uint32_t>(random.below(sums.size()));
    } else {
      const scene::Object& object = scene.objects[random.below(scene.objects.size())];
      triangle = by_area(sums, object.first_triangle, object.first_triangle + object.triangle_count,
                         random);
    }
    const Vec2f p = uniform_triangle({random.next_float(), random.next_float()});
    const bool back = random.next_float() < 0.5f && optics.has_two_sides(triangle);
    const auto frame = optics::surface_frame(scene, triangle, p.x, p.y, back, lift);
    const Vec3f direction =
        Frame::about(frame.normal)
            .to_world(cosine_hemisphere({random.next_float(), random.next_float()}));
    return escapes(caster, optics, {frame.origin, direction}, triangle);
  });
}

SkyProbes probe_moving(const Scene& scene, const optics::Optics& optics,
                       const rays::Caster& caster) {
  if (scene.moving.empty()) return {};
  Random random(0x518);
  return probe_until_found([&](int) {
    const Aabbd& box = scene.moving[random.below(scene.moving.size())].swept;
    const Vec3d within = box.extent();
    const Vec3d at = box.lower - scene.origin +
                     Vec3d{within.x * random.next_double(), within.y * random.next_double(),
                           within.z * random.next_double()};
    const Vec3f direction = uniform_sphere({random.next_float(), random.next_float()});
    return escapes(caster, optics, {to_float(at), direction}, rays::kNoTriangle);
  });
}

}  // namespace lightbatch::plan
