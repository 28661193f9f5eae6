// Included once by each sweep_*.cpp with its instruction set switched on, inside an anonymous
// namespace. See sweep_scalar.cpp for the algorithm; this is the same tree, faster:
// - records carry their boxes; each list is partitioned by comparing with the split element;
// - in larger nodes, boxes of aligned blocks bound the cost inside a block from below, and only
//   blocks that may beat the best cost so far are swept. Floating-point operations are monotone,
//   so nothing is missed, ties included;
// - every node knows its place in the result, so threads cannot change it.

#include "core/hierarchy/sweep_costs.h"

#ifdef LB_SWEEP_SMALL
#include "core/hierarchy/sweep_small.h"
constexpr int kSmallDepth = kMaxDepth - 12;  // above here no depth limit touches small subtrees
#endif

constexpr std::uint32_t kParallelNode = 16384;  // larger nodes may be split by all threads
constexpr std::uint32_t kSubtrees = 12;         // down to a twelfth of all primitives

struct Task {
  std::uint32_t begin = 0;
  std::uint32_t count = 0;
  std::uint32_t place = 0;
  int depth = 0;
  std::array<std::uint8_t, 3> side{};  // which buffer, for each axis
};

class Sweep {
 public:
  Sweep(const SweepLists& lists, TreeArrays& tree) : lists_(lists), tree_(tree) {}

  void run() {
    const std::uint32_t enough = std::max(kParallelNode, lists_.count / kSubtrees);
    std::vector<Task> open{{0, lists_.count, 0, 0, {}}};
    std::vector<Task> subtrees;
    NodeBlocks blocks;
    while (!open.empty()) {
      const Task task = open.back();
      open.pop_back();
      if (task.count <= enough) {
        subtrees.push_back(task);
        continue;
      }
      std::array<Task, 2> children;
      split_by_all(task, blocks, children);
      open.insert(open.end(), children.begin(), children.end());
    }
    std::stable_sort(subtrees.begin(), subtrees.end(),
                     [](const Task& a, const Task& b) { return a.count > b.count; });
    parallel_for(subtrees.size(), 1, [&](std::size_t first, std::size_t last) {
      NodeBlocks own;
      for (std::size_t i = first; i < last; ++i) subtree(subtrees[i], own);
    });
  }

 private:
  Record* list(const Task& task, std::size_t axis) const {
    return lists_.buffer[task.side[axis]][axis] + task.begin;
  }
  static std::uint32_t block_size(std::uint32_t n) {
    return n <= kManySmall ? kSmallBlock : kLargeBlock;
  }

