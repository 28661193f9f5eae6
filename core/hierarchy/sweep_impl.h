// Included once by each sweep_*.cpp with its instruction set switched on, inside an anonymous
// namespace. The full sweep over sorted lists, faster but with the same splits:
// - costs of large nodes are bounded from below, and only what may beat the best is sorted and
//   swept (sweep_bins.h, sweep_doubtful.h, sweep_blocks.h);
// - lists are sorted once a subtree fits the caches (sweep_sorted.h);
// - every node knows its place in the result, so threads cannot change it.

// Each needs those before it.
// clang-format off
#include "core/hierarchy/sweep_vectors.h"
#include "core/hierarchy/sweep_costs.h"
#include "core/hierarchy/sweep_blocks.h"
#include "core/hierarchy/sweep_moves.h"
#include "core/hierarchy/sweep_sorted.h"
#include "core/hierarchy/sweep_doubtful.h"
#include "core/hierarchy/sweep_bins.h"
// clang-format on

constexpr std::uint32_t kSorted = 16384;  // nodes up to here are sorted
constexpr std::uint32_t kSubtrees = 12;   // all threads split nodes down to a twelfth of all

class Sweep {
 public:
  Sweep(std::span<const Aabb> boxes, TreeArrays& tree)
      : boxes_(boxes),
        tree_(tree),
        records_(boxes.size()),
        memory_{records_.data(), tree.nodes.data()} {}

  void run() {
    const auto n = static_cast<std::uint32_t>(boxes_.size());
    const std::uint32_t enough = std::max(kSorted, n / kSubtrees);
    std::vector<Part> open{{make_records(), 0, n, 0, 0, false}};
    std::vector<Part> subtrees;
    BinSplit split(memory_, thread_count());
    while (!open.empty()) {
      const Part part = open.back();
      open.pop_back();
      std::array<Part, 2> children;
      if (part.count <= enough || !split(part, children)) {
        subtrees.push_back(part);
        continue;
      }
      open.insert(open.end(), children.begin(), children.end());
    }
    std::stable_sort(subtrees.begin(), subtrees.end(),
                     [](const Part& a, const Part& b) { return a.count > b.count; });
    parallel_for(subtrees.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) subtree(subtrees[i]);
    });
  }

 private:
  /// Returns the box of all.
  V8f make_records() {
    constexpr std::size_t kGrain = 16384;
    std::vector<Record> chunks((boxes_.size() + kGrain - 1) / kGrain);
    parallel_for(boxes_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      V8f box = empty_box();
      for (std::size_t i = begin; i < end; ++i) {
        records_[i] = Record::of(boxes_[i], static_cast<std::uint32_t>(i));
        box = unite(load_box(&records_[i]), box);
      }
      store_box(&chunks[begin / kGrain], box);
    });
    V8f box = empty_box();
    for (const Record& chunk : chunks) box = unite(load_box(&chunk), box);
    return box;
  }

  void subtree(const Part& root) {
    BinSplit split(memory_, 1);
    NodeBlocks blocks;
    LargeVector<Record> lists;
    std::vector<Part> open{root};
    while (!open.empty()) {
      const Part part = open.back();
      open.pop_back();
      std::array<Part, 2> children;
      if (part.count > kSorted && split(part, children)) {
        open.push_back(children[1]);
        open.push_back(children[0]);
      } else {
        sort_and_sweep(part, lists, blocks);
      }
    }
  }

  void sort_and_sweep(const Part& part, LargeVector<Record>& memory, NodeBlocks& blocks) {
    // Lists start at different places within a page: loads and stores a multiple of 4 KB apart
    // would wait for each other.
    constexpr std::size_t kPage = 4096 / sizeof(Record), kStagger = 26;
    const std::size_t each = (part.count + kPage - 1) / kPage * kPage + kStagger;
    if (memory.size() < 2 * kMargin + 6 * each)
      memory =
          LargeVector<Record>(2 * kMargin + 6 * std::max<std::size_t>(each, kSorted + kStagger));
    SweepLists lists;
    for (std::size_t i = 0; i < 6; ++i) lists[i / 3][i % 3] = memory.data() + kMargin + i * each;
    presort({memory_.records(part), part.count}, lists[0], lists[1]);
    SortedSweep(lists, part.begin, blocks, tree_).run({0, part.count, part.place, part.depth, {}});
  }

  std::span<const Aabb> boxes_;
  TreeArrays& tree_;
  LargeVector<Record> records_;
  PartMemory memory_;
};
