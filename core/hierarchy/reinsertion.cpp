// J. Bittner, M. Hapala, V. Havran: Fast Insertion-Based Optimization of Bounding Volume
// Hierarchies, CGF 2013; D. Meister, J. Bittner: Parallel Reinsertion for Bounding Volume Hierarchy
// Optimization, CGF 2018. In each round the nodes with the largest boxes look for the place where
// the tree's area shrinks most (branch and bound from their own place upward); moves that do not
// touch one another are made, best first.
// Deviations: nodes of few primitives that fit into one leaf of a casting tree count as one where
// that costs less, so that large primitives find one another (they would end as a chain of nodes as
// large as the scene otherwise); a node that looked in vain sits out some rounds, so others get a
// turn; searches see the tree as it was at the start of the round, and moves are ordered by (gain,
// slot), so threads do not matter; searches stop after a fixed number of steps; only the top of the
// tree, where nodes are as large as those that look, is linked.

#include "core/hierarchy/reinsertion.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/hierarchy/linked_tree.h"
#include "core/hierarchy/split_rule.h"

namespace lightbatch::hierarchy {
namespace {

using Slot = LinkedTree::Slot;
using Box = LinkedTree::Box;

constexpr int kRounds = 8;
constexpr double kShare = 0.01;    // of all nodes look for a better place in a round
constexpr int kPool = 2;           // times as many, the largest, may be among them
constexpr int kRest = 3;           // rounds that a node sits out after looking in vain
constexpr int kSteps = 30;         // nodes that a search visits at most
constexpr std::uint32_t kFew = 4;  // primitives: nodes up to here look for others to share a leaf

struct Move {
  float gain = 0;
  Slot from = 0;
  Slot to = 0;
};

bool better(const Move& a, const Move& b) {
  return a.gain > b.gain || (a.gain == b.gain && a.from < b.from);
}

class Search {
 public:
  explicit Search(const LinkedTree& tree) : tree_(tree) {}

  /// The best place for `from`; gain 0 if it is where it should be.
  Move operator()(Slot from) {
    best_ = {0, from, 0};
    moved_ = tree_.box(from);
    moved_area_ = moved_.area();
    // With n primitives in `from`, merging saves at most its cost less n - 1 times its area.
    const std::uint32_t n = tree_.count(from);
    merging_ =
        n > kFew
            ? 0
            : std::max(0.0f, tree_.merged_cost(from) - moved_area_ * static_cast<float>(n - 1));
    const float least_cost = moved_area_ - merging_;
    const Slot home = tree_.parent(from);
    // What taking `from` out saves: all of its parent, and the shrinking of the ancestors so far.
    float saved = tree_.box(home).area();
    saved -= tree_.saved_by_merging(from, from ^ 1u, saved);
    Box pivot = tree_.box(from ^ 1u);
    Slot above = home, sibling = from ^ 1u;
    int steps = kSteps;
    while (true) {
      // A place costs at least the area of what moves, less what merging may save, and nothing
      // below is better than that.
      if (saved - least_cost > best_.gain) {
        Box both = tree_.box(sibling);
        const float own_area = both.area();
        both.add(moved_);
        weigh(sibling, saved, both.area(), own_area, sibling != (from ^ 1u));
        while (size_ > 0) {
          const Entry top = stack_[--size_];
          if (top.saved - least_cost <= best_.gain) continue;
          if (--steps < 0) {
            size_ = 0;
            return best_;
          }
          open_pair(top);
        }
      }
      if (above != home) {
        pivot.add(tree_.box(sibling));
        saved += tree_.box(above).area() - pivot.area();
      }
      if (above == 0) return best_;
      sibling = above ^ 1u;
      above = tree_.parent(above);
    }
  }

 private:
  struct Entry {
    float saved;
    Slot pair;
  };

  /// Both children of a node lie side by side: one line of memory, four areas at once.
  void open_pair(const Entry& top) {
    Box first = tree_.box(top.pair), second = tree_.box(top.pair + 1);
    const Box own_first = first, own_second = second;
    first.add(moved_);
    second.add(moved_);
    const LinkedTree::Planes areas = LinkedTree::areas_of(own_first.extent(), own_second.extent(),
                                                          first.extent(), second.extent());
    weigh(top.pair, top.saved, areas[2], areas[0], true);
    weigh(top.pair + 1, top.saved, areas[3], areas[1], true);
  }

