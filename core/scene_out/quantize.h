#pragma once

#include "core/scene_out/mesh_builder.h"
#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// The translation of a batch's node: the box's centre on a grid of powers of two, so that readers
/// with floats hold it exactly, and grids of rounded positions line up.
Vec3d frame_of(const scene::Scene& scene, const Aabb& box);

/// What of new meshes becomes 16-bit integers (KHR_mesh_quantization).
class Quantizer {
 public:
  Quantizer(const Writer& writer, const batches::BatchPlan& plan);

  /// Positions of a batch are whole numbers of this from its frame: a power of two, the same for
  /// all batches, so that what met still meets. 0: they stay floats.
  double step_of(const batches::Batch& batch) const;

  /// Positions of the parts of a mesh that its placements share, in its own frame.
  struct PartGrid {
    Vec3d centre;
    double step = 0;  // 0: they stay as they are
  };
  PartGrid part_grid(const batches::InstancePart& part) const;

 private:
  const Writer& w_;
  double step_ = 0;
};

/// Rounds float positions to (p - origin) / step; directions, and texture coordinates and colours
/// within [0, 1], to normalised shorts: all of them on request, else those that the source has not.
/// Says so in the file and the facts; `scale`: metres of one unit of the mesh's coordinates.
void quantize(Writer& w, MeshData& mesh, const Vec3d& origin, double step, double scale);

}  // namespace lightbatch::scene_out