  void subtree(const Task& root, NodeBlocks& blocks) {
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
            .write(task.begin, task.place);
        continue;
      }
#endif
      V8f box;
      const Split split =
          task.count <= kWholeSweep ? sweep_whole(task, box) : sweep_blocks(task, blocks, box);
      write_node(task, box);
      std::array<Task, 2> children = children_of(task, split);
      partition(task, split, children);
      stack[size++] = children[1];
      stack[size++] = children[0];
    }
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
    const V8f planes = __builtin_shufflevector(box, -box, 0, 1, 2, 3, 12, 13, 14, 15);
    TreeNode& node = tree_.nodes[task.place];
    store_box(&node, planes);
    node.first = task.begin;
    node.count = task.count;
  }
  void write_leaf(const Record& record, std::uint32_t begin, std::uint32_t place) {
    tree_.primitives[begin] = record.id();
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
        box =
            sweep_inside(list(task, axis), n, 0, empty_box(), empty_box(), {n, axis, range}, best);
      }
      return best;
    }
    // All costs first, then the least, then who has it: no branch depends on single costs.
    V4f cost[kWholeSweep / 4 + 1][3];
    V4f least = infinite4();
    box = whole_costs({list(task, 0), list(task, 1), list(task, 2)}, n, cost, least);
    best.cost = least_of(least);
    if (!(best.cost < std::numeric_limits<float>::infinity())) return Split::middle(n);
    best.rank = n;
    for (std::uint32_t j = 1; j < n; j += 4) {
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        unsigned mask = mask4(cost[j / 4][axis] == best.cost);
        for (; mask != 0; mask &= mask - 1) {
          const std::uint32_t k = j + static_cast<std::uint32_t>(std::countr_zero(mask));
          best.offer(best.cost, axis, k, tie_rank(k, n));
        }
      }
    }
    return best;
  }

  static void box_blocks(const Record* r, std::uint32_t n, std::uint32_t size, std::size_t first,
                         std::size_t last, Blocks& blocks) {
    for (std::size_t b = first; b < last; ++b) {
      const std::size_t begin = b * size, end = std::min<std::size_t>(n, begin + size);
      V8f even = load_box(r + begin), odd = load_box(r + end - 1);
      std::size_t k = begin + 1;
      for (; k + 1 < end; k += 2) {
        even = unite(load_box(r + k), even);
        odd = unite(load_box(r + k + 1), odd);
      }
      store_box(&blocks.boxes[b], unite(even, odd));
    }
  }

  /// Prefixes and suffixes of the blocks; offers the positions between blocks.
  static void scan_blocks(std::size_t count, std::uint32_t size, Blocks& blocks,
                          const SweepContext& context, Split& best) {
    V8f box = empty_box();
    for (std::size_t b = 0; b < count; ++b) {
      store_box(&blocks.prefix[b], box);
      blocks.prefix_area[b] = b == 0 ? 0.0f : area_of(box);
      box = unite(load_box(&blocks.boxes[b]), box);
    }
    store_box(&blocks.prefix[count], box);
    box = empty_box();
    store_box(&blocks.suffix[count], box);
    blocks.suffix_area[count] = 0;
    for (std::size_t b = count; b-- > 0;) {
      box = unite(load_box(&blocks.boxes[b]), box);
      store_box(&blocks.suffix[b], box);
      blocks.suffix_area[b] = area_of(box);
    }
    for (std::size_t b = 1; b < count; ++b) {
      const auto k = static_cast<std::uint32_t>(b) * size;
      if (k < context.range.first || k > context.range.last) continue;
      best.offer(blocks.prefix_area[b] * static_cast<float>(k) +
                     blocks.suffix_area[b] * static_cast<float>(context.n - k),
                 context.axis, k, tie_rank(k, context.n));
    }
  }

  /// Whether no position inside the block can be as good as the best.
  static bool ruled_out(std::size_t b, std::uint32_t begin, std::uint32_t end, const Blocks& blocks,
                        std::uint32_t n, const Split& best) {
    const float bound = blocks.prefix_area[b] * static_cast<float>(begin + 1) +
                        blocks.suffix_area[b + 1] * static_cast<float>(n - end + 1);
    return bound > best.cost;
  }

  Split sweep_blocks(const Task& task, NodeBlocks& blocks, V8f& box) const {
    const std::uint32_t n = task.count, size = block_size(n);
    const std::size_t count = (n + size - 1) / size;
    const PositionRange range = allowed_positions(n, task.depth);
    Split best = Split::middle(n);
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      if (blocks[axis].boxes.size() < count) blocks[axis].resize(count);
      box_blocks(list(task, axis), n, size, 0, count, blocks[axis]);
      scan_blocks(count, size, blocks[axis], {n, axis, range}, best);
    }
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      for (std::size_t b = 0; b < count; ++b) sweep_block(task, range, axis, b, blocks[axis], best);
    }
    box = load_box(&blocks[0].suffix[0]);
    return best;
  }

  void sweep_block(const Task& task, const PositionRange& range, std::uint32_t axis, std::size_t b,
                   const Blocks& blocks, Split& best) const {
    const std::uint32_t n = task.count, size = block_size(n);
    const std::uint32_t begin = static_cast<std::uint32_t>(b) * size,
                        end = std::min(n, begin + size);
    if (ruled_out(b, begin, end, blocks, n, best)) return;
    sweep_inside(list(task, axis) + begin, end - begin, begin, load_box(&blocks.prefix[b]),
                 load_box(&blocks.suffix[b + 1]), {n, axis, range}, best);
  }

  /// Moves r[0, count) to the two outputs, stably, without a branch on the outcome: a record goes
  /// to the left if it comes before `edge`, the first one on the right, in the order of the axis.
  template <bool kTies>
  static void distribute(const Record* r, std::size_t count, const Record& edge, std::uint32_t axis,
                         Record* left, Record* right) {
    const float limit = edge.key(axis);
    auto to = reinterpret_cast<std::uintptr_t>(left);
    auto other = reinterpret_cast<std::uintptr_t>(right);
    for (std::size_t k = 0; k < count; ++k) {
      const float key = r[k].key(axis);
      bool to_left = key < limit;
      if constexpr (kTies) to_left |= (key == limit) & (r[k].tagged_id < edge.tagged_id);
      const std::uintptr_t mask = std::uintptr_t{0} - static_cast<std::uintptr_t>(to_left);
      const std::uintptr_t target = other ^ ((to ^ other) & mask);
      store_box(reinterpret_cast<Record*>(target), load_box(r + k));
      to += sizeof(Record) & mask;
      other += sizeof(Record) & ~mask;
    }
  }
  template <bool kTies>
  static std::uint32_t count_left(const Record* r, std::size_t count, const Record& edge,
                                  std::uint32_t axis) {
    const float limit = edge.key(axis);
    std::uint32_t sum = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const float key = r[k].key(axis);
      bool to_left = key < limit;
      if constexpr (kTies) to_left |= (key == limit) & (r[k].tagged_id < edge.tagged_id);
      sum += to_left;
    }
    return sum;
  }

  /// Two lists at once, so that the processor has more to do at a time.
  template <bool kTies>
  static void distribute_two(std::array<Record*, 2> lists, std::array<Record*, 2> right_lists,
                             std::size_t count, const Record& edge, std::uint32_t axis) {
    const float limit = edge.key(axis);
    const Record* a = lists[0];
    const Record* b = lists[1];
    auto to_a = reinterpret_cast<std::uintptr_t>(lists[0]);
    auto to_b = reinterpret_cast<std::uintptr_t>(lists[1]);
    auto other_a = reinterpret_cast<std::uintptr_t>(right_lists[0]);
    auto other_b = reinterpret_cast<std::uintptr_t>(right_lists[1]);
    for (std::size_t k = 0; k < count; ++k) {
      const float key_a = a[k].key(axis), key_b = b[k].key(axis);
      bool left_a = key_a < limit, left_b = key_b < limit;
      if constexpr (kTies) {
        left_a |= (key_a == limit) & (a[k].tagged_id < edge.tagged_id);
        left_b |= (key_b == limit) & (b[k].tagged_id < edge.tagged_id);
      }
      const std::uintptr_t mask_a = std::uintptr_t{0} - static_cast<std::uintptr_t>(left_a);
      const std::uintptr_t mask_b = std::uintptr_t{0} - static_cast<std::uintptr_t>(left_b);
      store_box(reinterpret_cast<Record*>(other_a ^ ((to_a ^ other_a) & mask_a)), load_box(a + k));
      store_box(reinterpret_cast<Record*>(other_b ^ ((to_b ^ other_b) & mask_b)), load_box(b + k));
      to_a += sizeof(Record) & mask_a;
      to_b += sizeof(Record) & mask_b;
      other_a += sizeof(Record) & ~mask_a;
      other_b += sizeof(Record) & ~mask_b;
    }
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
      distribute_two<true>(lists, right, task.count, edge, split.axis);
    } else {
      distribute_two<false>(lists, right, task.count, edge, split.axis);
    }
  }

  /// One node by all threads: work cut into chunks of a fixed size, both sides moved.
  void split_by_all(const Task& task, NodeBlocks& blocks, std::array<Task, 2>& children) {
    const std::uint32_t n = task.count, size = block_size(n);
    const std::size_t count = (n + size - 1) / size;
    const PositionRange range = allowed_positions(n, task.depth);
    constexpr std::size_t kChunk = 4096;  // records
    const std::size_t chunks = (n + kChunk - 1) / kChunk;
    for (Blocks& b : blocks) {
      if (b.boxes.size() < count) b.resize(count);
    }
    parallel_for(3 * chunks, 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const std::size_t axis = i / chunks, begin = i % chunks * (kChunk / size);
        box_blocks(list(task, axis), n, size, begin, std::min(count, begin + kChunk / size),
                   blocks[axis]);
      }
    });
    std::array<Split, 3> bests;
    parallel_for(3, 1, [&](std::size_t axis, std::size_t) {
      bests[axis] = Split::middle(n);
      scan_blocks(count, size, blocks[axis], {n, static_cast<std::uint32_t>(axis), range},
                  bests[axis]);
    });
    Split best = Split::middle(n);
    const auto merge = [](Split a, const Split& b) {
      if (b.cost < std::numeric_limits<float>::infinity()) {
        a.offer(b.cost, b.axis, b.position, b.rank);
      }
      return a;
    };
    for (const Split& other : bests) best = merge(best, other);
    best = deterministic_reduce(
        3 * chunks, 1, best,
        [&](std::size_t i, std::size_t) {
          Split own = best;
          const std::size_t axis = i / chunks, begin = i % chunks * (kChunk / size);
          for (std::size_t b = begin; b < std::min(count, begin + kChunk / size); ++b) {
            sweep_block(task, range, static_cast<std::uint32_t>(axis), b, blocks[axis], own);
          }
          return own;
        },
        merge);
    write_node(task, load_box(&blocks[0].suffix[0]));
    children = children_of(task, best);
    const Record* by = list(task, best.axis) + best.position;
    const Record edge = *by;
    const bool ties = by[-1].key(best.axis) == edge.key(best.axis);
    std::vector<std::uint32_t> lefts(3 * chunks + 1, 0);
    const auto each_chunk = [&](auto body) {
      parallel_for(3 * chunks, 1, [&](std::size_t i, std::size_t) {
        const std::size_t axis = i / chunks, begin = i % chunks * kChunk;
        if (axis == best.axis) return;
        body(i, list(task, axis), begin, std::min<std::size_t>(n, begin + kChunk));
      });
    };
    each_chunk([&](std::size_t i, const Record* r, std::size_t begin, std::size_t end) {
      lefts[i] = ties ? count_left<true>(r + begin, end - begin, edge, best.axis)
                      : count_left<false>(r + begin, end - begin, edge, best.axis);
    });
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint32_t sum = 0;
      for (std::size_t i = axis * chunks; i < (axis + 1) * chunks; ++i) {
        sum += std::exchange(lefts[i], sum);
      }
      if (axis == best.axis) continue;
      for (Task& child : children) child.side[axis] ^= 1u;
    }
    each_chunk([&](std::size_t i, const Record* r, std::size_t begin, std::size_t end) {
      const std::size_t axis = i / chunks;
      Record* left = lists_.buffer[task.side[axis] ^ 1u][axis] + task.begin + lefts[i];
      Record* right = lists_.buffer[task.side[axis] ^ 1u][axis] + task.begin + best.position +
                      (begin - lefts[i]);
      if (ties) {
        distribute<true>(r + begin, end - begin, edge, best.axis, left, right);
      } else {
        distribute<false>(r + begin, end - begin, edge, best.axis, left, right);
      }
    });
  }

  const SweepLists& lists_;
  TreeArrays& tree_;
};
