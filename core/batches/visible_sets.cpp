// Potentially visible sets of cells: Airey, Rohlf, Brooks: Towards image realism with interactive
// update rates in complex virtual building environments, 1990, whose sets were sampled, too. Half
// of the rays go in any direction, half towards triangles of what has not been seen yet, so that
// small things far away are found (guided visibility sampling: Wonka et al. 2006, in its simplest
// form).
#include "core/batches/visible_sets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/batches/fates.h"
#include "core/math/sampling.h"
#include "core/rays/caster.h"

namespace lightbatch::batches {
namespace {

constexpr std::uint32_t kStandingEyes = 32768;
constexpr std::uint32_t kCheckRays = 512;  // of a cell
constexpr float kLevel = 1e-5f;            // distances that differ so little, as a share, are equal
/// Streams of random numbers.
constexpr std::uint64_t kFinding = 1, kChecking = 2;

bool hides(const scene::Material& m) {
  return m.alpha_mode == scene::AlphaMode::kOpaque && !(m.transmission > 0) &&
         !(m.diffuse_transmission > 0);
}

/// Objects that show what is behind them now and then: those of the options, and what keeps its
/// node because something may move, hide or exchange it.
std::vector<bool> opening_objects(const scene::Scene& scene, const BatchPlan& plan,
                                  const VisibleSetOptions& options) {
  LB_CHECK(options.opens.empty() || options.opens.size() == scene.objects.size(),
           "one entry for each object");
  std::vector<bool> opens = options.opens;
  opens.resize(scene.objects.size(), false);
  for (const LeftAlone& left : plan.left_alone)
    if (left.reason != kInstancedReason && left.reason != kBlendedReason) opens[left.object] = true;
  return opens;
}

/// What of the plan each triangle belongs to.
class Members {
 public:
  Members(const scene::Scene& scene, const BatchPlan& plan)
      : scene_(scene), cells_of_object_(scene.objects.size()) {
    item_of_triangle_.assign(scene.triangles.size(), scene::kNone);
    const auto batches = static_cast<std::uint32_t>(plan.batches.size());
    count_ = batches + static_cast<std::uint32_t>(plan.cells.size());
    triangles_.resize(count_);
    for (std::uint32_t b = 0; b < batches; ++b)
      for (const Group& group : plan.batches[b].groups)
        for (const Piece& piece : group.pieces)
          for (const Range& range : piece.ranges) {
            triangles_[b].push_back(range);
            for (std::uint32_t k = 0; k < range.count; ++k) item_of_triangle_[range.first + k] = b;
          }
    // Parts of a mesh are not told apart: an instance that is seen shows all cells that draw it.
    for (std::uint32_t c = 0; c < plan.cells.size(); ++c)
      for (const std::uint32_t first : plan.cells[c].objects) {
        const scene::Object& source = scene.objects[first];
        for (std::uint32_t o = first; o < scene.objects.size(); ++o) {
          const scene::Object& object = scene.objects[o];
          if (object.node != source.node || object.instance != source.instance) break;
          cells_of_object_[o].push_back(batches + c);
          triangles_[batches + c].push_back({object.first_triangle, object.triangle_count});
        }
      }
  }
  std::uint32_t count() const { return count_; }
  template <typename Visit>
  void for_each(std::uint32_t triangle, const Visit& visit) const {
    if (item_of_triangle_[triangle] != scene::kNone) visit(item_of_triangle_[triangle]);
    for (const std::uint32_t c : cells_of_object_[scene_.triangles[triangle].object]) visit(c);
  }
  /// A triangle of an item.
  std::uint32_t pick(std::uint32_t item, Random& random) const {
    const Range& range = triangles_[item][random.below(triangles_[item].size())];
    return range.first + static_cast<std::uint32_t>(random.below(range.count));
  }

