#pragma once

#include <cstdint>
#include <vector>

#include "core/batches/plan.h"
#include "core/batches/views.h"

namespace lightbatch::batches {

/// What decides which triangles may share a draw call.
struct Key {
  std::uint32_t material = 0, layout = 0, page = scene::kNone;
  auto operator<=>(const Key&) const = default;
};

/// Dense ids of the keys of triangles, and the share of vertices that each triangle brings.
struct KeyMap {
  std::vector<Key> keys;                   // ascending
  std::vector<std::uint32_t> of_triangle;  // into keys
  std::vector<double> vertices_of_object;  // vertices per triangle of the object
};
KeyMap map_keys(const scene::Scene& scene, const BatchOptions& options);

enum class Fate : std::uint8_t { kMerged, kInstanced, kLeft };

/// What becomes of every object, before any cut: merged into batches, drawn by instance cells, or
/// left in its node with a reason. The growth in bytes is predicted here.
struct Fates {
  std::vector<Fate> of_object;
  std::vector<std::string> reason;  // of kLeft
  std::vector<InstanceCell> cells;
  double geometry_bytes = 0;
  double copied_bytes = 0;
};
Fates decide_fates(const scene::Scene& scene, const Profile& profile, const BatchOptions& options,
                   const ViewDistribution& views, const KeyMap& keys);

/// Part of a node or batch under one key: a draw call to be.
struct Share {
  std::uint32_t key = 0;
  std::uint64_t triangles = 0;
  double vertices = 0;
  Aabb box;
  void add(const Share& other) {
    triangles += other.triangles;
    vertices += other.vertices;
    box.add(other.box);
  }
};
struct ShareCost {
  double draws = 0, triangles = 0;  // expected in a frame
  double cost = 0;                  // us
};
/// Cost of one share under a profile; `visible` is its chance of being seen.
ShareCost cost_of(const Share& share, double visible, const Profile& profile,
                  std::uint32_t max_vertices);

/// Moves parts of objects that the cut took apart back together where the expected frame does not
/// get dearer. batch_of: per triangle, kNone when not merged; changed in place. Returns how many
/// objects stay split.
std::uint32_t keep_objects_whole(const scene::Scene& scene, const KeyMap& keys,
                                 const Profile& profile, std::uint32_t max_vertices,
                                 const ViewDistribution& views,
                                 std::vector<std::uint32_t>& batch_of);

}  // namespace lightbatch::batches
