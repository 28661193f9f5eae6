#include "core/scene_out/vertex_light.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <tuple>
#include <unordered_map>

#include "core/base/parallel.h"
#include "core/base/random.h"

namespace lightbatch::scene_out {
namespace {

/// Light at a corner is read a little inside, where the triangle's own texels are.
constexpr float kInset = 0.02f;
constexpr std::size_t kGrain = 64;

struct Corner {
  LightPoint at;
  Vec3f position;
  Rgb light;
  Rgb emission;
  /// Emission as the irradiance that would look the same on white.
  Rgb seen() const { return light + emission * std::numbers::pi_v<float>; }
};
using Face = std::array<Corner, 3>;

void set_light(const Writer& w, Corner& corner) {
  const LightPoint& p = corner.at;
  const float third = 1.0f / 3.0f;
  const float u = p.u + (third - p.u) * kInset, v = p.v + (third - p.v) * kInset;
  corner.light = w.options.irradiance(p.triangle, u, v);
  if (w.options.emission && colour_holds_all(w.scene.material_of(p.triangle))) {
    corner.emission = w.options.emission(p.triangle, u, v);
  }
}

Corner make_corner(const Writer& w, std::uint32_t triangle, float u, float v) {
  const auto c = w.scene.corners(triangle);
  return {{triangle, u, v}, c[0] * (1 - u - v) + c[1] * u + c[2] * v, {}, {}};
}

/// An edge by its end positions: both triangles compute the same key, whatever their order.
struct EdgeKey {
  Vec3f a, b;
  bool operator==(const EdgeKey&) const = default;
};
struct EdgeHash {
  std::size_t operator()(const EdgeKey& k) const {
    std::uint64_t h = 0;
    for (const float f : {k.a.x, k.a.y, k.a.z, k.b.x, k.b.y, k.b.z})
      h = mix_bits(h ^ std::bit_cast<std::uint32_t>(f));
    return h;
  }
};
EdgeKey edge_key(const Vec3f& a, const Vec3f& b) {
  const bool swap = std::tie(b.x, b.y, b.z) < std::tie(a.x, a.y, a.z);
  return swap ? EdgeKey{b, a} : EdgeKey{a, b};
}

Corner middle(const Corner& a, const Corner& b) {
  // Rounded the same way from either side: a sum does not depend on its order.
  return {{a.at.triangle, 0.5f * (a.at.u + b.at.u), 0.5f * (a.at.v + b.at.v)},
          (a.position + b.position) * 0.5f,
          {},
          {}};
}

float step_of(const Rgb& ends, const Rgb& mid) {
  const Rgb d = ends - mid;
  return std::max(std::abs(d.r), std::max(std::abs(d.g), std::abs(d.b)));
}

/// The faces that replace a face whose edges (01, 12, 20) have middles where `split` says so.
void emit(const Face& f, const std::array<Corner, 3>& m, const std::array<bool, 3>& split,
          std::vector<Face>& out) {
  const int count = int{split[0]} + int{split[1]} + int{split[2]};
  if (count == 0) {
    out.push_back(f);
  } else if (count == 3) {
    out.insert(out.end(), {Face{f[0], m[0], m[2]}, Face{m[0], f[1], m[1]}, Face{m[2], m[1], f[2]},
                           Face{m[0], m[1], m[2]}});
  } else {
    // Turned so that edge k is split and, of two, k + 1 too.
    std::size_t k = 0;
    while (!(split[k] && (count == 1 || split[(k + 1) % 3]))) ++k;
    const Corner &a = f[k], &b = f[(k + 1) % 3], &c = f[(k + 2) % 3];
    const Corner &ab = m[k], &bc = m[(k + 1) % 3];
    if (count == 1)
      out.insert(out.end(), {Face{a, ab, c}, Face{ab, b, c}});
    else
      out.insert(out.end(), {Face{ab, b, bc}, Face{a, ab, bc}, Face{a, bc, c}});
  }
}

}  // namespace

LitTriangles subdivide(const Writer& w, const std::vector<std::uint32_t>& triangles,
                       double exposure) {
  std::vector<Face> faces(triangles.size());
  parallel_for(faces.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      faces[i] = {make_corner(w, triangles[i], 0, 0), make_corner(w, triangles[i], 1, 0),
                  make_corner(w, triangles[i], 0, 1)};
      for (Corner& c : faces[i]) set_light(w, c);
    }
  });
  const double scale = exposure / std::numbers::pi;
  for (int level = 0; level < w.options.subdivisions; ++level) {
    std::vector<std::array<Corner, 3>> middles(faces.size());
    std::vector<std::array<bool, 3>> wants(faces.size());
    parallel_for(faces.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t e = 0; e < 3; ++e) {
          const Corner &a = faces[i][e], &b = faces[i][(e + 1) % 3];
          Corner& m = middles[i][e] = middle(a, b);
          set_light(w, m);
          const double step =
              static_cast<double>(step_of((a.seen() + b.seen()) * 0.5f, m.seen())) * scale;
          wants[i][e] = step > w.options.colour_step;
        }
    });
    std::unordered_map<EdgeKey, bool, EdgeHash> split;
    bool any = false;
    for (std::size_t i = 0; i < faces.size(); ++i)
      for (std::size_t e = 0; e < 3; ++e)
        if (wants[i][e]) {
          split[edge_key(faces[i][e].position, faces[i][(e + 1) % 3].position)] = true;
          any = true;
        }
    if (!any) break;
    std::vector<Face> finer;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      std::array<bool, 3> here{};
      for (std::size_t e = 0; e < 3; ++e)
        here[e] = split.contains(edge_key(faces[i][e].position, faces[i][(e + 1) % 3].position));
      emit(faces[i], middles[i], here, finer);
    }
    faces = std::move(finer);
  }
  LitTriangles result;
  for (const Face& f : faces)
    for (const Corner& c : f) {
      result.corners.push_back(c.at);
      result.irradiance.push_back(c.light);
      result.emission.push_back(c.emission);
    }
  return result;
}

double choose_exposure(const scene::Scene& scene, const WriteOptions& options) {
  if (options.exposure > 0) return options.exposure;
  std::vector<std::pair<double, double>> samples(scene.triangles.size());  // light, area
  parallel_for(samples.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (!options.lit.empty() && options.lit[t] == 0) continue;
      const auto c = scene.corners(static_cast<std::uint32_t>(t));
      const Rgb e = options.irradiance(static_cast<std::uint32_t>(t), 1.0f / 3, 1.0f / 3);
      samples[t] = {static_cast<double>(e.max()),
                    0.5 * static_cast<double>(length(cross(c[1] - c[0], c[2] - c[0])))};
    }
  });
  std::sort(samples.begin(), samples.end());
  double total = 0, sum = 0, bright = 0;
  for (const auto& [light, area] : samples) total += area;
  for (const auto& [light, area] : samples) {
    sum += area;
    bright = light;
    if (sum >= 0.99 * total) break;
  }
  return bright > 0 ? std::numbers::pi / bright : 1;
}

}  // namespace lightbatch::scene_out
