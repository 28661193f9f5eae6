#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/accuracy/light_tree.h"
#include "core/math/rgb.h"
#include "core/optics/environment.h"
#include "core/optics/optics.h"
#include "core/optics/surface_frame.h"
#include "core/rays/caster.h"

namespace lightbatch::accuracy {

/// A place on one side of a triangle.
struct SurfacePoint {
  std::uint32_t triangle = 0;
  float u = 0, v = 0;
  bool back = false;  // the clockwise side
};

/// Draws one of the points that an estimate is the mean of: `which` and `within` are uniform in
/// [0, 1) and stratified over the paths. Must be thread-safe.
using PointSource = std::function<SurfacePoint(float which, Vec2f within)>;
/// Each of the points equally likely. Not empty.
PointSource among(std::vector<SurfacePoint> points);

/// What of the light is traced: all, unless a part was switched off.
struct TracedLight {
  LightTree::Kinds lights;
  /// What arrives from punctual lights without a bounce.
  bool punctual_direct = true;
  bool interreflection = true;
  bool shadows = true;  // of lights
};

/// Sums over the paths of one estimate.
struct PathSum {
  Rgbd irradiance;  // mean, lux
  Rgbd variance;    // of one path
  std::uint64_t paths = 0;
  std::uint64_t rays = 0;  // shadow rays included
};

/// Unbiased irradiance at surface points by path tracing: the judge of every other number. Shares
/// with the solver only geometry (the caster), materials (optics), lights and sky; it samples the
/// lights on its own.
///
/// Next-event estimation at every vertex with multiple importance sampling against the cosine
/// (emitting triangles, environment maps), unbiased Russian roulette, no limit on bounces or
/// sheets. Thread-safe; results depend on the arguments alone.
class PathTracer {
 public:
  PathTracer(const rays::Caster& caster, const optics::Optics& optics,
             const optics::Environment& sky, const TracedLight& traced = {});

  /// Mean irradiance over the points of a source, by `samples` paths. Calls with different seeds
  /// are independent of each other.
  PathSum irradiance(const PointSource& source, std::uint32_t samples, std::uint64_t seed) const;
  /// Over the points, each equally likely; nothing when there are none.
  PathSum irradiance(std::span<const SurfacePoint> points, std::uint32_t samples,
                     std::uint64_t seed) const;

 private:
  struct Vertex;
  class Numbers;

  Rgb trace(const SurfacePoint& start, Numbers& numbers, std::uint64_t& rays) const;
  Rgb direct(const Vertex& at, bool punctual, Numbers& numbers, std::uint64_t& rays) const;
  Rgb from_triangle(const Vertex& at, const LightTree::Pick& pick, Vec2f random,
                    std::uint64_t& rays) const;
  Rgb emitted(const rays::Hit& hit, float distance, const Vertex& from, float cosine) const;
  Rgb escaped(const Vec3f& direction, float cosine) const;
  Rgb visible(const Vertex& at, const Vec3f& towards, float reach, std::uint32_t other,
              std::uint64_t& rays) const;
  bool is_hole(std::uint32_t triangle, float u, float v) const;

  const rays::Caster* caster_;
  const optics::Optics* optics_;
  const optics::Environment* sky_;
  LightTree lights_;
  float lift_ = 0;
  bool filtered_ = false;
  bool sample_sky_ = false;
  TracedLight traced_;
};

}  // namespace lightbatch::accuracy
