#include "tests/bench/bench_rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/random.h"

namespace lightbatch::bench {
namespace {

using rays::Ray;

class RayMaker {
 public:
  explicit RayMaker(const Scene& scene)
      : scene_(scene), box_(scene.bounds()), epsilon_(box_.diagonal() * 1e-5f) {
    double sum = 0;
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
      sum += static_cast<double>(length(wide_normal(t)));
      sums_.push_back(sum);
    }
  }

  RaySet primary(std::size_t count) const {
    RaySet set{"primary", false, {}, {}};
    const int side = static_cast<int>(std::sqrt(static_cast<double>(count))) & ~7;
    const Vec3f c = box_.centre(), e = box_.extent();
    Vec3f eye = c + Vec3f{0.6f, 0.35f, 0.75f} * (0.55f * length(e)), at = c;
    if (scene_.inside) {
      const Vec3f along = e.x >= e.z ? Vec3f{1, 0, 0} : Vec3f{0, 0, 1};
      eye = c - along * (0.3f * std::max(e.x, e.z)) + Vec3f{0, -0.1f * e.y, 0};
      at = c + along * (0.3f * std::max(e.x, e.z));
    }
    const Vec3f f = normalized(at - eye), right = normalized(cross(f, Vec3f{0, 1, 0})),
                up = cross(right, f);
    for (int y0 = 0; y0 < side; y0 += 2) {
      for (int x0 = 0; x0 < side; x0 += 4) {
        for (int k = 0; k < 8; ++k) {
          const float u = static_cast<float>(2 * (x0 + k % 4) + 1) / static_cast<float>(side) - 1;
          const float v = 1 - static_cast<float>(2 * (y0 + k / 4) + 1) / static_cast<float>(side);
          set.rays.push_back({eye, normalized(f + right * (u * 0.7f) + up * (v * 0.7f)), 0, 1e30f});
        }
      }
    }
    return set;
  }

  RaySet bounce(const RaySet& primary, const rays::Caster& caster) {
    RaySet set{"bounce", false, {}, {}};
    for (const Ray& ray : primary.rays) {
      const rays::Hit hit = caster.closest(ray);
      if (!hit.found()) continue;
      Vec3f n = normalized(wide_normal(hit.triangle));
      if (dot(n, ray.direction) > 0) n = -n;
      const Vec3f x = normalized(cross(n, std::abs(n.x) > 0.5f ? Vec3f{0, 1, 0} : Vec3f{1, 0, 0}));
      const Vec3f y = cross(n, x);
      const float u = random_.next_float(), r = std::sqrt(u);
      const float phi = 2 * std::numbers::pi_v<float> * random_.next_float();
      set.rays.push_back({ray.origin + ray.direction * hit.t + n * epsilon_,
                          normalized(x * (r * std::cos(phi)) + y * (r * std::sin(phi)) +
                                     n * std::sqrt(std::max(0.0f, 1 - u))),
                          0, 1e30f});
    }
    return set;
  }

  RaySet pair(std::size_t count) {
    RaySet set{"pair", true, {}, {}};
    while (set.rays.size() < count) {
      const std::uint32_t a = pick(), b = pick();
      if (a == b) continue;
      set.rays.push_back(segment(a, random_.next_float(), random_.next_float(), b,
                                 random_.next_float(), random_.next_float()));
      set.ends.push_back({a, b});
    }
    return set;
  }

  RaySet bundles(std::size_t count) {
    RaySet set{"ff16", true, {}, {}};
    while (set.rays.size() + 16 <= count) {
      const std::uint32_t a = pick(), b = pick();
      if (a == b) continue;
      set.ends.push_back({a, b});
      std::array<int, 16> order;
      for (int i = 0; i < 16; ++i) order[static_cast<std::size_t>(i)] = i;
      for (std::size_t i = 15; i > 0; --i) std::swap(order[i], order[random_.below(i + 1)]);
      const auto cell = [&](int i) { return (static_cast<float>(i) + random_.next_float()) / 4; };
      for (int i = 0; i < 16; ++i) {
        const int j = order[static_cast<std::size_t>(i)];
        const float ua = cell(i / 4), va = cell(i % 4), ub = cell(j / 4), vb = cell(j % 4);
        set.rays.push_back(segment(a, ua, va, b, ub, vb));
      }
    }
    return set;
  }

 private:
  Vec3f corner(std::uint32_t t, std::size_t k) const {
    return scene_.positions[scene_.triangles[t][k]];
  }
  Vec3f wide_normal(std::uint32_t t) const {
    return cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
  }
  std::uint32_t pick() {
    const double value = random_.next_double() * sums_.back();
    const auto found = std::lower_bound(sums_.begin(), sums_.end(), value);
    return static_cast<std::uint32_t>(
        std::min<std::ptrdiff_t>(found - sums_.begin(), std::ssize(sums_) - 1));
  }
  Vec3f point(std::uint32_t t, float a, float b) const {
    const float q = std::sqrt(a);
    return corner(t, 0) * (1 - q) + corner(t, 1) * (q * (1 - b)) + corner(t, 2) * (q * b);
  }
  Ray segment(std::uint32_t a, float ua, float va, std::uint32_t b, float ub, float vb) const {
    const Vec3f p = point(a, ua, va), q = point(b, ub, vb), d = normalized(q - p);
    Vec3f na = normalized(wide_normal(a)), nb = normalized(wide_normal(b));
    if (dot(na, d) < 0) na = -na;
    if (dot(nb, d) > 0) nb = -nb;
    const Vec3f from = p + na * epsilon_, step = q + nb * epsilon_ - from;
    return {from, normalized(step), 0, length(step) * 0.9999f};
  }

  const Scene& scene_;
  Aabb box_;
  float epsilon_;
  std::vector<double> sums_;
  Random random_{12345};
};

}  // namespace

std::vector<RaySet> make_rays(const Scene& scene, const rays::Caster& caster, std::size_t count) {
  RayMaker maker(scene);
  std::vector<RaySet> sets{maker.primary(count)};
  sets.push_back(maker.bounce(sets[0], caster));
  sets.push_back(maker.pair(count));
  sets.push_back(maker.bundles(count));
  return sets;
}

}  // namespace lightbatch::bench
