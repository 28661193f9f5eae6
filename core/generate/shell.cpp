#include "core/generate/shell.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/generate/materials.h"

namespace lightbatch::generate {
namespace {

constexpr double kOuterWall = 0.36, kInnerWall = 0.12, kSlab = 0.3;
constexpr double kCorridorWidth = 1.8;
constexpr double kDoorStart = 0.5;
constexpr double kSill = 0.9, kLintel = 2.15;  // lintel: of doors and windows
constexpr int kMostColumns = 24;

constexpr int kOutside = -1, kSolid = -2;

/// Sorted coordinates of the cell borders of one axis; index_of finds one that was added.
class Lines {
 public:
  void add(double value) { values_.push_back(value); }
  void close() {
    std::sort(values_.begin(), values_.end());
    const auto same = [](double a, double b) { return b - a < 1e-9; };
    values_.erase(std::unique(values_.begin(), values_.end(), same), values_.end());
  }
  int index_of(double value) const {
    const auto at = std::lower_bound(values_.begin(), values_.end(), value - 1e-9);
    return static_cast<int>(at - values_.begin());
  }
  int cells() const { return static_cast<int>(values_.size()) - 1; }
  double operator[](int i) const { return values_[static_cast<std::size_t>(i)]; }

 private:
  std::vector<double> values_;
};

/// The cells of the building: solid, or air of a space.
class Grid {
 public:
  Grid(const std::vector<Aabbd>& boxes, const Aabbd& whole) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lines_[axis].add(whole.lower[axis]);
      lines_[axis].add(whole.upper[axis]);
      for (const Aabbd& box : boxes) {
        lines_[axis].add(box.lower[axis]);
        lines_[axis].add(box.upper[axis]);
      }
      lines_[axis].close();
    }
    cells_.assign(static_cast<std::size_t>(count(0) * count(1) * count(2)), kSolid);
  }

  int count(std::size_t axis) const { return lines_[axis].cells(); }
  const Lines& lines(std::size_t axis) const { return lines_[axis]; }
  int at(int x, int y, int z) const {
    const bool inside = x >= 0 && y >= 0 && z >= 0 && x < count(0) && y < count(1) && z < count(2);
    return inside ? cells_[place(x, y, z)] : kOutside;
  }
  void carve(const Aabbd& box, int space) {
    const auto first = [&](std::size_t axis) { return lines_[axis].index_of(box.lower[axis]); };
    const auto last = [&](std::size_t axis) { return lines_[axis].index_of(box.upper[axis]); };
    for (int z = first(2); z < last(2); ++z) {
      for (int y = first(1); y < last(1); ++y) {
        for (int x = first(0); x < last(0); ++x) cells_[place(x, y, z)] = space;
      }
    }
  }

 private:
  std::size_t place(int x, int y, int z) const {
    return static_cast<std::size_t>((z * count(1) + y) * count(0) + x);
  }
  Lines lines_[3];
  std::vector<int> cells_;
};

/// Surfaces of one space by what they are.
struct Shell {
  Surface down, up, side;  // facing down (ceiling), up (floor), sideways (walls)
};

/// The square between cell (x, y, z), which is air, and its solid neighbour across `axis`.
void add_face(Surface& surface, const Grid& grid, const int (&cell)[3], std::size_t axis,
              bool towards_upper) {
  const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto corner = [&](int du, int dv) {
    Vec3d p;
    p[axis] = grid.lines(axis)[cell[axis] + (towards_upper ? 1 : 0)];
    p[u] = grid.lines(u)[cell[u] + du];
    p[v] = grid.lines(v)[cell[v] + dv];
    return p;
  };
  if (towards_upper) {  // the solid is above: the face looks down the axis
    add_quad(surface, corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0));
  } else {
    add_quad(surface, corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
  }
}

std::vector<Shell> surfaces_of(const Grid& grid, std::size_t spaces) {
  std::vector<Shell> shells(spaces + 1);  // the last one: outside
  for (int z = -1; z <= grid.count(2); ++z) {
    for (int y = -1; y <= grid.count(1); ++y) {
      for (int x = -1; x <= grid.count(0); ++x) {
        const int air = grid.at(x, y, z);
        if (air == kSolid) continue;
        Shell& shell = shells[air == kOutside ? spaces : static_cast<std::size_t>(air)];
        const int cell[3] = {x, y, z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          for (const int step : {-1, 1}) {
            int beyond[3] = {x, y, z};
            beyond[axis] += step;
            if (grid.at(beyond[0], beyond[1], beyond[2]) != kSolid) continue;
            Surface& surface = axis != 1 ? shell.side : step < 0 ? shell.up : shell.down;
            add_face(surface, grid, cell, axis, step > 0);
          }
        }
      }
    }
  }
  return shells;
}

