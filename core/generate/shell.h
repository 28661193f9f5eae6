#pragma once

#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/generate/furniture.h"
#include "core/math/aabb.h"

namespace lightbatch::generate {

/// A room or a corridor. Rooms have their own frame: origin in the middle of the floor, +z towards
/// the corridor, turned by `yaw`; the door is near the -x end of the +z wall, the window in the
/// middle of the -z wall.
struct Space {
  std::string name;  // "2.07", "corridor 2"
  bool corridor = false;
  int floor = 0;
  Aabbd box;  // of the air, world
  double yaw = 0;

  Vec3d floor_centre() const {
    const Vec3d centre = box.centre();
    return {centre.x, box.lower.y, centre.z};
  }
  double width() const { return box.extent().x; }
};

inline constexpr double kRoomDepth = 5.0;
inline constexpr double kRoomHeight = 2.8;
inline constexpr double kNarrowestRoom = 4.2;
/// From the -x end of the room's corridor wall to the far side of its door.
inline constexpr double kDoorEnd = 1.45;

/// Walls, slabs, openings: the surfaces between solid and air of a grid of cells, so that they meet
/// in shared vertices, hide nothing, and coincide nowhere.
struct Building {
  std::vector<Space> spaces;
  std::vector<Model> shells;  // one a space, in world coordinates, then the outside
};

/// At least `rooms` rooms; the last floor is always full.
Building make_building(int rooms, Random random);

}  // namespace lightbatch::generate
