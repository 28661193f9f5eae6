#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "core/hierarchy/hierarchy.h"
#include "core/math/vec.h"

namespace lightbatch::rays {

constexpr std::uint32_t kNoTriangle = 0xffffffffu;

/// Points origin + t * direction with t in (t_min, t_max). The direction need not be unit.
struct Ray {
  Vec3f origin;
  Vec3f direction;
  float t_min = 0;
  float t_max = std::numeric_limits<float>::infinity();
};

/// A ray to be asked for occlusion, and the triangles that do not count.
struct Segment {
  Ray ray;
  std::uint32_t exclude_a = kNoTriangle;
  std::uint32_t exclude_b = kNoTriangle;
};

/// The point is (1 - u - v) a + u b + v c of the triangle (a, b, c).
struct Hit {
  std::uint32_t triangle = kNoTriangle;
  float t = 0;
  float u = 0;
  float v = 0;
  bool back = false;  // the ray came from behind (clockwise side)
  bool found() const { return triangle != kNoTriangle; }
};

/// How a triangle meets rays.
enum class Surface : std::uint8_t {
  kOpaque,    // stops every ray
  kFiltered,  // asks the filter
  kClear,     // stops none: left out of the casting tree
};

/// Asked for hits on kFiltered triangles only; false lets the ray pass. May be asked in any order
/// and for hits beyond the final one, but at most once per triangle and ray.
class HitFilter {
 public:
  virtual ~HitFilter() = default;
  virtual bool stops(const Hit& hit) = 0;
};

/// Which nodes of the casting tree are regular grids (Mueller and Fellner 1999), over the leaves of
/// the same subtree. Hits are the same either way, bit for bit.
enum class Grids : std::uint8_t {
  kNever,
  kWhereCheaper,  // by the expected cost of a ray
  kEverywhere,    // as high in the tree as it goes
};

/// A node of the hierarchy that is a grid in the casting tree.
struct GridNode {
  hierarchy::Hierarchy::NodeId node = 0;
  std::uint32_t triangles = 0;
  std::uint32_t cells = 0;
  float cost_share = 0;  // expected cost of a ray that meets the node, over that without a grid
};

/// Casts rays against the triangles of a scene over its hierarchy. Watertight at shared edges
/// (Woop, Benthin, Wald 2013), conservative boxes (Ize 2013). A ray never hits the triangles it is
/// told to exclude, so that points on a surface need no global offset. Immutable; thread-safe.
class Caster {
 public:
  /// triangles[i] indexes positions; surfaces is empty (all opaque) or one per triangle. The
  /// hierarchy must have been built over the triangles' boxes, in the same order. The spans are
  /// not kept.
  Caster(const hierarchy::Hierarchy& tree, std::span<const Vec3f> positions,
         std::span<const std::array<std::uint32_t, 3>> triangles, std::span<const Surface> surfaces,
         Grids grids = Grids::kWhereCheaper);
  ~Caster();
  Caster(Caster&&) noexcept;
  Caster& operator=(Caster&&) noexcept;

  /// Nearest hit; ties in t go to the lower triangle index. Without a filter, kFiltered stops.
  Hit closest(const Ray& ray, std::uint32_t exclude = kNoTriangle,
              HitFilter* filter = nullptr) const;
  /// Whether anything stops the ray. Excluded: a, b (for instance source and receiver).
  bool occluded(const Ray& ray, std::uint32_t exclude_a = kNoTriangle,
                std::uint32_t exclude_b = kNoTriangle, HitFilter* filter = nullptr) const;

  static constexpr std::size_t kBundle = 16;
  /// Bundles of 16 segments one after another (the last may be smaller), as links of radiosity ask
  /// for: bit j of stopped[i] is what occluded() says of segment 16 i + j. Several times as fast
  /// when those of a bundle run close together, as between two clusters; faster the more at once.
  void occluded(std::span<const Segment> segments, std::span<std::uint32_t> stopped) const;

  std::span<const GridNode> grids() const;
  /// The node that came nearest to being a grid by its cost and is none; no triangles: no node was
  /// large enough. Its cost is a lower bound.
  const GridNode& refused_grid() const;
  /// Bytes held by the casting tree, triangles included.
  std::size_t memory_bytes() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace lightbatch::rays
