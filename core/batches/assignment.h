#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <vector>

#include "core/batches/plan.h"
#include "core/batches/views.h"

namespace lightbatch::batches {

/// What decides which triangles may share a draw call.
struct Key {
  std::uint32_t material = 0, layout = 0, page = scene::kNone;
  std::uint32_t object = scene::kNone;  // of a blended one: viewers sort it among the others
  auto operator<=>(const Key&) const = default;
};

inline bool is_blended(const scene::Scene& scene, std::uint32_t object) {
  const scene::Object& o = scene.objects[object];
  return scene.materials[o.material].alpha_mode == scene::AlphaMode::kBlend;
}

/// Dense ids of the keys of triangles, and the share of vertices that each triangle brings.
struct KeyMap {
  std::vector<Key> keys;                   // ascending
  std::vector<std::uint32_t> of_triangle;  // into keys
  std::vector<double> vertices_of_object;  // vertices per triangle of the object
};
KeyMap map_keys(const scene::Scene& scene, const BatchOptions& options);

/// What one draw, vertex and triangle cost (us). The price of a draw is the profile's, or more
/// where draws are limited.
struct Prices {
  double draw = 0, vertex = 0, triangle = 0;
};
inline Prices prices_of(const Profile& profile) {
  return {profile.draw + profile.state, profile.vertex, profile.triangle};
}

/// What a frame is expected to hold.
struct Frame {
  double draws = 0, vertices = 0, triangles = 0;
  double inside_draws = 0;  // draws of views from inside
  Frame& operator+=(const Frame& other) {
    draws += other.draws;
    vertices += other.vertices;
    triangles += other.triangles;
    inside_draws += other.inside_draws;
    return *this;
  }
  double cost(const Prices& p) const {
    return draws * p.draw + vertices * p.vertex + triangles * p.triangle;
  }
};

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
/// What a share adds to a frame, given its chance of being seen.
Frame frame_of(const Share& share, const Chance& chance, std::uint32_t max_vertices);

/// Moves parts of objects that the cut took apart back together where the expected frame does not
/// get dearer. batch_of: per triangle, kNone when not merged; changed in place. Returns how many
/// objects stay split.
std::uint32_t keep_objects_whole(const scene::Scene& scene, const KeyMap& keys,
                                 const Prices& prices, std::uint32_t max_vertices,
                                 const ViewDistribution& views,
                                 std::vector<std::uint32_t>& batch_of);

}  // namespace lightbatch::batches
