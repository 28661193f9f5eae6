#include "core/radiosity/elements.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/radiosity/cover.h"

namespace lightbatch::radiosity {
namespace {

using hierarchy::Hierarchy;
using scene::Scene;

/// Dominant axis and sign of the normal: 0..5.
int direction_of(const Scene& scene, std::uint32_t triangle) {
  const auto c = scene.corners(triangle);
  const Vec3d a = to_double(c[0]);
  const Vec3d n = cross(to_double(c[1]) - a, to_double(c[2]) - a);
  int axis = 0;
  if (std::fabs(n.y) > std::fabs(n.x)) axis = 1;
  if (std::fabs(n.z) > std::fabs(n[static_cast<std::size_t>(axis)])) axis = 2;
  return 2 * axis + (n[static_cast<std::size_t>(axis)] < 0 ? 1 : 0);
}

/// Area of the part of the cell [0, 1]^2 below the line x / a + y / b = 1 with a, b > 0.
double area_below(double a, double b) {
  if (1.0 / a + 1.0 / b <= 1.0) return 1.0;
  const double whole = 0.5 * a * b;
  const double right = a > 1.0 ? 0.5 * (a - 1.0) * (a - 1.0) * b / a : 0.0;
  const double top = b > 1.0 ? 0.5 * (b - 1.0) * (b - 1.0) * a / b : 0.0;
  return std::clamp(whole - right - top, 0.0, 1.0);
}

std::uint32_t columns_in_row(std::uint32_t i, std::uint32_t rows, std::uint32_t columns) {
  // Cells j with i / rows + j / columns < 1.
  const std::uint64_t room = static_cast<std::uint64_t>(rows - i) * columns;
  return static_cast<std::uint32_t>((room + rows - 1) / rows);
}

constexpr std::uint32_t kMaxDivisions = 4096;

}  // namespace

/// Which triangles become grids, and how fine, for one trial of the edge length.
struct Elements::Plan {
  struct Division {
    std::uint32_t triangle, rows, columns;
    std::uint8_t corner;
  };
  std::vector<Division> divisions;
  std::vector<std::uint8_t> is_large;
  std::uint64_t cells = 0;

  Plan(const Scene& scene, double edge) : is_large(scene.triangles.size(), 0) {
    for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
      const auto c = scene.corners(i);
      std::array<double, 3> side{};  // side[k]: from corner k to the next
      for (std::size_t k = 0; k < 3; ++k) {
        side[k] = length(to_double(c[(k + 1) % 3]) - to_double(c[k]));
      }
      const double longest = std::max(side[0], std::max(side[1], side[2]));
      if (longest <= edge) continue;
      const std::size_t k = best_corner(side);
      const auto parts = [&](double size) {
        return static_cast<std::uint32_t>(
            std::clamp(std::ceil(size / edge), 1.0, static_cast<double>(kMaxDivisions)));
      };
      const Division d{i, parts(side[k]), parts(side[(k + 2) % 3]), static_cast<std::uint8_t>(k)};
      if (d.rows == 1 && d.columns == 1) continue;
      is_large[i] = 1;
      divisions.push_back(d);
      for (std::uint32_t r = 0; r < d.rows; ++r) cells += columns_in_row(r, d.rows, d.columns);
    }
  }

  /// The corner between the two shortest sides, unless they are nearly opposite; then the one
  /// between the shortest and the longest, so that cells of a sliver do not become slivers twice.
  static std::size_t best_corner(const std::array<double, 3>& side) {
    std::size_t longest = 0, shortest = 0;
    for (std::size_t k = 1; k < 3; ++k) {
      if (side[k] > side[longest]) longest = k;
      if (side[k] < side[shortest]) shortest = k;
    }
    const std::size_t opposite = (longest + 2) % 3;
    const double p = side[(longest + 1) % 3], q = side[(longest + 2) % 3];
    const double cosine = (p * p + q * q - side[longest] * side[longest]) / (2 * p * q + 1e-300);
    if (cosine > -0.5) return opposite;
    // Sides k and k - 1 meet at corner k.
    const std::size_t next = (shortest + 1) % 3;
    return next == longest ? next : shortest;
  }
};

