#pragma once

#include <vector>

#include "core/radiosity/elements.h"
#include "core/rays/caster.h"

namespace lightbatch::radiosity {

/// Which element a ray that lands on a surface reads. Some cells lie under a wall that stands on
/// them: half in one room, half in another, and their mean belongs to neither. A hit on such a
/// split cell reads a whole neighbour, or a neighbour's neighbour, that the hit point sees along
/// the surface, so that no light leaks under walls. Immutable; thread-safe.
class ElementLookup {
 public:
  ElementLookup(const scene::Scene& scene, const rays::Caster& caster, const Elements& elements,
                float lift);

  /// kNoElement for backs of one-sided faces.
  ElementId at(const rays::Hit& hit) const;

  /// Nothing better than the mean of two rooms: such a cell is only returned where no whole
  /// neighbour is in sight, and what a ray sees of it has to be found by a ray more.
  bool is_split(ElementId e) const { return split_[e] != 0; }
  std::uint64_t split_cells() const { return split_count_; }

  /// A point of a surface, and whether something lies closer above it than sight lines run.
  struct Place {
    ElementPoint at;
    bool covered = false;
  };
  Place place(const ElementPoint& at, bool back) const;
  /// Nothing stands between two points of one plane.
  bool sees(const Place& from, const Place& to, bool back) const;

 private:
  const scene::Scene* scene_;
  const rays::Caster* caster_;
  const Elements* elements_;
  float lift_ = 0;
  std::vector<std::uint8_t> split_;           // per element
  std::vector<std::uint8_t> centre_covered_;  // per element
  std::uint64_t split_count_ = 0;
};

}  // namespace lightbatch::radiosity
