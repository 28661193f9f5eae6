#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// Writes instance cells: a node with EXT_mesh_gpu_instancing for each, or a plain one where there
/// is a single instance. Meshes of parts are written once each.
class InstanceNodes {
 public:
  explicit InstanceNodes(Writer& writer) : w_(writer) {}
  Result<Json> node_of(const batches::BatchPlan& plan, const batches::InstanceCell& cell);

 private:
  /// What all cells of a part draw.
  struct PartMesh {
    std::uint32_t mesh = 0;  // in the file written
    Json ranges;             // for extras; null where the primitives are the source's
  };
  Result<PartMesh> mesh_of(const batches::InstancePart& part, std::uint32_t max_vertices);
  Json attributes_of(const std::vector<std::uint32_t>& objects, const Vec3d& frame);

  Writer& w_;
  std::map<std::uint32_t, PartMesh> meshes_;  // by part
};

}  // namespace lightbatch::scene_out
