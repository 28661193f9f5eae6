#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/hierarchy/hierarchy.h"
#include "core/image/image.h"

namespace lightbatch::hierarchy {

/// What the tree looks like at a level (the root is level 0): the boxes of the nodes at that depth,
/// and of the leaves above it, depth-first.
std::vector<Hierarchy::NodeId> level_nodes(const Hierarchy& tree, int level);
std::vector<Aabb> level_boxes(const Hierarchy& tree, int level);

/// Isometric drawings of boxes, seen from +x +y +z with +y up (Figure 1 of Mueller, Schaefer,
/// Fellner 1999). Both scale the boxes to fit; sizes are clamped to [16, 8192] pixels.

/// Shaded boxes with dark edges, nearest in front, on white; 2 x 2 samples a pixel.
image::Image8 level_picture(std::span<const Aabb> boxes, int width, int height);

/// Translucent faces, far ones first. Of more than `most` boxes the largest are drawn, and the
/// drawing says how many were left out.
std::string level_svg(std::span<const Aabb> boxes, int width, int height, std::size_t most = 20000);

}  // namespace lightbatch::hierarchy
