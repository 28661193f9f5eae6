#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/hierarchy/hierarchy.h"
#include "core/math/rgb.h"
#include "core/math/vec.h"
#include "core/optics/optics.h"
#include "core/rays/caster.h"
#include "core/scene/scene.h"

namespace lightbatch::radiosity {

using ElementId = std::uint32_t;
/// What a ray meets that is no element: the back of a one-sided face, which absorbs.
constexpr ElementId kNoElement = 0xffffffffu;

struct ElementOptions {
  /// Edge of an element in metres: larger triangles are cut into cells of about this edge, smaller
  /// ones gathered into groups of about 1.5 edges across.
  double edge = 0.2;
  /// At most about this many elements; the edge grows until they fit.
  std::uint64_t max_elements = 4'000'000;
};

/// A point on one side of a triangle.
struct ElementPoint {
  std::uint32_t triangle = 0;
  float u = 0, v = 0;
};

/// The surfaces of a scene cut into pieces of constant radiosity. Two kinds:
///   cells: parallelograms (cut at the third edge) of a large triangle, found by barycentric index;
///   groups: small triangles under one hierarchy node whose normals share one of six directions, as
///   far covered.
/// Each lies on one side of its triangles; two-sided materials have an element on either side.
/// Immutable; thread-safe.
class Elements {
 public:
  /// caster: where given, groups do not hold together what lies open and what is covered close by:
  /// outer and inner shells of a small closed solid, hidden and open sides in a stack.
  Elements(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
           const optics::Optics& optics, const ElementOptions& options,
           const rays::Caster* caster = nullptr);

  std::uint32_t count() const { return static_cast<std::uint32_t>(area_.size()); }
  double edge() const { return edge_; }
  /// m2, holes of cut-outs included: how far it extends.
  float area(ElementId e) const { return area_[e]; }
  /// m2 of what is there, without holes and what sheets let pass: what light meets.
  float covered_area(ElementId e) const { return covered_area_[e]; }
  /// Mean reflectance of what is there.
  const Rgb& reflectance(ElementId e) const { return reflectance_[e]; }
  /// Mean share of the light arriving on the other side of what is there that leaves this one.
  Rgb transmittance(ElementId e) const {
    return transmittance_.empty() ? Rgb{} : transmittance_[e];
  }
  /// Some element has a transmittance.
  bool transmits() const { return !transmittance_.empty(); }
  /// visit(element, share): what lies behind an element that transmits; shares add up to 1.
  template <typename Visit>
  void for_each_behind(ElementId e, Visit visit) const {
    for (auto k = behind_start_[e]; k < behind_start_[e + 1]; ++k) {
      visit(behind_[k].element, behind_[k].share);
    }
  }
  /// The side away from the counter-clockwise normal.
  bool is_back(ElementId e) const { return back_[e] != 0; }
  bool is_cell(ElementId e) const { return e >= first_cell_; }

  /// The element at (u, v) of a triangle's side, or kNoElement.
  ElementId at(std::uint32_t triangle, float u, float v, bool back) const;

  /// An area-uniform point of the element for random (a, b) in [0, 1)^2.
  ElementPoint point(ElementId e, float a, float b) const;
  /// Of a cell, which the third edge may cut.
  struct Outline {
    std::array<ElementPoint, 5> corner;  // in order, a hundredth of the cell inside
    std::size_t count = 0;
  };
  Outline outline(ElementId cell) const;
  /// Of its corners.
  ElementPoint middle(ElementId cell) const;

  /// Cells of the same triangle's side around a cell, at most 8, edge neighbours first.
  std::size_t neighbours(ElementId e, ElementId* result) const;

  /// Triangles of a group (empty for a cell).
  std::span<const std::uint32_t> group(ElementId e) const;

  std::size_t memory_bytes() const;

 private:
  struct Face {
    ElementId front = kNoElement;
    ElementId back = kNoElement;
    std::uint32_t grid = scene::kNone;  // into grids_: cut into cells
  };
  /// Cells (i, j), i < rows, j < columns(i): s in [i, i+1)/rows, t in [j, j+1)/columns_0 with
  /// s + t < 1, where point = corner + s (next - corner) + t (previous - corner).
  struct Grid {
    std::uint32_t triangle = 0;
    std::uint32_t rows = 1;
    std::uint32_t columns = 1;
    std::uint32_t first_row = 0;  // into row_start_: cells before row i
    std::uint8_t corner = 0;
  };
  struct Cell {
    std::uint32_t grid, i, j;
  };
  struct Plan;

  Cell cell_of(ElementId e) const;
  struct Polygon;
  Polygon polygon(const Cell& cell) const;
  ElementPoint point_in(const Cell& cell, double x, double y) const;
  void add_cells(const scene::Scene& scene, const optics::Optics& optics, Plan& plan);
  void add_groups(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                  const optics::Optics& optics, const rays::Caster* caster, Plan& plan);
  void average_optics(const optics::Optics& optics);
  optics::Optics::Scatterer mean_over(ElementId e, const optics::Optics& optics) const;
  void find_behind();

  double edge_ = 0;
  ElementId first_cell_ = 0;
  std::vector<Face> faces_;
  std::vector<Grid> grids_;
  std::vector<std::uint32_t> row_start_;
  std::vector<ElementId> grid_first_;   // first element of each grid side, ascending
  std::vector<std::uint32_t> grid_of_;  // the grid of each entry of grid_first_
  std::vector<float> area_, covered_area_;
  std::vector<Rgb> reflectance_;
  struct Behind {
    ElementId element;
    float share;
  };
  std::vector<Rgb> transmittance_;           // empty, as the next two, where nothing transmits
  std::vector<std::uint32_t> behind_start_;  // per element and one past
  std::vector<Behind> behind_;
  std::vector<std::uint8_t> back_;
  std::vector<std::uint32_t> group_start_;  // per group, into group_triangles_
  std::vector<std::uint32_t> group_triangles_;
  std::vector<float> group_cumulative_;  // area up to and including the triangle, share
};

}  // namespace lightbatch::radiosity
