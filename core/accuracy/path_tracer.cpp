// Path tracing (Kajiya 1986) with next-event estimation and multiple importance sampling by the
// balance heuristic (Veach 1997). All surfaces are diffuse; sheets send a ray on or back by a
// random choice, so a path never branches. The first dimensions of a path are Owen-scrambled
// Sobol points, the rest random numbers.
#include "core/accuracy/path_tracer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/random.h"
#include "core/math/sampling.h"
#include "core/math/sobol.h"

namespace lightbatch::accuracy {

struct PathTracer::Vertex {
  optics::SurfaceFrame frame;
  std::uint32_t triangle = 0;
};

/// The random numbers of one path: two sets of eight Sobol dimensions, the second with its own
/// shuffle of the points (Burley 2020), then plain random numbers.
class PathTracer::Numbers {
 public:
  struct Sets {
    explicit Sets(std::uint64_t seed)
        : first(static_cast<std::uint32_t>(seed)),
          second(static_cast<std::uint32_t>(seed >> 32)),
          shuffle(static_cast<std::uint32_t>(mix_bits(seed))) {}
    OwenSobol8 first, second;
    std::uint32_t shuffle;
  };

  Numbers(const Sets& sets, std::uint32_t index, std::uint64_t seed)
      : sets_(sets),
        index_(index),
        second_index_(sobol::reverse_bits(
            sobol::scramble_reversed(sobol::reverse_bits(index), sets.shuffle))),
        random_(seed) {}

  /// Where the path starts. (By index, points would get one half of every dimension each.)
  SurfacePoint start(const PointSource& source) const {
    return source(sets_.second.coordinate(second_index_, 0), sets_.second.pair(second_index_, 6));
  }
  void next_vertex() { ++depth_; }
  Vec2f direction() {
    if (depth_ == 0) return sets_.first.pair(index_, 0);
    if (depth_ == 1) return sets_.first.pair(index_, 5);
    return {random_.next_float(), random_.next_float()};
  }
  Vec2f light_point() {
    if (depth_ == 0) return sets_.first.pair(index_, 2);
    if (depth_ == 1) return sets_.second.pair(second_index_, 3);
    return {random_.next_float(), random_.next_float()};
  }
  double light_pick() {
    // Sobol numbers have 24 bits; among many lights the pick needs more.
    const double more = random_.next_double();
    if (depth_ == 0) return wide(sets_.first.coordinate(index_, 4), more);
    if (depth_ == 1) return wide(sets_.second.coordinate(second_index_, 5), more);
    return more;
  }
  Vec2d sky() {
    const Vec2d more{random_.next_double(), random_.next_double()};
    if (depth_ > 0) return more;
    return {wide(sets_.second.coordinate(second_index_, 1), more.x),
            wide(sets_.second.coordinate(second_index_, 2), more.y)};
  }
  double roulette() {
    if (depth_ != 1 || roulette_done_) return random_.next_double();
    roulette_done_ = true;
    return static_cast<double>(sets_.first.coordinate(index_, 7));
  }

 private:
  static double wide(float sobol, double more) {
    return static_cast<double>(sobol) + more * 0x1p-24;
  }