 private:
  const scene::Scene& scene_;
  std::uint32_t count_ = 0;
  std::vector<std::uint32_t> item_of_triangle_;
  std::vector<std::vector<std::uint32_t>> cells_of_object_;
  std::vector<std::vector<Range>> triangles_;  // by item
};

/// Lets rays pass what hides nothing, or everything, and remembers what of it shows.
class PassThrough final : public rays::HitFilter {
 public:
  PassThrough(const scene::Scene& scene, const std::vector<bool>& opens, bool all)
      : scene_(scene), opens_(opens), all_(all) {}
  bool stops(const rays::Hit& hit) override {
    const std::uint32_t object = scene_.triangles[hit.triangle].object;
    const scene::Material& m = scene_.materials[scene_.objects[object].material];
    if (!opens_[object] && hit.back && !m.double_sided) return false;
    if (!all_ && !opens_[object] && hides(m)) return true;
    passed.push_back(hit);
    return false;
  }
  std::vector<rays::Hit> passed;

 private:
  const scene::Scene& scene_;
  const std::vector<bool>& opens_;
  bool all_;
};

class Finder {
 public:
  Finder(const scene::Scene& scene, const hierarchy::Hierarchy& tree, const BatchPlan& plan,
         std::vector<bool> opens)
      : scene_(scene),
        opens_(std::move(opens)),
        members_(scene, plan),
        caster_(make_caster(scene, tree)) {}

  /// Fills the set of a cell. Returns the rays that it took.
  std::uint64_t find(ViewCell& cell, const VisibleSetOptions& options, std::uint64_t index) const {
    Random random(item_seed(options.seed, index, kFinding));
    std::vector<bool> seen(members_.count(), false);
    std::uint32_t rays = 0, barren = 0, unseen = members_.count();
    while (unseen > 0 && rays < options.most_rays && barren < options.barren_rays) {
      const Vec3f eye = point_in(cell.box, random);
      Vec3f to = any_direction(random);
      if (rays % 2 == 1) {
        auto item = static_cast<std::uint32_t>(random.below(members_.count()));
        while (seen[item]) item = item + 1 == members_.count() ? 0 : item + 1;
        to = point_on(members_.pick(item, random), random) - eye;
      }
      ++rays;
      ++barren;
      for_each_met(eye, to, [&](std::uint32_t item) {
        if (seen[item]) return;
        seen[item] = true;
        --unseen;
        barren = 0;
      });
    }
    for (std::uint32_t i = 0; i < seen.size(); ++i)
      if (seen[i]) cell.seen.push_back(i);
    return rays;
  }

  /// Of kCheckRays fresh rays, those that meet what the set lacks.
  std::uint64_t missed(const ViewCell& cell, std::uint64_t seed, std::uint64_t index) const {
    Random random(item_seed(seed, index, kChecking));
    std::uint64_t missed = 0;
    for (std::uint32_t i = 0; i < kCheckRays; ++i) {
      const Vec3f eye = point_in(cell.box, random);
      bool all = true;
      for_each_met(eye, any_direction(random), [&](std::uint32_t item) {
        all = all && std::binary_search(cell.seen.begin(), cell.seen.end(), item);
      });
      missed += all ? 0 : 1;
    }
    return missed;
  }

  std::uint32_t item_count() const { return members_.count(); }

 private:
  static rays::Caster make_caster(const scene::Scene& scene, const hierarchy::Hierarchy& tree) {
    std::vector<std::array<std::uint32_t, 3>> triangles(scene.triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) triangles[t] = scene.triangles[t].vertex;
    const std::vector<rays::Surface> surfaces(triangles.size(), rays::Surface::kFiltered);
    return rays::Caster(tree, scene.positions, triangles, surfaces);
  }
  static Vec3f point_in(const Aabb& box, Random& random) {
    const Vec3f e = box.extent();
    const float x = random.next_float(), y = random.next_float(), z = random.next_float();
    return box.lower + Vec3f{x * e.x, y * e.y, z * e.z};
  }
  static Vec3f any_direction(Random& random) {
    const float x = random.next_float(), y = random.next_float();
    return uniform_sphere({x, y});
  }
  Vec3f point_on(std::uint32_t triangle, Random& random) const {
    const auto c = scene_.corners(triangle);
    float u = random.next_float(), v = random.next_float();
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    return c[0] + (c[1] - c[0]) * u + (c[2] - c[0]) * v;
  }
  template <typename Visit>
  void for_each_met(const Vec3f& eye, const Vec3f& direction, const Visit& visit) const {
    PassThrough passing(scene_, opens_, false);
    const rays::Hit hit = caster_.closest({eye, direction}, rays::kNoTriangle, &passing);
    for (const rays::Hit& passed : passing.passed)
      if (!hit.found() || passed.t <= hit.t) members_.for_each(passed.triangle, visit);
    if (!hit.found()) return;
    // What lies in one plane, as posters on walls, shows as viewers draw it.
    PassThrough level(scene_, opens_, true);
    caster_.closest({eye, direction, hit.t * (1 - kLevel), hit.t * (1 + kLevel)}, rays::kNoTriangle,
                    &level);
    for (const rays::Hit& other : level.passed) members_.for_each(other.triangle, visit);
    members_.for_each(hit.triangle, visit);
  }