Elements::Elements(const Scene& scene, const Hierarchy& tree, const optics::Optics& optics,
                   const ElementOptions& options, const rays::Caster* caster)
    : edge_(options.edge), faces_(scene.triangles.size()) {
  LB_CHECK(options.edge > 0, "the element edge is positive");
  Plan plan(scene, edge_);
  while (2 * plan.cells > options.max_elements) {
    edge_ *= 1.25;
    plan = Plan(scene, edge_);
  }
  add_groups(scene, tree, optics, caster, plan);
  first_cell_ = count();
  add_cells(scene, optics, plan);
  reflectance_.resize(area_.size());
  average_optics(optics);
  find_behind();
}

void Elements::add_groups(const Scene& scene, const Hierarchy& tree, const optics::Optics& optics,
                          const rays::Caster* caster, Plan& plan) {
  group_start_.push_back(0);
  if (tree.is_empty()) return;
  const double reach = 1.5 * edge_;
  struct Entry {
    std::uint32_t triangle;
    int bucket;  // cover, direction, side
    float area;
  };
  const Covers covers(scene, optics, caster, edge_, plan.is_large);
  const auto bucket_of = [&](std::uint32_t triangle, int direction, bool back) {
    return 12 * covers.of(triangle, back) + 2 * direction + (back ? 1 : 0);
  };
  std::vector<Entry> entries;
  std::vector<Hierarchy::NodeId> stack{0};
  while (!stack.empty()) {
    const Hierarchy::NodeId node = stack.back();
    stack.pop_back();
    if (!tree.is_leaf(node) && static_cast<double>(tree.box(node).diagonal()) > reach) {
      stack.push_back(tree.right(node));
      stack.push_back(tree.left(node));
      continue;
    }
    entries.clear();
    for (const std::uint32_t triangle : tree.primitives(node)) {
      if (plan.is_large[triangle]) continue;
      const int direction = direction_of(scene, triangle);
      const auto area = static_cast<float>(scene.area(triangle));
      entries.push_back({triangle, bucket_of(triangle, direction, false), area});
      if (optics.has_two_sides(triangle)) {
        entries.push_back({triangle, bucket_of(triangle, direction ^ 1, true), area});
      }
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
      return a.bucket != b.bucket ? a.bucket < b.bucket : a.triangle < b.triangle;
    });
    for (std::size_t i = 0; i < entries.size();) {
      const ElementId element = count();
      double total = 0;
      std::size_t j = i;
      for (; j < entries.size() && entries[j].bucket == entries[i].bucket; ++j) {
        total += static_cast<double>(entries[j].area);
      }
      double sum = 0;
      for (; i < j; ++i) {
        sum += static_cast<double>(entries[i].area);
        group_triangles_.push_back(entries[i].triangle);
        group_cumulative_.push_back(total > 0 ? static_cast<float>(sum / total) : 1.0f);
        Face& face = faces_[entries[i].triangle];
        (entries[i].bucket & 1 ? face.back : face.front) = element;
      }
      area_.push_back(static_cast<float>(total));
      back_.push_back(static_cast<std::uint8_t>(entries[i - 1].bucket & 1));
      group_start_.push_back(static_cast<std::uint32_t>(group_triangles_.size()));
    }
  }
}

void Elements::add_cells(const Scene& scene, const optics::Optics& optics, Plan& plan) {
  for (const Plan::Division& d : plan.divisions) {
    const auto grid = static_cast<std::uint32_t>(grids_.size());
    grids_.push_back(
        {d.triangle, d.rows, d.columns, static_cast<std::uint32_t>(row_start_.size()), d.corner});
    std::uint32_t cells = 0;
    for (std::uint32_t r = 0; r < d.rows; ++r) {
      row_start_.push_back(cells);
      cells += columns_in_row(r, d.rows, d.columns);
    }
    row_start_.push_back(cells);
    const double cell_area =
        2.0 * scene.area(d.triangle) / (static_cast<double>(d.rows) * d.columns);
    Face& face = faces_[d.triangle];
    face.grid = grid;
    for (int side = 0; side < (optics.has_two_sides(d.triangle) ? 2 : 1); ++side) {
      (side == 0 ? face.front : face.back) = count();
      grid_first_.push_back(count());
      grid_of_.push_back(grid);
      for (std::uint32_t i = 0; i < d.rows; ++i) {
        const std::uint32_t columns = columns_in_row(i, d.rows, d.columns);
        for (std::uint32_t j = 0; j < columns; ++j) {
          // The third edge s + t = 1 in cell coordinates x, y: (x + i) / rows + (y + j) / columns.
          const double room =
              1.0 - static_cast<double>(i) / d.rows - static_cast<double>(j) / d.columns;
          area_.push_back(
              static_cast<float>(cell_area * area_below(room * d.rows, room * d.columns)));
          back_.push_back(static_cast<std::uint8_t>(side));
        }
      }
    }
  }
}

