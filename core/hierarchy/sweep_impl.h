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
constexpr std::uint32_t kShares = 16;     // a thread's; what is smaller stays with one thread

/// What one thread does with nodes of its own.
class Worker {
 public:
  Worker(const PartMemory& memory, TreeArrays& tree)
      : memory_(memory), tree_(&tree), split_(memory, 1) {}

  /// Appends the children, the left one last; false, and nothing done, if bins tell too little.
  bool split(const Part& part, std::vector<Part>& children) {
    std::array<Part, 2> both;
    if (!split_(part, both)) return false;
    children.push_back(both[1]);
    children.push_back(both[0]);
    return true;
  }

  void subtree(const Part& root) {
    std::vector<Part> open{root};
    while (!open.empty()) {
      const Part part = open.back();
      open.pop_back();
      if (part.count <= kSorted || !split(part, open)) sort_and_sweep(part);
    }
  }

 private:
  void sort_and_sweep(const Part& part) {
    // Lists start at different places within a page: loads and stores a multiple of 4 KB apart
    // would wait for each other.
    constexpr std::size_t kPage = 4096 / sizeof(Record), kStagger = 26;
    constexpr std::size_t kHugePages = (std::size_t{4} << 20) / sizeof(Record);
    const std::size_t each = (part.count + kPage - 1) / kPage * kPage + kStagger;
    // Whole huge pages, where they are taken many times.
    const std::size_t least = tree_->primitives.size() > kSorted ? kHugePages : 0;
    LargeVector<Record> memory(std::max(least, 2 * kMargin + 6 * each));
    SweepLists lists;
    for (std::size_t i = 0; i < 6; ++i) lists[i / 3][i % 3] = memory.data() + kMargin + i * each;
    presort({memory_.records(part), part.count}, lists[0], lists[1]);
    SortedSweep(lists, part.begin, blocks_, *tree_)
        .run({0, part.count, part.place, part.depth, {}});
  }

  PartMemory memory_;
  TreeArrays* tree_;
  BinSplit split_;
  NodeBlocks blocks_;
};

class Sweep {
 public:
  Sweep(std::span<const Aabb> boxes, TreeArrays& tree)
      : boxes_(boxes),
        tree_(tree),
        records_(boxes.size()),
        memory_{records_.data(), tree.nodes.data()} {}

  void run() {
    const auto n = static_cast<std::uint32_t>(boxes_.size());
    const auto threads = static_cast<std::uint32_t>(thread_count());
    std::vector<Part> open{{make_records(), 0, n, 0, 0, false}};
    // All threads share the split of a node that holds most of what there is to do.
    BinSplit split(memory_, thread_count());
    std::array<Part, 2> children;
    while (threads > 1 && open.front().count > std::max(kSorted, n / threads / 2 * 3) &&
           split(open.front(), children)) {
      open.front() = children[0];
      open.push_back(children[1]);
      std::iter_swap(open.begin(), std::max_element(open.begin(), open.end()));
    }
    const std::uint32_t enough = threads > 1 ? std::max(kSorted, n / (threads * kShares)) : n;
    parallel_tasks(std::move(open), [&] {
      return
          [&, worker = Worker(memory_, tree_)](const Part& part, std::vector<Part>& more) mutable {
            if (part.count <= enough || !worker.split(part, more)) worker.subtree(part);
          };
    });
  }

 private:
  /// Record::of in registers: what is written in pieces cannot be read back whole at once.
  static LB_INLINE V8f make_record(const Aabb& box, std::uint32_t id) {
    static_assert(sizeof(Aabb) == 6 * sizeof(float));
    const auto* const planes = reinterpret_cast<const char*>(&box);
    V4f low, high;  // high: from the last lower plane
    std::memcpy(&low, planes, sizeof low);
    std::memcpy(&high, planes + 2 * sizeof(float), sizeof high);
    low[3] = std::bit_cast<float>(id | Record::kTag);
    high = -high;
    high[0] = 1.0f;
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 5, 6, 7, 4);
  }

  /// Returns the box of all.
  Record make_records() {
    constexpr std::size_t kGrain = 16384;
    std::vector<Record> chunks((boxes_.size() + kGrain - 1) / kGrain);
    parallel_for(boxes_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      V8f box = empty_box();
      for (std::size_t i = begin; i < end; ++i) {
        const V8f record = make_record(boxes_[i], static_cast<std::uint32_t>(i));
        store_box(&records_[i], record);
        box = unite(record, box);
      }
      store_box(&chunks[begin / kGrain], box);
    });
    V8f box = empty_box();
    for (const Record& chunk : chunks) box = unite(load_box(&chunk), box);
    Record result;
    store_box(&result, box);
    return result;
  }

  std::span<const Aabb> boxes_;
  TreeArrays& tree_;
  LargeVector<Record> records_;
  PartMemory memory_;
};