  const scene::Scene& scene_;
  std::vector<bool> opens_;  // by object
  Members members_;
  rays::Caster caster_;
};

/// Boxes of eyes: standing points by cells of a grid.
std::vector<ViewCell> walkable_cells(const Viewpoints& viewpoints, std::uint32_t most) {
  const std::vector<Vec3d> eyes = viewpoints.standing_eyes(kStandingEyes, 0);
  const Vec3d lower = to_double(viewpoints.box().lower);
  double edge = 1.25 * viewpoints.eye_height();
  constexpr double kCoarser = 1.25;
  if (!(edge > 0)) return {};
  for (;; edge *= kCoarser) {
    std::map<std::array<std::int64_t, 3>, Aabb> cells;
    for (const Vec3d& eye : eyes) {
      std::array<std::int64_t, 3> key;
      for (std::size_t axis = 0; axis < 3; ++axis)
        key[axis] = static_cast<std::int64_t>(std::floor((eye[axis] - lower[axis]) / edge));
      const double x = lower.x + static_cast<double>(key[0]) * edge;
      const double z = lower.z + static_cast<double>(key[2]) * edge;
      Aabb& box = cells[key];
      box.add(to_float(Vec3d{x, eye.y, z}));
      box.add(to_float(Vec3d{x + edge, eye.y, z + edge}));
    }
    if (cells.size() > most) continue;
    std::vector<ViewCell> result;
    for (const auto& [key, box] : cells) {
      // People differ: eyes down to half the height above the floor, and a tenth above it.
      const auto height = static_cast<float>(viewpoints.eye_height());
      Aabb eyes_box = box;
      eyes_box.lower.y -= 0.5f * height;
      eyes_box.upper.y += 0.1f * height;
      result.push_back({eyes_box, {}});
    }
    return result;
  }
}

}  // namespace

Result<VisibleSets> find_visible_sets(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                                      const Viewpoints& viewpoints, const BatchPlan& plan,
                                      const VisibleSetOptions& options, const Progress& progress) {
  VisibleSets sets;
  sets.cells = walkable_cells(viewpoints, options.most_cells);
  const Finder finder(scene, tree, plan, opening_objects(scene, plan, options));
  if (sets.cells.empty() || finder.item_count() == 0) return sets;
  std::vector<std::uint64_t> rays(sets.cells.size(), 0), missed(sets.cells.size(), 0);
  constexpr std::size_t kBlock = 16;  // between two reports
  for (std::size_t first = 0; first < rays.size(); first += kBlock) {
    progress.report("pvs", static_cast<double>(first) / static_cast<double>(rays.size()));
    if (progress.cancelled()) return cancelled();
    parallel_for(std::min(kBlock, rays.size() - first), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = first + begin; i < first + end; ++i) {
        rays[i] = finder.find(sets.cells[i], options, i);
        missed[i] = finder.missed(sets.cells[i], options.seed, i);
      }
    });
  }
  double seen = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    sets.rays += rays[i];
    sets.checked += kCheckRays;
    sets.missed += missed[i];
    seen += static_cast<double>(sets.cells[i].seen.size());
  }
  sets.mean_share =
      seen / (static_cast<double>(rays.size()) * static_cast<double>(finder.item_count()));
  return sets;
}

}  // namespace lightbatch::batches
