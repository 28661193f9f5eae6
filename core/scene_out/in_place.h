#pragma once

#include "core/batches/plan.h"
#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// Original nodes after batching. A node whose primitives all went into batches loses its mesh;
/// what was left alone stays as it was, or, when it has a lightmap, with TEXCOORD_1 of its own.
/// Objects of one mesh share all other accessors then. GPU instances with lightmaps become child
/// nodes: each has its own light.
Status rewrite_nodes(Writer& writer, const batches::BatchPlan* plan);

}  // namespace lightbatch::scene_out
