// A subtree by sorted lists; included by sweep_impl.h only. Records carry their boxes; each list is
// partitioned by comparing with the split element.

#ifdef LB_SWEEP_SMALL
#include "core/hierarchy/sweep_small.h"
constexpr int kSmallDepth = kMaxDepth - 12;  // above here no depth limit touches small subtrees
#endif

/// The three sorted lists, twice: every node keeps, for each axis, which of the two its part is in.
using SweepLists = std::array<std::array<Record*, 3>, 2>;

/// Part of the lists, and where its subtree goes.
struct Task {
  std::uint32_t begin = 0;
  std::uint32_t count = 0;
  std::uint32_t place = 0;
  int depth = 0;
  std::array<std::uint8_t, 3> side{};  // which buffer, for each axis
};

class SortedSweep {
 public:
  /// Leaf k of the lists is leaf first + k of the tree.
  SortedSweep(const SweepLists& lists, std::uint32_t first, NodeBlocks& blocks, TreeArrays& tree)
      : lists_(lists), first_(first), blocks_(blocks), tree_(tree) {}

  void run(const Task& root) {
    std::array<Task, kMaxDepth + 2> stack;
    std::size_t size = 0;
    stack[size++] = root;
    while (size > 0) {
      const Task task = stack[--size];
      if (task.count <= 2) {
        write_few(task);
        continue;
      }
#ifdef LB_SWEEP_SMALL
      if (task.count <= kSmallTree && task.depth < kSmallDepth) {
        SmallTree({list(task, 0), list(task, 1), list(task, 2)}, task.count, tree_)
            .write(first_ + task.begin, task.place);
        continue;
      }
#endif
      V8f box;
      const Split split =
          task.count <= kWholeSweep ? sweep_whole(task, box) : sweep_large(task, box);
      write_node(task, box);
      std::array<Task, 2> children = children_of(task, split);
      partition(task, split, children);
      stack[size++] = children[1];
      stack[size++] = children[0];
    }
  }

 private:
  Record* list(const Task& task, std::size_t axis) const {
    return lists_[task.side[axis]][axis] + task.begin;
  }

  static std::array<Task, 2> children_of(const Task& task, const Split& split) {
    std::array<Task, 2> children{task, task};
    children[0].count = split.position;
    children[0].place = task.place + 1;
    children[1].begin += split.position;
    children[1].count -= split.position;
    children[1].place = task.place + 2 * split.position;
    for (Task& child : children) ++child.depth;
    return children;
  }

  void write_node(const Task& task, V8f box) {
    write_box(tree_.nodes[task.place], box, first_ + task.begin, task.count);
  }
  void write_leaf(const Record& record, std::uint32_t begin, std::uint32_t place) {
    tree_.primitives[first_ + begin] = record.id();
    write_node({begin, 1, place, 0, {}}, load_box(&record));
  }
  void write_few(const Task& task) {
    const Record* r = list(task, 0);
    if (task.count == 1) {
      write_leaf(r[0], task.begin, task.place);
      return;
    }
    write_node(task, unite(load_box(r), load_box(r + 1)));
    write_leaf(r[0], task.begin, task.place + 1);
    write_leaf(r[1], task.begin + 1, task.place + 2);
  }

  Split sweep_whole(const Task& task, V8f& box) const {
    const std::uint32_t n = task.count;
    const PositionRange range = allowed_positions(n, task.depth);
    Split best = Split::middle(n);
    if (range.first > 1) {  // so deep that not every position is allowed
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        sweep_inside(list(task, axis), n, 0, empty_box(), empty_box(), {n, axis, range}, best);
      }
      box = box_of(list(task, 0), n);
      return best;
    }
    // All costs first, then the least, then who has it: no branch depends on single costs.
    return cheapest({list(task, 0), list(task, 1), list(task, 2)}, n, box);
  }

  Split sweep_large(const Task& task, V8f& box) {
    const std::uint32_t n = task.count;
    const PositionRange range = allowed_positions(n, task.depth);
    Split best = Split::middle(n);
    std::size_t count = 0;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      count = box_blocks(list(task, axis), n, 0, blocks_[axis]);
      scan_blocks(count, empty_box(), empty_box(), blocks_[axis], {n, axis, range}, best);
    }
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      sweep_blocks(list(task, axis), count, blocks_[axis], {n, axis, range}, best);
    }
    box = load_box(&blocks_[0].suffix[0]);
    return best;
  }

  /// Left in place, right into the other buffer.
  void partition(const Task& task, const Split& split, std::array<Task, 2>& children) const {
    const Record* by = list(task, split.axis) + split.position;
    const Record edge = *by;
    std::array<Record*, 2> lists, right;
    for (std::size_t i = 0; i < 2; ++i) {
      const std::size_t axis = (split.axis + 1 + i) % 3;
      children[1].side[axis] ^= 1u;
      lists[i] = list(task, axis);
      right[i] = list(children[1], axis);
    }
    if (by[-1].key(split.axis) == edge.key(split.axis)) {
      distribute_two<true>(lists, right, task.count, children[1].count, edge, split.axis);
    } else {
      distribute_two<false>(lists, right, task.count, children[1].count, edge, split.axis);
    }
  }

  const SweepLists& lists_;
  std::uint32_t first_;
  NodeBlocks& blocks_;
  TreeArrays& tree_;
};
