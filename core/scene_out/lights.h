#pragma once

#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// Takes the scene's lights, which are in the lightmaps, out of their nodes. Returns what was
/// taken, for extras: the light objects and the nodes they hung on; null when there were none.
Json remove_lights(Writer& writer);

}  // namespace lightbatch::scene_out
