#pragma once

#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// Draco rounds values, so what was right before compression need not be after: bounds of positions
/// are taken again, directions made unit vectors, weights made to sum to 1, joints without a weight
/// made 0. For meshes that stay as they were read. Call after drop_meshes().
Status mend_decoded(Writer& writer);

}  // namespace lightbatch::scene_out