  const Sets& sets_;
  std::uint32_t index_;
  std::uint32_t second_index_;
  Random random_;
  int depth_ = 0;
  bool roulette_done_ = false;
};

PathTracer::PathTracer(const rays::Caster& caster, const optics::Optics& optics,
                       const optics::Environment& sky, const TracedLight& traced)
    : caster_(&caster),
      optics_(&optics),
      sky_(&sky),
      lights_(optics.scene(), optics, traced.lights),
      lift_(optics::lift_of(optics.scene())),
      filtered_(optics.filtered_count() > 0),
      sample_sky_(!sky.is_black() && !sky.is_uniform()),
      traced_(traced) {}

/// Cut away by an alpha mask: no surface there.
bool PathTracer::is_hole(std::uint32_t triangle, float u, float v) const {
  return filtered_ && optics_->surfaces()[triangle] == rays::Surface::kFiltered &&
         !optics_->sheet(triangle) && !optics_->transmittance(triangle, u, v).is_black();
}

/// Transmittance from a vertex along `towards` up to t = reach.
Rgb PathTracer::visible(const Vertex& at, const Vec3f& towards, float reach, std::uint32_t other,
                        std::uint64_t& rays) const {
  if (!traced_.shadows) return {1, 1, 1};
  ++rays;
  const rays::Ray ray{at.frame.origin, towards, 0, reach};
  if (!filtered_) {
    return caster_->occluded(ray, at.triangle, other) ? Rgb{} : Rgb{1, 1, 1};
  }
  optics::ShadowFilter filter(*optics_);
  if (caster_->occluded(ray, at.triangle, other, &filter)) return {};
  return filter.transmittance();
}

Rgb PathTracer::from_triangle(const Vertex& at, const LightTree::Pick& pick, Vec2f random,
                              std::uint64_t& rays) const {
  const std::uint32_t triangle = lights_.triangle(pick.light);
  const auto c = optics_->scene().corners(triangle);
  const Vec2f uv = uniform_triangle(random);
  const Vec3f e1 = c[1] - c[0], e2 = c[2] - c[0];
  const Vec3f point = c[0] + e1 * uv.x + e2 * uv.y;
  const Vec3d doubled = cross(to_double(e1), to_double(e2));
  const double size = length(doubled);
  Vec3f normal = to_float(doubled / size);
  const Vec3f straight = point - at.frame.origin;
  if (dot(normal, straight) > 0) {
    if (!optics_->double_sided(triangle)) return {};
    normal = -normal;
  }
  const Vec3f towards = straight + normal * optics::lift_at_lamp(point, lift_);
  const double d2 = static_cast<double>(dot(towards, towards));
  const double d = std::sqrt(d2);
  const double cos_here = static_cast<double>(dot(at.frame.normal, towards)) / d;
  const double cos_there = -static_cast<double>(dot(normal, towards)) / d;
  if (!(cos_here > 0 && cos_there > 0) || is_hole(triangle, uv.x, uv.y)) return {};
  const Rgb emission = optics_->emission(triangle, uv.x, uv.y);
  if (emission.is_black()) return {};
  const Rgb share = visible(at, towards, 1, triangle, rays);
  if (share.is_black()) return {};
  // Densities per solid angle.
  const double by_light = pick.probability * 2 / size * d2 / cos_there;
  const double by_cosine = traced_.shadows ? cos_here / kPiDouble : 0;
  return emission * share * static_cast<float>(cos_here / (by_light + by_cosine));
}

/// Irradiance at a vertex from lights by next-event estimation (with its share of the weights).
Rgb PathTracer::direct(const Vertex& at, bool punctual, Numbers& numbers,
                       std::uint64_t& rays) const {
  Rgb sum;
  if (!lights_.is_empty()) {
    const LightTree::Pick pick =
        lights_.pick(at.frame.origin, at.frame.normal, numbers.light_pick());
    const Vec2f random = numbers.light_point();
    if (pick.probability > 0) {
      if (lights_.is_triangle(pick.light)) {
        sum += from_triangle(at, pick, random, rays);
      } else if (punctual) {
        const Rgb e = lights_.punctual_irradiance(pick.light, at.frame.origin, at.frame.normal);
        if (!e.is_black()) {
          const Vec3f towards = lights_.position(pick.light) - at.frame.origin;
          const float end = optics::shadow_end(towards, lights_.position(pick.light), lift_);
          sum += e * visible(at, towards, end, rays::kNoTriangle, rays) *
                 static_cast<float>(1 / pick.probability);
        }
      }
    }
  }
  for (const LightTree::Sun& sun : lights_.suns()) {
    const float cosine = dot(sun.towards, at.frame.normal);
    if (!punctual || !(cosine > 0)) continue;
    sum +=
        sun.illuminance *
        visible(at, sun.towards, std::numeric_limits<float>::infinity(), rays::kNoTriangle, rays) *
        cosine;
  }
  if (sample_sky_) {
    const Vec2d random = numbers.sky();
    const optics::Environment::Sample s = sky_->sample(random.x, random.y);
    const float cosine = dot(s.direction, at.frame.normal);
    if (cosine > 0 && !s.radiance.is_black()) {
      const double weight = s.density + static_cast<double>(cosine) / kPiDouble;
      sum += s.radiance *
             visible(at, s.direction, std::numeric_limits<float>::infinity(), rays::kNoTriangle,
                     rays) *
             static_cast<float>(static_cast<double>(cosine) / weight);
    }
  }
  return sum;
}

/// Irradiance by a cosine ray that met an emitter (with its share of the weights).
Rgb PathTracer::emitted(const rays::Hit& hit, float distance, const Vertex& from,
                        float cosine) const {
  if (!traced_.lights.emitters || !optics_->emits(hit.triangle) ||
      (hit.back && !optics_->double_sided(hit.triangle))) {
    return {};
  }
  const Rgb emission = optics_->emission(hit.triangle, hit.u, hit.v);
  const std::uint32_t light = lights_.light_of(hit.triangle);
  if (light == LightTree::kNoLight) return emission * kPi;
  if (!traced_.shadows) return {};  // asked as a light, whatever stands between
  const auto c = optics_->scene().corners(hit.triangle);
  const Vec3d doubled = cross(to_double(c[1] - c[0]), to_double(c[2] - c[0]));
  const Vec3d point = to_double(c[0]) + to_double(c[1] - c[0]) * static_cast<double>(hit.u) +
                      to_double(c[2] - c[0]) * static_cast<double>(hit.v);
  const Vec3d towards = point - to_double(from.frame.origin);
  const double d = static_cast<double>(distance);
  const double area_cosine = std::abs(dot(doubled, towards)) / 2 / d;  // area times cosine
  if (!(area_cosine > 0)) return {};
  const double chance = lights_.probability(light, from.frame.origin, from.frame.normal);
  const double by_light = chance * d * d / area_cosine;
  const double by_cosine = static_cast<double>(cosine) / kPiDouble;
  return emission * static_cast<float>(static_cast<double>(cosine) / (by_light + by_cosine));
}

Rgb PathTracer::escaped(const Vec3f& direction, float cosine) const {
  if (sky_->is_black()) return {};
  const Rgb radiance = sky_->radiance(direction);
  if (!sample_sky_) return radiance * kPi;
  const double c = static_cast<double>(cosine);
  return radiance * static_cast<float>(c / (sky_->density(direction) + c / kPiDouble));
}

Rgb PathTracer::trace(const SurfacePoint& start, Numbers& numbers, std::uint64_t& rays) const {
  const scene::Scene& scene = optics_->scene();
  Vertex at{optics::surface_frame(scene, start.triangle, start.u, start.v, start.back, lift_),
            start.triangle};
  Rgb weight{1, 1, 1};  // of irradiance at the vertex in irradiance at the start
  Rgb sum;
  for (bool punctual = traced_.punctual_direct;; punctual = true) {
    sum += weight * direct(at, punctual, numbers, rays);
    const Vec3f local = cosine_hemisphere(numbers.direction());
    numbers.next_vertex();
    rays::Ray ray{at.frame.origin, Frame::about(at.frame.normal).to_world(local)};
    std::uint32_t exclude = at.triangle;
    for (;;) {  // through sheets to the next vertex
      ++rays;
      optics::ClosestFilter filter(*optics_);
      const rays::Hit hit = caster_->closest(ray, exclude, filtered_ ? &filter : nullptr);
      if (!hit.found()) return sum + weight * escaped(ray.direction, local.z);
      sum += weight * emitted(hit, hit.t, at, local.z);
      const bool reflects = !hit.back || optics_->has_two_sides(hit.triangle);
      const Rgb back = reflects ? weight * optics_->reflectance(hit.triangle, hit.u, hit.v) : Rgb{};
      const Rgb on = filtered_ && optics_->sheet(hit.triangle)
                         ? weight * optics_->transmittance(hit.triangle, hit.u, hit.v)
                         : Rgb{};
      const Rgb through = optics_->transmits_diffusely(hit.triangle)
                              ? weight * optics_->diffuse_transmittance(hit.triangle, hit.u, hit.v)
                              : Rgb{};
      // Goes back, through to the other side's hemisphere, straight on, or ends, so that the
      // largest channel of the weight stays 1 at most.
      const auto to_back = static_cast<double>(back.max());
      const double scattered = to_back + static_cast<double>(through.max());
      const auto to_on = static_cast<double>(on.max());
      const double scale = std::max(1.0, scattered + to_on);
      const double random = numbers.roulette() * scale;
      if (random < scattered) {
        if (!traced_.interreflection) return sum;
        const bool goes_back = random < to_back;
        weight = goes_back ? back * static_cast<float>(scale / to_back)
                           : through * static_cast<float>(scale / (scattered - to_back));
        at.frame =
            optics::surface_frame(scene, hit.triangle, hit.u, hit.v, hit.back == goes_back, lift_);
        at.triangle = hit.triangle;
        break;
      }
      if (random >= scattered + to_on) return sum;
      weight = on * static_cast<float>(scale / to_on);
      ray.t_min = hit.t;
      exclude = hit.triangle;
    }
  }
}

PointSource among(std::vector<SurfacePoint> points) {
  return [points = std::move(points)](float which, Vec2f) {
    const auto i =
        static_cast<std::size_t>(static_cast<double>(which) * static_cast<double>(points.size()));
    return points[std::min(points.size() - 1, i)];
  };
}

PathSum PathTracer::irradiance(std::span<const SurfacePoint> points, std::uint32_t samples,
                               std::uint64_t seed) const {
  if (points.empty()) return {};
  return irradiance(among({points.begin(), points.end()}), samples, seed);
}

PathSum PathTracer::irradiance(const PointSource& source, std::uint32_t samples,
                               std::uint64_t seed) const {
  PathSum result;
  if (samples == 0) return result;
  const Numbers::Sets sets(item_seed(seed, 0, 1));
  Rgbd sum, squares;
  for (std::uint32_t i = 0; i < samples; ++i) {
    Numbers numbers(sets, i, item_seed(seed, i, 2));
    const Rgbd e = to_double(trace(numbers.start(source), numbers, result.rays));
    sum += e;
    squares += e * e;
  }
  const double n = static_cast<double>(samples);
  result.paths = samples;
  result.irradiance = sum / n;
  const Rgbd spread = squares / n - result.irradiance * result.irradiance;
  const double correction = samples > 1 ? n / (n - 1) : 1;
  result.variance =
      Rgbd{std::max(0.0, spread.r), std::max(0.0, spread.g), std::max(0.0, spread.b)} * correction;
  return result;
}

}  // namespace lightbatch::accuracy
