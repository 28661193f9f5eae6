#include "core/hierarchy/comparators.h"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "core/hierarchy/builder.h"
#include "core/hierarchy/insertion.h"
#include "core/hierarchy/split_rule.h"

namespace lightbatch::hierarchy {
namespace {

using Ids = std::span<std::uint32_t>;
/// Reorders the primitives of a node and says how many go to the left.
using Splitter = std::function<std::size_t(Ids ids)>;

TreeArrays top_down(std::span<const Aabb> boxes, std::vector<std::uint32_t> ids,
                    const Splitter& split) {
  struct Part {
    std::uint32_t begin, end, place;
    int depth;
  };
  TreeArrays tree(boxes.size());
  std::vector<Part> stack{{0, static_cast<std::uint32_t>(ids.size()), 0, 0}};
  while (!stack.empty()) {
    const Part part = stack.back();
    stack.pop_back();
    const std::uint32_t n = part.end - part.begin;
    Aabb b;
    for (std::uint32_t k = part.begin; k < part.end; ++k) b.add(boxes[ids[k]]);
    tree.nodes[part.place] = {
        {b.lower.x, b.lower.y, b.lower.z}, part.begin, {b.upper.x, b.upper.y, b.upper.z}, n};
    if (n == 1) {
      tree.primitives[part.begin] = ids[part.begin];
      continue;
    }
    const auto wanted = static_cast<std::uint32_t>(split(Ids(ids).subspan(part.begin, n)));
    const PositionRange range = allowed_positions(n, part.depth);
    const std::uint32_t left = std::clamp(wanted, range.first, range.last);
    stack.push_back({part.begin + left, part.end, part.place + 2 * left, part.depth + 1});
    stack.push_back({part.begin, part.begin + left, part.place + 1, part.depth + 1});
  }
  return tree;
}

Aabb centre_bounds(std::span<const Aabb> boxes, Ids ids) {
  Aabb bounds;
  for (const std::uint32_t i : ids) {
    bounds.add(Vec3f{centre_key(boxes[i], 0), centre_key(boxes[i], 1), centre_key(boxes[i], 2)});
  }
  return bounds;
}

std::size_t split_median(std::span<const Aabb> boxes, Ids ids) {
  const Vec3f e = centre_bounds(boxes, ids).extent();
  const std::size_t axis = e.x >= e.y ? (e.x >= e.z ? 0u : 2u) : (e.y >= e.z ? 1u : 2u);
  const auto middle = ids.begin() + std::ssize(ids) / 2;
  std::nth_element(ids.begin(), middle, ids.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(centre_key(boxes[a], axis), a) < std::pair(centre_key(boxes[b], axis), b);
  });
  return ids.size() / 2;
}

std::size_t split_binned(std::span<const Aabb> boxes, Ids ids) {
  constexpr std::size_t kBins = 16;
  const Aabb bounds = centre_bounds(boxes, ids);
  const auto bin_of = [&](std::uint32_t i, std::size_t axis) {
    const double low = static_cast<double>(bounds.lower[axis]);
    const double width = static_cast<double>(bounds.upper[axis]) - low;
    const double at = (static_cast<double>(centre_key(boxes[i], axis)) - low) / width;
    return std::min(kBins - 1, static_cast<std::size_t>(at * kBins));
  };
  float best = std::numeric_limits<float>::infinity();
  std::size_t best_axis = 0, best_bin = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(bounds.upper[axis] > bounds.lower[axis])) continue;
    std::array<Aabb, kBins> box;
    std::array<std::uint32_t, kBins> count{};
    for (const std::uint32_t i : ids) {
      const std::size_t bin = bin_of(i, axis);
      box[bin].add(boxes[i]);
      ++count[bin];
    }
    std::array<float, kBins> right{};
    Aabb all;
    std::uint32_t sum = 0;
    for (std::size_t bin = kBins - 1; bin > 0; --bin) {
      all.add(box[bin]);
      sum += count[bin];
      right[bin] = sum == 0 ? 0.0f : half_area(all) * static_cast<float>(sum);
    }
    all = Aabb();
    sum = 0;
    for (std::size_t bin = 1; bin < kBins; ++bin) {
      all.add(box[bin - 1]);
      sum += count[bin - 1];
      if (sum == 0 || sum == ids.size()) continue;
      const float cost = half_area(all) * static_cast<float>(sum) + right[bin];
      if (cost < best) {
        best = cost;
        best_axis = axis;
        best_bin = bin;
      }
    }
  }
  if (best_bin == 0) return split_median(boxes, ids);
  const auto middle = std::stable_partition(
      ids.begin(), ids.end(), [&](std::uint32_t i) { return bin_of(i, best_axis) < best_bin; });
  return static_cast<std::size_t>(middle - ids.begin());
}