ElementId Elements::at(std::uint32_t triangle, float u, float v, bool back) const {
  const Face& face = faces_[triangle];
  const ElementId first = back ? face.back : face.front;
  if (first == kNoElement || face.grid == scene::kNone) return first;
  const Grid& grid = grids_[face.grid];
  const std::array<float, 3> weight{1.0f - u - v, u, v};
  const float s = weight[(grid.corner + 1u) % 3];
  const float t = weight[(grid.corner + 2u) % 3];
  const auto index = [](float x, std::uint32_t n) {
    return std::min(static_cast<std::uint32_t>(std::max(0.0f, x * static_cast<float>(n))), n - 1);
  };
  const std::uint32_t i = index(s, grid.rows);
  const std::uint32_t start = row_start_[grid.first_row + i];
  const std::uint32_t columns = row_start_[grid.first_row + i + 1] - start;
  return first + start + std::min(index(t, grid.columns), columns - 1);
}

Elements::Cell Elements::cell_of(ElementId e) const {
  const auto side = static_cast<std::size_t>(
      std::upper_bound(grid_first_.begin(), grid_first_.end(), e) - grid_first_.begin() - 1);
  const std::uint32_t g = grid_of_[side];
  const Grid& grid = grids_[g];
  const std::uint32_t offset = e - grid_first_[side];
  const auto* begin = row_start_.data() + grid.first_row;
  const auto* row = std::upper_bound(begin, begin + grid.rows + 1, offset) - 1;
  return {g, static_cast<std::uint32_t>(row - begin), offset - *row};
}

ElementPoint Elements::point(ElementId e, float a, float b) const {
  if (!is_cell(e)) {
    const std::uint32_t first = group_start_[e];
    const std::uint32_t last = group_start_[e + 1];
    std::uint32_t k = first;
    float below = 0;
    if (last - first > 1) {
      const auto* begin = group_cumulative_.data();
      k = static_cast<std::uint32_t>(std::upper_bound(begin + first, begin + last - 1, a) - begin);
      below = k > first ? group_cumulative_[k - 1] : 0.0f;
      const float span = group_cumulative_[k] - below;
      a = span > 0 ? std::clamp((a - below) / span, 0.0f, 0x1.fffffep-1f) : 0.5f;
    }
    const float root = std::sqrt(a);
    return {group_triangles_[k], 1.0f - root, b * root};
  }
  const Cell cell = cell_of(e);
  const Grid& grid = grids_[cell.grid];
  const auto rows = static_cast<double>(grid.rows);
  const auto columns = static_cast<double>(grid.columns);
  const double room = 1.0 - cell.i / rows - cell.j / columns;
  double x = static_cast<double>(a), y = static_cast<double>(b);
  // Cells cut by the third edge: rejection, a handful of tries from the same two numbers.
  Random random((static_cast<std::uint64_t>(e) << 32) ^
                static_cast<std::uint64_t>(a * 0x1p24f) * 0x9e3779b97f4a7c15ULL ^
                static_cast<std::uint64_t>(b * 0x1p24f));
  for (int attempt = 0; x / rows + y / columns >= room && attempt < 32; ++attempt) {
    x = random.next_double();
    y = random.next_double();
  }
  if (x / rows + y / columns >= room) {
    // A sliver of a cell: its inner corner's neighbourhood.
    const double scale = 0.3 * room / (x / rows + y / columns);
    x *= scale;
    y *= scale;
  }
  return point_in(cell, x, y);
}

