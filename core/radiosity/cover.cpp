#include "core/radiosity/cover.h"

#include "core/base/parallel.h"
#include "core/math/sampling.h"
#include "core/optics/surface_frame.h"

namespace lightbatch::radiosity {
namespace {

/// In edges: how near a side is covered along its normal.
constexpr double kClose = 0.3;
constexpr double kCovered = 1.5;
/// Directions, by their share of what a side sees, that are asked whether something is near; so
/// many that are not leave the place open. The end of a narrow gap is closed in all but one.
constexpr std::uint32_t kAsked = 8;
constexpr int kOpenings = 2;

bool is_closed(const rays::Caster& caster, const optics::SurfaceFrame& at, std::uint32_t triangle,
               float reach) {
  const Frame frame = Frame::about(at.normal);
  int openings = 0;
  for (std::uint32_t k = 0; k < kAsked; ++k) {
    const Vec2f square{(static_cast<float>(k) + 0.5f) / kAsked,
                       (static_cast<float>((5 * k + 3) % kAsked) + 0.5f) / kAsked};
    const Vec3f direction = frame.to_world(cosine_hemisphere(square));
    if (caster.occluded({at.origin, direction, 0.0f, reach}, triangle)) continue;
    if (++openings == kOpenings) return false;
  }
  return true;
}

/// Close above, or by whether the place is closed and whether something is above at all.
int cover_of(const scene::Scene& scene, const rays::Caster& caster, std::uint32_t triangle,
             bool back, double edge) {
  constexpr float kMiddle = 1.0f / 3;
  const auto at =
      optics::surface_frame(scene, triangle, kMiddle, kMiddle, back, optics::lift_of(scene));
  const auto reach = static_cast<float>(kCovered * edge);
  const rays::Hit hit = caster.closest({at.origin, at.normal, 0.0f, reach}, triangle);
  if (hit.found() && static_cast<double>(hit.t) < kClose * edge) return 4;
  return (hit.found() ? 1 : 0) + (is_closed(caster, at, triangle, reach) ? 2 : 0);
}

}  // namespace

Covers::Covers(const scene::Scene& scene, const optics::Optics& optics, const rays::Caster* caster,
               double edge, const std::vector<std::uint8_t>& large) {
  if (caster == nullptr) return;
  cover_.resize(2 * scene.triangles.size());
  parallel_for(scene.triangles.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (large[i] != 0) continue;
      const auto triangle = static_cast<std::uint32_t>(i);
      for (int side = 0; side < (optics.has_two_sides(triangle) ? 2 : 1); ++side) {
        cover_[2 * i + static_cast<std::size_t>(side)] =
            static_cast<std::uint8_t>(cover_of(scene, *caster, triangle, side == 1, edge));
      }
    }
  });
}

}  // namespace lightbatch::radiosity