std::vector<std::uint64_t> morton_codes(std::span<const Aabb> boxes, Ids ids) {
  const Aabb bounds = centre_bounds(boxes, ids);
  std::vector<std::uint64_t> codes(boxes.size());
  for (const std::uint32_t i : ids) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double low = static_cast<double>(bounds.lower[axis]);
      const double width = static_cast<double>(bounds.upper[axis]) - low;
      const double at = (static_cast<double>(centre_key(boxes[i], axis)) - low) / width;
      const auto cell = width > 0 ? static_cast<std::uint64_t>(std::min(at * 0x1p21, 0x1p21 - 1))
                                  : std::uint64_t{0};
      for (std::size_t bit = 0; bit < 21; ++bit) {
        codes[i] |= ((cell >> bit) & 1u) << (3 * bit + axis);
      }
    }
  }
  return codes;
}

TreeArrays build_morton(std::span<const Aabb> boxes, std::vector<std::uint32_t> ids) {
  const std::vector<std::uint64_t> codes = morton_codes(boxes, ids);
  std::stable_sort(ids.begin(), ids.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return codes[a] < codes[b]; });
  return top_down(boxes, std::move(ids), [&](Ids part) {
    const std::uint64_t different = codes[part.front()] ^ codes[part.back()];
    if (different == 0) return part.size() / 2;
    const std::uint64_t top = std::bit_floor(different);
    const auto middle = std::partition_point(
        part.begin(), part.end(), [&](std::uint32_t i) { return (codes[i] & top) == 0; });
    return static_cast<std::size_t>(middle - part.begin());
  });
}

/// Positions of object changes nearest to the middle split a node; inside an object its middle.
TreeArrays build_as_modelled(std::span<const Aabb> boxes, std::vector<std::uint32_t> ids,
                             std::span<const std::uint32_t> objects) {
  return top_down(boxes, std::move(ids), [&](Ids part) {
    const std::size_t n = part.size(), middle = n / 2;
    const auto changes = [&](std::size_t k) {
      return k > 0 && k < n && !objects.empty() && objects[part[k - 1]] != objects[part[k]];
    };
    for (std::size_t away = 0; away <= middle + 1; ++away) {
      if (middle >= away && changes(middle - away)) return middle - away;
      if (changes(middle + away)) return middle + away;
    }
    return middle;
  });
}

}  // namespace

std::string method_name(Method method) {
  switch (method) {
    case Method::kSweep:
      return "sweep";
    case Method::kSweepReinsertion:
      return "sweep + reinsertion";
    case Method::kBinned:
      return "binned SAH";
    case Method::kMedianCut:
      return "median cut";
    case Method::kInsertion:
      return "Goldsmith-Salmon insertion";
    case Method::kMorton:
      return "Morton order";
    case Method::kAsModelled:
      return "as modelled";
  }
  return "unknown";
}

std::optional<Hierarchy> build_with(Method method, std::span<const Aabb> boxes,
                                    std::span<const std::uint32_t> objects) {
  if (boxes.empty()) return Hierarchy();
  std::vector<std::uint32_t> ids(boxes.size());
  std::iota(ids.begin(), ids.end(), 0u);
  switch (method) {
    case Method::kSweep:
      return build(boxes, {.reinsertion = false});
    case Method::kSweepReinsertion:
      return build(boxes, {.reinsertion = true});
    case Method::kBinned:
      return HierarchyBuilder::finish(
          top_down(boxes, std::move(ids), [&](Ids part) { return split_binned(boxes, part); }));
    case Method::kMedianCut:
      return HierarchyBuilder::finish(
          top_down(boxes, std::move(ids), [&](Ids part) { return split_median(boxes, part); }));
    case Method::kInsertion: {
      std::optional<TreeArrays> tree = build_by_insertion(boxes);
      if (!tree) return std::nullopt;
      return HierarchyBuilder::finish(std::move(*tree));
    }
    case Method::kMorton:
      return HierarchyBuilder::finish(build_morton(boxes, std::move(ids)));
    case Method::kAsModelled:
      return HierarchyBuilder::finish(build_as_modelled(boxes, std::move(ids), objects));
  }
  return std::nullopt;
}

}  // namespace lightbatch::hierarchy
