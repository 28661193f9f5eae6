#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/scene_out/quantize.h"
#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// Writes instance cells: a node with EXT_mesh_gpu_instancing for each, or a plain one where there
/// is a single instance. Meshes of parts are written once each.
class InstanceNodes {
 public:
  InstanceNodes(Writer& writer, const Quantizer& quantizer) : w_(writer), quantizer_(quantizer) {}
  Result<Json> node_of(const batches::BatchPlan& plan, const batches::InstanceCell& cell);

 private:
  /// What all cells of a part draw.
  struct PartMesh {
    std::uint32_t mesh = 0;  // in the file written
    Json ranges;             // for extras; null where the primitives are the source's
    Quantizer::PartGrid grid;
  };
  Result<PartMesh> mesh_of(const batches::BatchPlan& plan, std::uint32_t index);
  Json attributes_of(const std::vector<std::uint32_t>& objects, const Quantizer::PartGrid& grid,
                     const Vec3d& frame);

  /// Where an object puts the coordinates of its part's mesh.
  Affine placement(std::uint32_t object, const Quantizer::PartGrid& grid) const;

  Writer& w_;
  const Quantizer& quantizer_;
  std::map<std::uint32_t, PartMesh> meshes_;  // by part
};

}  // namespace lightbatch::scene_out
