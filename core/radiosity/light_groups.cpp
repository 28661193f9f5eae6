#include "core/radiosity/light_groups.h"

#include <algorithm>
#include <numeric>

namespace lightbatch::radiosity {

std::uint32_t Grouping::add(const LightGroup& group, double power) {
  const auto [at, fresh] = number_.emplace(std::pair(group.kind, group.index),
                                           static_cast<std::uint32_t>(groups_.size()));
  if (fresh) {
    groups_.push_back(group);
    power_.push_back(0);
  }
  power_[at->second] += power;
  return at->second;
}

Grouping::Groups Grouping::finish() const {
  constexpr std::size_t kOwn = kMostGroups - 1;  // one is the sky's
  Groups result;
  result.renumber.resize(groups_.size());
  if (groups_.size() <= kOwn) {
    result.groups = groups_;
    std::iota(result.renumber.begin(), result.renumber.end(), 0u);
    return result;
  }
  std::vector<std::uint32_t> order(groups_.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return power_[a] > power_[b]; });
  for (std::size_t k = 0; k < order.size(); ++k) {
    result.renumber[order[k]] = static_cast<std::uint32_t>(std::min(k, kOwn - 1));
    if (k + 1 < kOwn) result.groups.push_back(groups_[order[k]]);
  }
  result.groups.push_back({LightGroup::Kind::kOthers, 0, "others", {1, 1, 1}});
  return result;
}

}  // namespace lightbatch::radiosity
