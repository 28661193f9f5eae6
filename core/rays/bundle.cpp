#include "core/rays/bundle.h"

#include <algorithm>
#include <cmath>

#include "core/rays/caster_tree.h"
#include "core/rays/shaft.h"

namespace lightbatch::rays {
namespace {

/// A few hundred roundings of float at the scale of the scene and the boxes.
float slack_of(const WideTree& tree, const Aabb& a, const Aabb& b) {
  Aabb all = a;
  all.add(b);
  float span = std::max({tree.reach.x, tree.reach.y, tree.reach.z});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    span = std::max({span, std::abs(all.lower[axis]), std::abs(all.upper[axis])});
  }
  return span * 0x1p-16f + 1e-36f;
}

Aabb grown(const Aabb& box, float by) {
  return {box.lower - Vec3f{by, by, by}, box.upper + Vec3f{by, by, by}};
}

}  // namespace

struct Bundle::State {
  const Caster* caster;
  const Caster::Tree* tree;
  Aabb from, to;  // with half of the shaft's slack
  std::size_t count = 0;
  WideNode packs[Shaft::kMost / kWidth + 1];
};

Bundle::Bundle(const Caster& caster, const Aabb& from, const Aabb& to) : state_(new State) {
  State& s = *state_;
  s.caster = &caster;
  s.tree = caster.tree_.get();
  const float slack = slack_of(s.tree->wide, from, to);
  s.from = grown(from, slack * 0.5f);
  s.to = grown(to, slack * 0.5f);
  s.count = s.tree->kernel->gather(s.tree->wide, Shaft(s.from, s.to, slack), s.packs);
}

Bundle::~Bundle() = default;
Bundle::Bundle(Bundle&&) noexcept = default;
Bundle& Bundle::operator=(Bundle&&) noexcept = default;

bool Bundle::is_clear() const { return state_->count == 0; }

bool Bundle::occluded(const Ray& segment, std::uint32_t exclude_a, std::uint32_t exclude_b,
                      HitFilter* filter) const {
  const State& s = *state_;
  const Vec3f end = segment.origin + segment.direction * segment.t_max;
  const bool there = s.from.contains(segment.origin) && s.to.contains(end);
  const bool back = s.to.contains(segment.origin) && s.from.contains(end);
  if (!(there || back) || !(segment.t_min >= 0)) {
    return s.caster->occluded(segment, exclude_a, exclude_b, filter);
  }
  if (s.count == 0) return false;
  return s.tree->kernel->occluded_from(s.tree->wide, {s.packs, s.count}, segment, exclude_a,
                                       exclude_b, filter);
}

}  // namespace lightbatch::rays