ElementPoint Elements::point_in(const Cell& cell, double x, double y) const {
  const Grid& grid = grids_[cell.grid];
  const auto s = static_cast<float>((cell.i + x) / grid.rows);
  const auto t = static_cast<float>((cell.j + y) / grid.columns);
  std::array<float, 3> weight{};
  weight[(grid.corner + 1u) % 3] = s;
  weight[(grid.corner + 2u) % 3] = t;
  weight[grid.corner] = std::max(0.0f, 1.0f - s - t);
  return {grid.triangle, weight[1], weight[2]};
}

/// In shares of a cell's rows and columns.
struct Elements::Polygon {
  std::array<Vec2d, 5> corner;
  std::size_t count = 0;
  Vec2d middle;
};

Elements::Polygon Elements::polygon(const Cell& cell) const {
  const Grid& grid = grids_[cell.grid];
  const double rows = grid.rows, columns = grid.columns;
  // Of the way to where the third edge cuts the cell's sides, along rows and along columns.
  const double room = 1.0 - cell.i / rows - cell.j / columns;
  const double along = room * rows, across = room * columns;
  Polygon polygon{{}, 1, {}};
  auto& [corner, count, middle] = polygon;
  corner[count++] = {std::min(1.0, along), 0.0};
  if (1 / rows + 1 / columns <= room) {
    corner[count++] = {1.0, 1.0};
  } else {
    if (along > 1) corner[count++] = {1.0, across - columns / rows};
    if (across > 1) corner[count++] = {along - rows / columns, 1.0};
  }
  corner[count++] = {0.0, std::min(1.0, across)};
  for (std::size_t k = 0; k < count; ++k) {
    middle = middle + corner[k] * (1 / static_cast<double>(count));
  }
  return polygon;
}

Elements::Outline Elements::outline(ElementId e) const {
  constexpr double kInside = 0.98;
  const Cell cell = cell_of(e);
  const Polygon whole = polygon(cell);
  Outline outline{{}, whole.count};
  for (std::size_t k = 0; k < whole.count; ++k) {
    const Vec2d p = whole.middle + (whole.corner[k] - whole.middle) * kInside;
    outline.corner[k] = point_in(cell, p.x, p.y);
  }
  return outline;
}

ElementPoint Elements::middle(ElementId e) const {
  const Cell cell = cell_of(e);
  const Vec2d at = polygon(cell).middle;
  return point_in(cell, at.x, at.y);
}

std::size_t Elements::neighbours(ElementId e, ElementId* result) const {
  if (!is_cell(e)) return 0;
  const Cell cell = cell_of(e);
  const Grid& grid = grids_[cell.grid];
  const std::uint32_t* row = row_start_.data() + grid.first_row;
  const ElementId first = e - (row[cell.i] + cell.j);
  std::size_t count = 0;
  constexpr int kSteps[8][2] = {{0, 1}, {0, -1},  {1, 0},  {-1, 0},
                                {1, 1}, {-1, -1}, {1, -1}, {-1, 1}};
  for (const auto& step : kSteps) {
    const std::int64_t i = static_cast<std::int64_t>(cell.i) + step[0];
    const std::int64_t j = static_cast<std::int64_t>(cell.j) + step[1];
    if (i < 0 || j < 0 || i >= static_cast<std::int64_t>(grid.rows)) continue;
    const auto k = static_cast<std::size_t>(i);
    if (j >= static_cast<std::int64_t>(row[k + 1]) - static_cast<std::int64_t>(row[k])) continue;
    result[count++] = first + row[k] + static_cast<ElementId>(j);
  }
  return count;
}

std::span<const std::uint32_t> Elements::group(ElementId e) const {
  if (is_cell(e)) return {};
  return std::span(group_triangles_)
      .subspan(group_start_[e], group_start_[e + 1] - group_start_[e]);
}

std::size_t Elements::memory_bytes() const {
  const auto bytes = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  return bytes(faces_) + bytes(grids_) + bytes(row_start_) + bytes(grid_first_) + bytes(grid_of_) +
         bytes(area_) + bytes(covered_area_) + bytes(reflectance_) + bytes(transmittance_) +
         bytes(behind_start_) + bytes(behind_) + bytes(back_) + bytes(group_start_) +
         bytes(group_triangles_) + bytes(group_cumulative_);
}

}  // namespace lightbatch::radiosity
