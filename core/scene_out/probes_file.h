#pragma once

#include <string>

#include "core/probes/bake.h"

namespace lightbatch::scene_out {

/// Text of probes.json; its format is told in this room's README. Deterministic.
std::string probes_file(const probes::LightProbes& probes);

}  // namespace lightbatch::scene_out
