#pragma once

#include <cstdint>
#include <vector>

#include "core/lightmap/bake.h"

namespace lightbatch::lightmap {

/// Flags of texels with something closer above them than their own edge: under furniture, behind
/// frames. Texels that are not selected are 0.
std::vector<std::uint8_t> find_covered(const BakeInput& input);

}  // namespace lightbatch::lightmap
