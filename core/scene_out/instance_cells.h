#pragma once

#include <map>

#include "core/batches/plan.h"
#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// A node that draws the instances of a cell (EXT_mesh_gpu_instancing); its mesh holds the cell's
/// primitives only, which are triangles: viewers drop instances of meshes that hold lines.
Result<Json> instance_node(Writer& writer, const batches::InstanceCell& cell);

}  // namespace lightbatch::scene_out
