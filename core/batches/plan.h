#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/status.h"
#include "core/batches/viewpoints.h"
#include "core/hierarchy/hierarchy.h"
#include "core/math/aabb.h"
#include "core/scene/scene.h"

namespace lightbatch::batches {

/// What the file says of an object beyond its triangles.
struct ObjectTraits {
  std::uint32_t layout = 0;         // objects of equal layout may share a primitive
  std::uint32_t vertex_bytes = 32;  // of a copied vertex
  std::string keep;                 // why it must stay in its own node; empty: it may be merged
  /// Stands for the material: objects of equal classes differ in the base colour factor alone,
  /// which their vertices can hold instead. kNone: its own material.
  std::uint32_t material_class = scene::kNone;
};

struct BatchOptions {
  std::uint32_t max_batches = 0;  // 0: cost alone decides
  /// Draws of a mean view from inside are brought below this share of the input's, dear as that may
  /// be in triangles. 1, or a file of at most free_draws: cost alone decides.
  double draws_share = 0.1;
  std::uint32_t free_draws = 500;
  std::uint32_t max_vertices = 0;  // of one primitive; 0: the profile's
  /// Bytes of vertices and indices may grow by this factor through copies of shared meshes, made
  /// where they save draws cheaply; what is not copied stays instanced. By more than a quarter only
  /// with lightmaps or where draws_share needs it.
  double max_growth = 16;
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
  std::uint32_t material = 0;         // into Scene::materials; of the first object
  bool coloured = false;              // objects differ in base colour: vertices hold it
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
  std::vector<Group> groups;
};

/// Inner nodes of the hierarchy above the batches; node 0 is the root, children come after their
/// parents. Nodes over a single batch are left out.
struct TreeNode {
  std::vector<std::uint32_t> children;  // into BatchPlan::tree
  std::uint32_t batch = scene::kNone;   // of a leaf
};

/// A piece of a mesh that its placements go on sharing; one primitive.
struct InstancePart {
  std::uint32_t mesh = 0;
  std::uint32_t material = 0;  // of the first piece
  std::uint32_t layout = 0;
  bool coloured = false;      // as of Group
  bool whole = false;         // one primitive of the mesh, all of it
  std::vector<Piece> pieces;  // of one placement; stands for all
};

/// Instances of one part drawn by one call.
struct InstanceCell {
  std::uint32_t part = 0;              // into BatchPlan::parts
  std::vector<std::uint32_t> objects;  // one of each placement: its frame
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
  std::vector<InstancePart> parts;
  std::vector<InstanceCell> cells;
  std::vector<LeftAlone> left_alone;  // by object; each object is here, in batches, or in a cell
  std::uint32_t max_vertices = 0;
  std::uint64_t draws_before = 0;
  std::uint64_t draws_after = 0;
  double geometry_bytes = 0;                          // of the meshes, each once
  double copied_bytes = 0;                            // predicted for copies of shared meshes
  double expected_draws = 0, expected_triangles = 0;  // in a frame, by the model
  double draw_price = 0;  // us of a draw that the cuts were made with; more than the profile's
                          // where draws_share binds
  std::uint32_t split_objects = 0;  // drawn by more than one batch
  std::vector<CurvePoint> curve;    // few draws first
};

struct ViewSet;

/// Chooses batches for a profile and the views that it has of the scene: the cut through the
/// hierarchy (over the scene's triangles) of least expected cost of a frame, then whole objects
/// where a split does not pay. measured: of make_view_set, what draws_share is held to; null: made
/// here where it is asked for. Deterministic; O(n log n). BAD_OPTION, CANCELLED.
Result<BatchPlan> plan(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                       const Viewpoints& viewpoints, const BatchOptions& options,
                       const Progress& progress = {}, const ViewSet* measured = nullptr);

}  // namespace lightbatch::batches
