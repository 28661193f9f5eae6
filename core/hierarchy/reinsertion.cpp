// J. Bittner, M. Hapala, V. Havran: Fast Insertion-Based Optimization of Bounding Volume
// Hierarchies, CGF 2013; D. Meister, J. Bittner: Parallel Reinsertion for Bounding Volume Hierarchy
// Optimization, CGF 2018. In each round the nodes with the largest boxes look for the place where
// the tree's area shrinks most (branch and bound from their own place upward); moves that do not
// touch one another are made, best first.
// Deviations: searches see the tree as it was at the start of the round, and moves are ordered by
// (gain, slot), so threads do not matter; searches stop after a fixed number of steps.

#include "core/hierarchy/reinsertion.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/base/parallel.h"
#include "core/hierarchy/linked_tree.h"

namespace lightbatch::hierarchy {
namespace {

using Slot = LinkedTree::Slot;
using Box = LinkedTree::Box;

int kRounds = 3;
double kShare = 0.05;  // of all nodes look for a better place in a round
int kSteps = 1000;

struct Move {
  float gain = 0;
  Slot from = 0;
  Slot to = 0;
};

class Search {
 public:
  explicit Search(const LinkedTree& tree) : tree_(tree) {}

  /// The best place for `from`; gain 0 if it is where it should be.
  Move operator()(Slot from) {
    Move best{0, from, 0};
    const Box moved = tree_.box(from);
    const float moved_area = moved.area();
    const Slot home = tree_.parent(from);
    // What taking `from` out saves: all of its parent, and the shrinking of the ancestors so far.
    float saved = tree_.box(home).area();
    Box pivot = tree_.box(from ^ 1u);
    Slot above = home, sibling = from ^ 1u;
    int steps = kSteps;
    while (true) {
      stack_.push_back({saved, sibling});
      while (!stack_.empty()) {
        const Entry top = stack_.back();
        stack_.pop_back();
        if (top.saved - moved_area <= best.gain) continue;
        if (--steps < 0) {
          stack_.clear();
          return best;
        }
        Box merged = tree_.box(top.slot);
        const float own_area = merged.area();
        merged.add(moved);
        const float gain = top.saved - merged.area();
        if (gain > best.gain && top.slot != (from ^ 1u)) best = {gain, from, top.slot};
        if (tree_.is_leaf(top.slot)) continue;
        const float rest = gain + own_area;
        if (rest - moved_area <= best.gain) continue;
        stack_.push_back({rest, tree_.child(top.slot)});
        stack_.push_back({rest, tree_.child(top.slot) + 1});
      }
      if (above != home) {
        pivot.add(tree_.box(sibling));
        saved += tree_.box(above).area() - pivot.area();
      }
      if (above == 0) return best;
      sibling = above ^ 1u;
      above = tree_.parent(above);
    }
  }

 private:
  struct Entry {
    float saved;
    Slot slot;
  };
  const LinkedTree& tree_;
  std::vector<Entry> stack_;
};

/// The nodes with the largest boxes, ties by slot; never the root or its children's places' owner.
std::vector<Slot> candidates(const LinkedTree& tree, std::size_t count) {
  std::vector<Move> all(tree.slot_count() - 2);
  parallel_for(all.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto slot = static_cast<Slot>(i + 2);
      all[i] = {tree.box(slot).area(), slot, 0};
    }
  });
  const auto larger = [](const Move& a, const Move& b) {
    return a.gain > b.gain || (a.gain == b.gain && a.from < b.from);
  };
  count = std::min(count, all.size());
  std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end(),
                   larger);
  std::vector<Slot> result;
  for (std::size_t i = 0; i < count; ++i) result.push_back(all[i].from);
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace

void reinsert(TreeArrays& tree) {
  if (tree.nodes.size() < 7) return;
  LinkedTree linked(tree);
  std::vector<std::uint8_t> touched;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Slot> looking = candidates(
        linked, static_cast<std::size_t>(kShare * static_cast<double>(tree.nodes.size())) + 1);
    std::vector<Move> moves(looking.size());
    parallel_for(looking.size(), 256, [&](std::size_t begin, std::size_t end) {
      Search search(linked);
      for (std::size_t i = begin; i < end; ++i) moves[i] = search(looking[i]);
    });
    std::erase_if(moves, [](const Move& m) { return !(m.gain > 0); });
    std::sort(moves.begin(), moves.end(), [](const Move& a, const Move& b) {
      return a.gain > b.gain || (a.gain == b.gain && a.from < b.from);
    });
    touched.assign(linked.slot_count(), 0);
    for (const Move& m : moves) {
      const Slot involved[] = {m.from, m.from ^ 1u, linked.parent(m.from), m.to,
                               linked.parent(m.to)};
      if (std::any_of(std::begin(involved), std::end(involved),
                      [&](Slot i) { return touched[i] != 0; })) {
        continue;
      }
      for (const Slot i : involved) touched[i] = 1;
      linked.move(m.from, m.to);
    }
  }
  TreeArrays better((tree.nodes.size() + 1) / 2);
  if (linked.write(better)) tree = std::move(better);
}

}  // namespace lightbatch::hierarchy
