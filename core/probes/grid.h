#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/hierarchy/hierarchy.h"
#include "core/math/vec.h"
#include "core/scene/scene.h"

namespace lightbatch::probes {

/// A cube with a probe at each corner.
struct Cell {
  std::array<std::uint32_t, 3> at{};  // lower corner, in steps of the volume
  std::uint32_t size = 1;             // edge, in steps; a power of two
  /// Into ProbeGrid::positions. Bits of the place: upper side in x, y, z.
  std::array<std::uint32_t, 8> probe{};
};

/// Where some meshes move: cubes that do not overlap, smaller near static geometry. Empty places of
/// its box, where no mesh comes, have none.
struct Volume {
  Vec3d origin;                           // world
  double step = 1;                        // metres; edge of the smallest cube possible
  std::array<std::uint32_t, 3> extent{};  // in steps
  std::uint32_t largest = 1;  // size of the largest cubes; cubes lie at multiples of their size
  std::vector<Cell> cells;    // by z, y, x of their lower corner
  std::vector<std::uint32_t> nodes;  // of the meshes that move in it, ascending
};

struct ProbeGrid {
  std::vector<Volume> volumes;
  std::vector<Vec3d> positions;  // world
};

struct GridOptions {
  std::uint32_t most_probes = 4096;
};

/// Places probes where the moving meshes of a scene can be. A cube is cut in eight while a box of
/// the scene's hierarchy lies within half its edge, down to a quarter of the size of what moves.
/// Meshes whose ways overlap share a volume: those volumes are a cut through a hierarchy over their
/// boxes. `tree` is over the scene's triangles. No probes when nothing moves.
ProbeGrid place_probes(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                       const GridOptions& options = {});

}  // namespace lightbatch::probes
