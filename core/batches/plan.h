#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/status.h"
#include "core/batches/profile.h"
#include "core/hierarchy/hierarchy.h"
#include "core/math/aabb.h"
#include "core/scene/scene.h"

namespace lightbatch::batches {

/// What the file says of an object beyond its triangles.
struct ObjectTraits {
  std::uint32_t layout = 0;         // objects of equal layout may share a primitive
  std::uint32_t vertex_bytes = 32;  // of a copied vertex
  std::string keep;                 // why it must stay in its own node; empty: it may be merged
};

struct BatchOptions {
  std::uint32_t max_batches = 0;   // 0: cost alone decides
  std::uint32_t max_vertices = 0;  // of one primitive; 0: the profile's
  /// Bytes of vertices and indices may grow by this factor through copies of shared meshes; what
  /// does not fit stays instanced.
  double max_growth = 1.25;
  double free_growth_bytes = 0;  // allowed on top
  /// Instances may be drawn by EXT_mesh_gpu_instancing, one group for each cell of space. Not when
  /// triangles have pages: light differs from instance to instance.
  bool gpu_instancing = true;
  std::vector<ObjectTraits> traits;             // one per object, or empty
  std::vector<std::uint32_t> page_of_triangle;  // lightmap page or kNone; empty: no lightmaps
};

struct Range {
  std::uint32_t first = 0;  // into Scene::triangles
  std::uint32_t count = 0;
};

/// The part of one object that a group draws.
struct Piece {
  std::uint32_t object = 0;
  std::vector<Range> ranges;  // ascending, disjoint
};

/// One draw call: one primitive in the file (more when it exceeds max_vertices).
struct Group {
  std::uint32_t material = 0;         // into Scene::materials
  std::uint32_t layout = 0;           // of all its objects
  std::uint32_t page = scene::kNone;  // lightmap page
  Aabb box;                           // tight
  std::uint64_t triangles = 0;
  double vertices = 0;        // estimate; vertices on cuts are shared out
  std::vector<Piece> pieces;  // by object, ascending
};

/// Triangles that are culled and kept together.
struct Batch {
  Aabb box;
  hierarchy::Hierarchy::NodeId node = 0;  // of the cut
  std::vector<Group> groups;
};

/// Inner nodes of the hierarchy above the batches; node 0 is the root, children come after their
/// parents. Nodes over a single batch are left out.
struct TreeNode {
  std::uint32_t left = scene::kNone, right = scene::kNone;  // into BatchPlan::tree
  std::uint32_t batch = scene::kNone;                       // leaf
};

/// Instances of one mesh drawn by one EXT_mesh_gpu_instancing node.
struct InstanceCell {
  std::uint32_t mesh = 0;
  std::vector<std::uint32_t> primitives;  // of the mesh, ascending
  std::vector<std::uint32_t> objects;     // one of each instance, in instance order
  Aabb box;
  std::uint64_t triangles = 0;  // of all instances
};

struct LeftAlone {
  std::uint32_t object = 0;
  std::string reason;
};

struct CurvePoint {
  double draw_cost = 0;  // triangles that one draw is worth
  std::uint32_t batches = 0;
  double draws = 0;      // expected in a frame
  double triangles = 0;  // expected in a frame
};

struct BatchPlan {
  std::vector<Batch> batches;
  std::vector<TreeNode> tree;  // empty when there are no batches
  std::vector<InstanceCell> cells;
  std::vector<LeftAlone> left_alone;  // by object; each object is here, in batches, or in a cell
  std::uint32_t max_vertices = 0;
  std::uint64_t draws_before = 0;
  std::uint64_t draws_after = 0;
  double geometry_bytes = 0;                          // of the meshes, each once
  double copied_bytes = 0;                            // predicted for copies of shared meshes
  double expected_draws = 0, expected_triangles = 0;  // in a frame, by the model; merged objects
  std::uint32_t split_objects = 0;                    // drawn by more than one batch
  std::vector<CurvePoint> curve;                      // few draws first
};

/// Chooses batches: the cut through the hierarchy (over the scene's triangles) of least expected
/// cost of a frame, then whole objects where a split does not pay. Deterministic; O(n log n).
/// BAD_OPTION, CANCELLED.
Result<BatchPlan> plan(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                       const Profile& profile, const BatchOptions& options,
                       const Progress& progress = {});

}  // namespace lightbatch::batches
