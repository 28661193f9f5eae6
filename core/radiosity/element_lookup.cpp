#include "core/radiosity/element_lookup.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/base/parallel.h"
#include "core/optics/surface_frame.h"

namespace lightbatch::radiosity {
namespace {

/// Sight lines run this share of an element's edge above the surface: low enough to meet what
/// stands on it, high enough to pass over the surface's own roughness.
constexpr float kSightHeight = 0.02f;

/// Cells that are looked at for one in the place of a split one.
constexpr std::size_t kMostVisited = 25;

}  // namespace

ElementLookup::ElementLookup(const scene::Scene& scene, const rays::Caster& caster,
                             const Elements& elements, float lift)
    : scene_(&scene),
      caster_(&caster),
      elements_(&elements),
      lift_(lift),
      split_(elements.count(), 0),
      centre_covered_(elements.count(), 0) {
  constexpr std::size_t kGrain = 1024;
  parallel_for(elements.count(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto e = static_cast<ElementId>(i);
      if (!elements.is_cell(e)) continue;
      const bool back = elements.is_back(e);
      const Elements::Outline outline = elements.outline(e);
      std::array<Place, 5> corner;
      for (std::size_t k = 0; k < outline.count; ++k) corner[k] = place(outline.corner[k], back);
      // A line that crosses the cell crosses one of these: from a corner to all others, and between
      // the two beside it.
      bool whole = sees(corner[1], corner[outline.count - 1], back);
      for (std::size_t k = 1; k < outline.count && whole; ++k) {
        whole = sees(corner[0], corner[k], back);
      }
      split_[i] = whole ? 0 : 1;
      centre_covered_[i] = place(elements.middle(e), back).covered ? 1 : 0;
    }
  });
  split_count_ = static_cast<std::uint64_t>(std::accumulate(split_.begin(), split_.end(), 0u));
}

ElementLookup::Place ElementLookup::place(const ElementPoint& at, bool back) const {
  const auto frame = optics::surface_frame(*scene_, at.triangle, at.u, at.v, back, lift_);
  const float height = kSightHeight * static_cast<float>(elements_->edge());
  return {at, caster_->occluded({frame.origin, frame.normal, 0.0f, height}, at.triangle)};
}

bool ElementLookup::sees(const Place& from, const Place& to, bool back) const {
  // Under a board that lies closer to the surface than that, one looks below the board.
  if (from.covered != to.covered) return false;
  const float height = from.covered ? 0 : kSightHeight * static_cast<float>(elements_->edge());
  const auto origin = [&](const ElementPoint& p) {
    const auto frame = optics::surface_frame(*scene_, p.triangle, p.u, p.v, back, lift_);
    return frame.origin + frame.normal * height;
  };
  const Vec3f a = origin(from.at);
  return !caster_->occluded({a, origin(to.at) - a, 0.0f, 1.0f}, from.at.triangle, to.at.triangle);
}

ElementId ElementLookup::at(const rays::Hit& hit) const {
  const ElementId e = elements_->at(hit.triangle, hit.u, hit.v, hit.back);
  if (e == kNoElement || split_[e] == 0) return e;
  const Place here = place({hit.triangle, hit.u, hit.v}, hit.back);
  // Ring after ring.
  std::array<ElementId, kMostVisited> visited{e};
  std::size_t count = 1;
  for (std::size_t from = 0; from < count; ++from) {
    ElementId around[8];
    const std::size_t found = elements_->neighbours(visited[from], around);
    for (std::size_t k = 0; k < found && count < kMostVisited; ++k) {
      const ElementId n = around[k];
      if (std::find(visited.begin(), visited.begin() + count, n) != visited.begin() + count) {
        continue;
      }
      visited[count++] = n;
      if (split_[n] != 0) continue;
      const Place there{elements_->middle(n), centre_covered_[n] != 0};
      if (sees(here, there, hit.back)) return n;
    }
  }
  return e;
}

}  // namespace lightbatch::radiosity
