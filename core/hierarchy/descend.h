#pragma once

#include <cstdint>
#include <limits>

#include "core/hierarchy/hierarchy.h"

namespace lightbatch::hierarchy {

/// Where a random walk down a hierarchy ended, and with which probability.
template <typename Real>
struct Descent {
  Hierarchy::NodeId node = 0;
  Real probability = 0;  // 0: the walk met a node whose children have no weight
  Real random = 0;       // what is left of the random number, in [0, 1)
};

/// Walks from a node to one of at most `primitives`, at each node to a child with probability its
/// share of the two children's weights (>= 0); one random number in [0, 1) serves the whole walk.
template <typename Real, typename Weight>
Descent<Real> descend(const Hierarchy& tree, Hierarchy::NodeId node, Real random, Weight weight,
                      std::uint32_t primitives = 1) {
  constexpr Real kBelowOne = 1 - std::numeric_limits<Real>::epsilon() / 2;
  Real probability = 1;
  while (tree.count(node) > primitives) {
    const Real left = weight(tree.left(node)), right = weight(tree.right(node));
    if (!(left + right > 0)) return {node, 0, 0};
    const Real share = left / (left + right);
    const bool go_left = random < share;
    random = go_left ? random / share : (random - share) / (1 - share);
    if (random > kBelowOne) random = kBelowOne;
    probability *= go_left ? share : 1 - share;
    node = go_left ? tree.left(node) : tree.right(node);
  }
  return {node, probability, random};
}

}  // namespace lightbatch::hierarchy
