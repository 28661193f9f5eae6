#pragma once

#include "core/batches/plan.h"
#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// Writes every batch as a mesh in a world-aligned frame under the inner nodes of the hierarchy,
/// and instance cells as EXT_mesh_gpu_instancing nodes, below one new root in the default scene.
Status add_batches(Writer& writer, const batches::BatchPlan& plan, std::uint32_t scene_index);

}  // namespace lightbatch::scene_out
