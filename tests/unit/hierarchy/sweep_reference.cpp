// G. Mueller, S. Schaefer, D. W. Fellner: A Rapid Clustering Algorithm for Efficient Rendering,
// Eurographics 1999. Primitives are sorted once for each axis by box centre (ties by index); a node
// takes the cheapest of all split positions on all three axes, cost = area * count summed over both
// sides; the two other lists are partitioned stably; down to single primitives.
// Deviations: an explicit stack, ties to the middle, and a depth limit (split_rule.h).

#include "tests/unit/hierarchy/sweep_reference.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

#include "core/hierarchy/split_rule.h"

namespace lightbatch::hierarchy {
namespace {

struct Task {
  std::uint32_t place;
  std::uint32_t begin;
  std::uint32_t end;
  int depth;
};

class ScalarSweep {
 public:
  explicit ScalarSweep(std::span<const Aabb> boxes)
      : boxes_(boxes), tree_(boxes.size()), areas_(boxes.size()), on_left_(boxes.size()) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      order_[axis].resize(boxes.size());
      std::iota(order_[axis].begin(), order_[axis].end(), 0u);
      std::stable_sort(order_[axis].begin(), order_[axis].end(),
                       [&](std::uint32_t a, std::uint32_t b) {
                         return centre_key(boxes[a], axis) < centre_key(boxes[b], axis);
                       });
    }
    spare_.resize(boxes.size());
  }

  TreeArrays run() {
    std::vector<Task> stack{{0, 0, static_cast<std::uint32_t>(boxes_.size()), 0}};
    while (!stack.empty()) {
      const Task task = stack.back();
      stack.pop_back();
      const std::uint32_t n = task.end - task.begin;
      Aabb box;
      for (std::uint32_t k = task.begin; k < task.end; ++k) box.add(boxes_[order_[0][k]]);
      tree_.nodes[task.place] = {{box.lower.x, box.lower.y, box.lower.z},
                                 task.begin,
                                 {box.upper.x, box.upper.y, box.upper.z},
                                 n};
      if (n == 1) {
        tree_.primitives[task.begin] = order_[0][task.begin];
        continue;
      }
      const Split split = best_split(task);
      partition(task, split);
      const std::uint32_t middle = task.begin + split.position;
      stack.push_back({task.place + 2 * split.position, middle, task.end, task.depth + 1});
      stack.push_back({task.place + 1, task.begin, middle, task.depth + 1});
    }
    return std::move(tree_);
  }

 private:
  Split best_split(const Task& task) {
    const std::uint32_t n = task.end - task.begin;
    const PositionRange range = allowed_positions(n, task.depth);
    Split best = Split::middle(n);
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t* list = order_[axis].data() + task.begin;
      Aabb box;
      for (std::uint32_t k = n - 1; k > 0; --k) {
        box.add(boxes_[list[k]]);
        areas_[k] = half_area(box);
      }
      box = Aabb();
      for (std::uint32_t k = 1; k < n; ++k) {
        box.add(boxes_[list[k - 1]]);
        if (k < range.first || k > range.last) continue;
        const float cost =
            half_area(box) * static_cast<float>(k) + areas_[k] * static_cast<float>(n - k);
        best.offer(cost, axis, k, tie_rank(k, n));
      }
    }
    return best;
  }

  void partition(const Task& task, const Split& split) {
    const std::uint32_t middle = task.begin + split.position;
    for (std::uint32_t k = task.begin; k < task.end; ++k) {
      on_left_[order_[split.axis][k]] = k < middle;
    }
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      if (axis == split.axis) continue;
      std::uint32_t left = task.begin;
      std::uint32_t right = 0;
      for (std::uint32_t k = task.begin; k < task.end; ++k) {
        const std::uint32_t primitive = order_[axis][k];
        if (on_left_[primitive] != 0) {
          order_[axis][left++] = primitive;
        } else {
          spare_[right++] = primitive;
        }
      }
      std::copy_n(spare_.begin(), right, order_[axis].begin() + left);
    }
  }

  std::span<const Aabb> boxes_;
  TreeArrays tree_;
  std::array<std::vector<std::uint32_t>, 3> order_;
  std::vector<std::uint32_t> spare_;
  std::vector<float> areas_;
  std::vector<std::uint8_t> on_left_;
};

}  // namespace

TreeArrays sweep_reference(std::span<const Aabb> boxes) { return ScalarSweep(boxes).run(); }

}  // namespace lightbatch::hierarchy
