// Shaft culling of the tree; included by kernel_impl.h only.

/// Boxes and references waiting to be packed into nodes.
struct Candidates {
  float lower[3][Shaft::kMost + kWidth];
  float upper[3][Shaft::kMost + kWidth];
  std::uint32_t child[Shaft::kMost + kWidth];
  std::size_t count = 0;
};

/// Adds the children of a node that may reach into the shaft.
LB_INLINE void add_children(const Shaft& shaft, const WideNode& node, Candidates& out) {
  V8i keep{-1, -1, -1, -1, -1, -1, -1, -1};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    keep &= load8(node.lower[axis]) <= splat8(shaft.bounds.upper[axis]);
    keep &= load8(node.upper[axis]) >= splat8(shaft.bounds.lower[axis]);
  }
  for (std::size_t i = 0; i < shaft.plane_count; ++i) {
    // The corner of the box deepest inside the plane.
    const Shaft::Plane& plane = shaft.planes[i];
    const float* p = plane.normal[0] > 0 ? node.lower[plane.axis[0]] : node.upper[plane.axis[0]];
    const float* q = plane.normal[1] > 0 ? node.lower[plane.axis[1]] : node.upper[plane.axis[1]];
    keep &= load8(p) * splat8(plane.normal[0]) + load8(q) * splat8(plane.normal[1]) <=
            splat8(plane.limit);
  }
  for (unsigned mask = mask8(keep); mask != 0; mask &= mask - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(mask));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out.lower[axis][out.count] = node.lower[axis][k];
      out.upper[axis][out.count] = node.upper[axis][k];
    }
    out.child[out.count++] = node.child[k];
  }
}

std::size_t gather_candidates(const WideTree& tree, const Shaft& shaft, WideNode* packs) {
  if (tree.empty) return 0;
  Candidates found;
  add_children(shaft, tree.node(0), found);
  // Breadth first; an expanded node's place goes to the last candidate.
  for (std::size_t i = 0; i < found.count;) {
    if (found.count > Shaft::kMost) return kTooMany;
    const std::uint32_t word = found.child[i];
    if (Child::is_leaf(word)) {
      ++i;
      continue;
    }
    const std::size_t last = --found.count;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      found.lower[axis][i] = found.lower[axis][last];
      found.upper[axis][i] = found.upper[axis][last];
    }
    found.child[i] = found.child[last];
    add_children(shaft, tree.node(word), found);
  }
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const std::size_t count = (found.count + kWidth - 1) / kWidth;
  for (std::size_t k = 0; k < count * kWidth; ++k) {
    WideNode& pack = packs[k / kWidth];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      pack.lower[axis][k % kWidth] = k < found.count ? found.lower[axis][k] : kInf;
      pack.upper[axis][k % kWidth] = k < found.count ? found.upper[axis][k] : -kInf;
    }
    pack.child[k % kWidth] = k < found.count ? found.child[k] : 0;
  }
  return count;
}
