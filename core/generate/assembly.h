#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/status.h"
#include "core/generate/furniture.h"

namespace lightbatch::generate {

/// Collects meshes, nodes and lights, and writes them as one .glb. Surfaces are stored once however
/// many meshes (material variants) and nodes use them.
class Assembly {
 public:
  using ModelId = std::size_t;
  using NodeId = std::size_t;

  /// Stores the surfaces of a model.
  ModelId add_model(const Model& model);
  /// A mesh of that model, materials shifted by `variant` where they come in several; the same
  /// (model, variant) gives the same mesh.
  std::size_t mesh(ModelId model, int variant);

  /// A node below `parent` (kRoot: of the scene); yaw in radians about +Y.
  NodeId add_group(NodeId parent, const std::string& name, const Vec3d& place, double yaw);
  void add_mesh_node(NodeId parent, const std::string& name, std::size_t mesh, const Vec3d& place,
                     double yaw);
  /// A pendant: point light of 90 cd, below `parent`.
  void add_point_light(NodeId parent, const std::string& name, const Vec3d& place);
  static constexpr NodeId kRoot = static_cast<NodeId>(-1);

  /// Triangles of all mesh nodes so far.
  std::uint64_t drawn_triangles() const { return drawn_triangles_; }

  Result<Bytes> finish();

 private:
  struct Stored {
    std::string name;
    std::uint64_t triangles = 0;
    std::vector<nlohmann::json> primitives;
    std::vector<std::size_t> variants;  // mesh of each variant; kRoot: not made yet
  };

  std::size_t add_accessor(std::span<const std::byte> bytes, int target, nlohmann::json accessor);
  NodeId add_node(NodeId parent, nlohmann::json node, const Vec3d& place, double yaw);

  std::vector<Stored> models_;
  std::vector<std::uint64_t> mesh_triangles_;
  std::vector<std::vector<std::size_t>> children_;
  std::vector<std::size_t> roots_;
  nlohmann::json accessors_ = nlohmann::json::array();
  nlohmann::json views_ = nlohmann::json::array();
  nlohmann::json meshes_ = nlohmann::json::array();
  nlohmann::json nodes_ = nlohmann::json::array();
  nlohmann::json lights_ = nlohmann::json::array();
  Bytes binary_;
  std::uint64_t drawn_triangles_ = 0;
};

}  // namespace lightbatch::generate