std::string two_digits(int value) {
  std::string text = std::to_string(value);
  if (value < 10) text.insert(0, 1, '0');
  return text;
}

}  // namespace

Building make_building(int rooms, Random random) {
  const int sides = rooms > 1 ? 2 : 1;
  const int columns = std::clamp(static_cast<int>(std::ceil(0.8 * std::sqrt(rooms))), 1,
                                 std::min(kMostColumns, (rooms + sides - 1) / sides));
  const int floors = (rooms + sides * columns - 1) / (sides * columns);

  std::vector<double> starts, ends;  // of the columns' rooms, along x
  double x = kOuterWall;
  for (int column = 0; column < columns; ++column) {
    starts.push_back(x);
    x += kNarrowestRoom + 1.4 * random.next_double();
    ends.push_back(x);
    x += column + 1 < columns ? kInnerWall : kOuterWall;
  }
  const double length = x;
  const double near_wall = kOuterWall + kRoomDepth;  // inner wall of the first row of rooms
  const double corridor_start = near_wall + kInnerWall;
  const double corridor_end = corridor_start + kCorridorWidth;
  const double width =
      sides == 1 ? corridor_end + kOuterWall : corridor_end + kInnerWall + kRoomDepth + kOuterWall;
  const double storey = kRoomHeight + kSlab;
  const Aabbd whole{{0, 0, 0}, {length, floors * storey + kSlab, width}};

  // Each box of air, and the space that it belongs to.
  Building building;
  std::vector<Aabbd> boxes;
  std::vector<int> owners;
  const auto open = [&](const Aabbd& box) {
    boxes.push_back(box);
    owners.push_back(static_cast<int>(building.spaces.size()));
  };
  for (int floor = 0; floor < floors; ++floor) {
    const double y = kSlab + floor * storey, top = y + kRoomHeight;
    for (int side = 0; side < sides; ++side) {
      const double z0 = side == 0 ? kOuterWall : corridor_end + kInnerWall;
      for (int column = 0; column < columns; ++column) {
        const double x0 = starts[static_cast<std::size_t>(column)];
        const double x1 = ends[static_cast<std::size_t>(column)];
        const double middle = 0.5 * (x0 + x1), half_window = 0.3 * (x1 - x0);
        const double door0 = side == 0 ? x0 + kDoorStart : x1 - kDoorEnd;
        const double door1 = side == 0 ? x0 + kDoorEnd : x1 - kDoorStart;
        Space room;
        room.name = std::to_string(floor) + "." + two_digits(side * columns + column + 1);
        room.floor = floor;
        room.box = {{x0, y, z0}, {x1, top, z0 + kRoomDepth}};
        room.yaw = side == 0 ? 0 : std::numbers::pi;
        open(room.box);
        const double window = side == 0 ? 0 : width - kOuterWall;
        open({{middle - half_window, y + kSill, window},
              {middle + half_window, y + kLintel, window + kOuterWall}});
        const double door = side == 0 ? near_wall : corridor_end;
        open({{door0, y, door}, {door1, y + kLintel, door + kInnerWall}});
        building.spaces.push_back(std::move(room));
      }
    }
    Space corridor;
    corridor.name = "corridor " + std::to_string(floor);
    corridor.corridor = true;
    corridor.floor = floor;
    corridor.box = {{kOuterWall, y, corridor_start}, {length - kOuterWall, top, corridor_end}};
    open(corridor.box);
    open({{0, y + kSill, corridor_start + 0.4}, {kOuterWall, y + kLintel, corridor_end - 0.4}});
    building.spaces.push_back(std::move(corridor));
  }

  Grid grid(boxes, whole);
  for (std::size_t i = 0; i < boxes.size(); ++i) grid.carve(boxes[i], owners[i]);
  std::vector<Shell> shells = surfaces_of(grid, building.spaces.size());
  for (std::size_t i = 0; i < shells.size(); ++i) {
    const bool outside = i == building.spaces.size();
    const bool corridor = !outside && building.spaces[i].corridor;
    const int paint = outside ? kFacade : kPaint;
    Model model{outside ? "outside" : "walls " + building.spaces[i].name, {}};
    model.parts.push_back({paint, std::move(shells[i].side)});
    model.parts.push_back({outside    ? kFacade
                           : corridor ? kTiles
                                      : kCarpet,
                           std::move(shells[i].up)});
    model.parts.push_back({outside ? kFacade : kCeiling, std::move(shells[i].down)});
    building.shells.push_back(std::move(model));
  }
  return building;
}

}  // namespace lightbatch::generate
