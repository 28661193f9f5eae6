#pragma once

#include <cstdint>
#include <span>

#include "core/atlas/project.h"

namespace lightbatch::atlas {

/// Whether the flattened chart may lie on itself. Every triangle faces the axis, so the number of
/// layers over a point is the winding number of the border: it is summed along lines half a texel
/// apart. Overlaps narrower than a quarter texel, or between two lines, do not count.
/// Cost: border length in texels, not area. scale: texels per metre along u and v.
bool border_overlaps(const Mesh& mesh, const FlatChart& chart,
                     std::span<const std::uint32_t> chart_of, const Vec2d& scale);

}  // namespace lightbatch::atlas