  /// Beside `slot`, whose half area is `own_area`, in a node of half area `area`.
  void weigh(Slot slot, float saved, float area, float own_area, bool allowed) {
    float gain = saved - area;
    const float rest = gain + own_area;
    if (merging_ > 0 && gain + merging_ > best_.gain) {
      gain += tree_.saved_by_merging(best_.from, slot, area);
    }
    if (gain > best_.gain && allowed) {
      best_.gain = gain;
      best_.to = slot;
    }
    if (!tree_.is_leaf(slot) && rest + merging_ - moved_area_ > best_.gain) {
      stack_[size_++] = {rest, tree_.child(slot)};
      __builtin_prefetch(tree_.node(tree_.child(slot)));
    }
  }

  const LinkedTree& tree_;
  Move best_;
  Box moved_;
  float moved_area_ = 0;
  float merging_ = 0;                       // may save so much at most
  std::array<Entry, kMaxDepth + 2> stack_;  // one waits on each level
  std::size_t size_ = 0;
};

float area(const TreeNode& n) {
  return half_area(n.upper[0] - n.lower[0], n.upper[1] - n.lower[1], n.upper[2] - n.lower[2]);
}

/// An area that at least `count` nodes reach, and few more: all of one histogram bin are in or out.
float least_of_largest(const TreeNodes& nodes, std::size_t count) {
  constexpr int kShift = 19;
  constexpr std::size_t kBins = std::size_t{1} << (32 - kShift);
  using Histogram = std::vector<std::uint32_t>;
  const Histogram histogram = deterministic_reduce(
      nodes.size(), 1u << 17, Histogram(kBins),
      [&](std::size_t begin, std::size_t end) {
        Histogram own(kBins);
        for (std::size_t i = begin; i < end; ++i) {
          ++own[std::bit_cast<std::uint32_t>(area(nodes[i])) >> kShift];  // not negative
        }
        return own;
      },
      [](Histogram a, const Histogram& b) {
        for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
        return a;
      });
  std::uint32_t limit = kBins;
  for (std::size_t sum = 0; limit > 0 && sum < count;) sum += histogram[--limit];
  return std::bit_cast<float>(limit << kShift);
}

}  // namespace

void reinsert(TreeArrays& tree) {
  if (tree.nodes.size() < 7) return;
  const double nodes = static_cast<double>(tree.nodes.size());
  const auto in_round = static_cast<std::size_t>(kShare * nodes) + 1;
  // A node never fits better inside a subtree smaller than itself than beside it.
  const float least_area = least_of_largest(tree.nodes, kPool * in_round);
  LinkedTree linked(tree, least_area);
  const double cost_before = linked.cost();
  std::vector<Slot> pool;
  for (Slot i = 2; i < linked.slot_count(); ++i) {
    if (linked.box(i).area() >= least_area) pool.push_back(i);
  }
  std::vector<std::uint8_t> touched(linked.slot_count());
  std::vector<std::uint8_t> resting(linked.slot_count());
  for (int round = 0; round < kRounds; ++round) {
    // The largest boxes of the pool, ties by slot.
    std::vector<Move> looking;
    for (const Slot slot : pool) {
      if (resting[slot] <= round) looking.push_back({linked.box(slot).area(), slot, 0});
    }
    const auto count = std::min(in_round, looking.size());
    std::nth_element(looking.begin(), looking.begin() + static_cast<std::ptrdiff_t>(count),
                     looking.end(), better);
    looking.resize(count);
    std::sort(looking.begin(), looking.end(),
              [](const Move& a, const Move& b) { return a.from < b.from; });
    std::vector<Move> moves(looking.size());
    parallel_for(looking.size(), 256, [&](std::size_t begin, std::size_t end) {
      Search search(linked);
      for (std::size_t i = begin; i < end; ++i) moves[i] = search(looking[i].from);
    });
    for (const Move& m : moves) {
      if (!(m.gain > 0)) resting[m.from] = static_cast<std::uint8_t>(round + kRest);
    }
    std::erase_if(moves, [](const Move& m) { return !(m.gain > 0); });
    std::sort(moves.begin(), moves.end(), better);
    std::vector<Slot> to_clear;
    for (const Move& m : moves) {
      const Slot involved[] = {m.from, m.from ^ 1u, linked.parent(m.from), m.to,
                               linked.parent(m.to)};
      if (std::any_of(std::begin(involved), std::end(involved),
                      [&](Slot i) { return touched[i] != 0; })) {
        continue;
      }
      for (const Slot i : involved) {
        touched[i] = 1;
        to_clear.push_back(i);
      }
      linked.move(m.from, m.to);
    }
    for (const Slot i : to_clear) touched[i] = 0;
  }
  if (linked.cost() < cost_before) linked.write(tree);
}

}  // namespace lightbatch::hierarchy
