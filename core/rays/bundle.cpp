#include "core/rays/bundle.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/rays/caster_tree.h"
#include "core/rays/shaft.h"

namespace lightbatch::rays {
namespace {

constexpr int kSearchesBeforeGathering = 3;

/// A few hundred roundings of float at the scale of the scene and the boxes.
float slack_of(const WideTree& tree, const Aabb& a, const Aabb& b) {
  Aabb all = a;
  all.add(b);
  float span = std::max({tree.reach[0], tree.reach[1], tree.reach[2]});
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
  float slack = 0;
  int searches = 0;  // segments that nothing stopped
  bool gathered = false;
  bool narrow = false;  // few enough leaves to look at them alone
  std::size_t count = 0;
  WideNode packs[Shaft::kMost / kWidth + 1];

  void gather() {
    if (gathered) return;
    gathered = true;
    count = tree->kernel->gather(tree->wide, Shaft(from, to, slack), packs);
    narrow = count != kTooMany;
  }
};

Bundle::Bundle(const Caster& caster, const Aabb& from, const Aabb& to) : state_(new State) {
  State& s = *state_;
  s.caster = &caster;
  s.tree = caster.tree_.get();
  s.slack = slack_of(s.tree->wide, from, to);
  s.from = grown(from, s.slack * 0.5f);
  s.to = grown(to, s.slack * 0.5f);
}

Bundle::~Bundle() = default;
Bundle::Bundle(Bundle&&) noexcept = default;
Bundle& Bundle::operator=(Bundle&&) noexcept = default;

bool Bundle::is_clear() {
  state_->gather();
  return state_->count == 0;
}

bool Bundle::occluded(const Ray& segment, std::uint32_t exclude_a, std::uint32_t exclude_b,
                      HitFilter* filter) {
  State& s = *state_;
  const WideTree& wide = s.tree->wide;
  if (wide.empty || !is_finite(segment.origin) || !is_finite(segment.direction) ||
      segment.direction == Vec3f{}) {
    return false;
  }
  const Vec3f end = segment.origin + segment.direction * segment.t_max;
  const bool there = s.from.contains(segment.origin) && s.to.contains(end);
  const bool back = s.to.contains(segment.origin) && s.from.contains(end);
  const bool known_ends = (there || back) && segment.t_min >= 0;
  if (known_ends && s.searches > kSearchesBeforeGathering) s.gather();
  if (known_ends && s.narrow && s.count == 0) return false;
  const bool stopped = s.tree->kernel->occluded(wide, segment, exclude_a, exclude_b, filter);
  if (!stopped) ++s.searches;
  return stopped;
}

}  // namespace lightbatch::rays
