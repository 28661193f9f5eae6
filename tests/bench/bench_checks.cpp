#include "tests/bench/bench_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/random.h"

namespace lightbatch::bench {
namespace {

struct OracleHit {
  std::uint32_t triangle = rays::kNoTriangle;
  double t = 0;
  double margin = 1;  // smallest distance from zero of any barycentric coordinate, or t of a hit
};

class Oracle {
 public:
  Oracle(const Scene& scene, const hierarchy::Hierarchy& tree) : scene_(scene), tree_(tree) {}

  OracleHit closest(const rays::Ray& ray) {
    OracleHit best;
    best.t = static_cast<double>(ray.t_max);
    const Vec3d o = to_double(ray.origin), d = to_double(ray.direction);
    stack_.assign(1, {0, entry(tree_.box(0), o, d)});
    while (!stack_.empty()) {
      const Waiting top = stack_.back();
      stack_.pop_back();
      if (!(top.t <= best.t * (1 + 1e-9))) continue;
      if (tree_.is_leaf(top.node)) {
        test(tree_.primitive(tree_.first(top.node)), o, d, static_cast<double>(ray.t_min), best);
        continue;
      }
      Waiting near{tree_.left(top.node), 0}, far{tree_.right(top.node), 0};
      near.t = entry(tree_.box(near.node), o, d);
      far.t = entry(tree_.box(far.node), o, d);
      if (far.t < near.t) std::swap(near, far);
      if (far.t < kMissed) stack_.push_back(far);
      if (near.t < kMissed) stack_.push_back(near);
    }
    return best;
  }

 private:
  static constexpr double kMissed = std::numeric_limits<double>::infinity();
  struct Waiting {
    hierarchy::Hierarchy::NodeId node;
    double t;  // where the ray enters its box
  };

  static double entry(const Aabb& box, const Vec3d& o, const Vec3d& d) {
    double low = -1e-9, high = std::numeric_limits<double>::max();
    for (std::size_t k = 0; k < 3; ++k) {
      const double pad = 1e-9 * (1 + std::abs(o[k]));
      const double a = static_cast<double>(box.lower[k]) - pad - o[k];
      const double b = static_cast<double>(box.upper[k]) + pad - o[k];
      if (d[k] == 0) {
        if (a > 0 || b < 0) return kMissed;
        continue;
      }
      low = std::max(low, std::min(a / d[k], b / d[k]));
      high = std::min(high, std::max(a / d[k], b / d[k]));
    }
    return low <= high ? low : kMissed;
  }

  void test(std::uint32_t i, const Vec3d& o, const Vec3d& d, double t_min, OracleHit& best) const {
    const auto corner = [&](std::size_t k) {
      return to_double(scene_.positions[scene_.triangles[i][k]]);
    };
    const Vec3d a = corner(0), e1 = corner(1) - a, e2 = corner(2) - a, p = cross(d, e2);
    const double det = dot(e1, p);
    if (det == 0) return;
    const Vec3d s = o - a, q = cross(s, e1);
    const double u = dot(s, p) / det, v = dot(d, q) / det, t = dot(e2, q) / det;
    const double least = std::min({u, v, 1 - u - v});
    // On which side of its own origin a surface through it lies no ray can tell.
    if (least >= 0) best.margin = std::min(best.margin, std::abs(t));
    if (!(t > t_min) || !(t <= best.t)) return;
    best.margin = std::min(best.margin, std::abs(least));
    if (least < 0) return;
    best.triangle = i;
    best.t = t;
  }

  const Scene& scene_;
  const hierarchy::Hierarchy& tree_;
  std::vector<Waiting> stack_;
};

}  // namespace

Wrong check_against_oracle(const Scene& scene, const hierarchy::Hierarchy& tree,
                           const rays::Caster& caster, std::size_t count) {
  const Aabb box = scene.bounds();
  const Vec3f e = box.extent();
  return deterministic_reduce(
      count, 16384, Wrong(),
      [&](std::size_t begin, std::size_t end) {
        Oracle oracle(scene, tree);
        Random random(item_seed(77, begin));
        const auto point = [&] {
          return box.lower + Vec3f{e.x * random.next_float(), e.y * random.next_float(),
                                   e.z * random.next_float()};
        };
        Wrong result;
        for (std::size_t i = begin; i < end; ++i) {
          rays::Ray ray{point(), {}};
          ray.direction = point() - ray.origin;
          if (i % 8 == 0) {  // along an axis
            const std::size_t axis = random.below(3);
            ray.direction = {};
            ray.direction[axis] = i % 16 == 0 ? 1.0f : -1.0f;
          }
          const OracleHit expected = oracle.closest(ray);
          const rays::Hit hit = caster.closest(ray);
          ++result.rays;
          if (expected.margin < 1e-12) {
            ++result.doubtful;
            continue;
          }
          const bool found = expected.triangle != rays::kNoTriangle;
          // The same distance to half a unit of float, whichever of two coincident triangles it is.
          const bool same = hit.found() == found &&
                            (!found || std::abs(static_cast<double>(hit.t) - expected.t) <=
                                           1e-7 * std::abs(expected.t) + 1e-12);
          result.wrong += same && caster.occluded(ray) == found ? 0u : 1u;
        }
        return result;
      },
      [](Wrong a, const Wrong& b) {
        return Wrong{a.rays + b.rays, a.doubtful + b.doubtful, a.wrong + b.wrong};
      });
}

std::size_t count_leaks(const Scene& torus, const rays::Caster& caster, std::size_t count) {
  Random random(5);
  std::size_t leaks = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = 2 * std::numbers::pi * random.next_double();
    const Vec3f origin = to_float(Vec3d{std::cos(a), 0.0, std::sin(a)});
    const auto& t = torus.triangles[random.below(torus.triangles.size())];
    const Vec3f p = torus.positions[t[0]], q = torus.positions[t[1]];
    const Vec3f target = i % 2 == 0 ? p : (p + q) * 0.5f;
    leaks += caster.closest({origin, target - origin}).found() ? 0u : 1u;
  }
  return leaks;
}

}  // namespace lightbatch::bench
