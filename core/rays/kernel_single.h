// Single rays over the 8-wide tree; included by kernel_impl.h only.

/// Bounded by the depth of the binary tree: every wide level leaves at most 7 children waiting.
constexpr std::size_t kStackSize = (kWidth - 1) * (hierarchy::kMaxDepth + 1) + 1;

LB_INLINE void prefetch(const WideTree& tree, std::uint32_t word) {
  const std::byte* p = tree.at(word);
  __builtin_prefetch(p);
  __builtin_prefetch(p + 64);
  __builtin_prefetch(p + 128);
  __builtin_prefetch(p + 192);
}

struct Entry {
  std::uint32_t word;
  float near;
};

Hit cast_closest(const WideTree& tree, const Ray& ray, std::uint32_t exclude, HitFilter* filter) {
  if (tree.empty) return Hit();
  const BoxRay r(tree, ray);
  if (!r.valid) return Hit();
  const BoxTest boxes(r, r.lower_limit(ray.t_min));
  const LeafTest triangles(r);
  std::optional<ExactTest> exact;
  Hit best;
  best.t = ray.t_max;
  Limits limits{r.lower_limit(ray.t_min), r.upper_limit(ray.t_max), 0, 0};
  V8f upper = splat8(limits.upper);
  Entry stack[kStackSize];
  Entry* top = stack;
  std::uint32_t word = 0;
  while (true) {
    while (!Child::is_leaf(word)) {
      const WideNode& node = tree.node(word);
      V8f near;
      unsigned mask = boxes(node, upper, near);
      if (mask == 0) goto pop;
      const std::size_t first = lowest(mask);
      word = node.child[first];
      mask &= mask - 1;
      if (mask == 0) continue;
      alignas(32) float distance[kWidth];
      std::memcpy(distance, &near, sizeof distance);
      float nearest = distance[first];
      const Entry* const base = top;
      for (; mask != 0; mask &= mask - 1) {
        const std::size_t place = lowest(mask);
        Entry entry{node.child[place], distance[place]};
        prefetch(tree, entry.word);
        if (entry.near < nearest) {
          std::swap(entry.near, nearest);
          std::swap(entry.word, word);
        }
        Entry* k = top++;  // nearest on top
        for (; k > base && k[-1].near < entry.near; --k) *k = k[-1];
        *k = entry;
      }
    }
    {
      const Leaf leaf = tree.leaf(word);
      V8f low, high;
      unsigned maybe = triangles(leaf, limits, low, high).maybe;
      for (; maybe != 0; maybe &= maybe - 1) {
        const std::size_t k = lowest(maybe);
        const std::uint32_t id = leaf.id(k) & ~WideTree::kFilteredFlag;
        if (id == exclude) continue;
        if (!exact) exact.emplace(ray.origin, ray.direction);
        const ExactTest::Result result = (*exact)(leaf.corners() + k, leaf.count);
        if (!result.hit || !(result.t > ray.t_min && result.t < ray.t_max)) continue;
        if (!(result.t < best.t || (result.t == best.t && id < best.triangle))) continue;
        const Hit hit{id, result.t, result.u, result.v, result.back};
        if (filter != nullptr && (leaf.id(k) & WideTree::kFilteredFlag) != 0 &&
            !filter->stops(hit)) {
          continue;
        }
        best = hit;
        limits.upper = r.upper_limit(best.t);
        upper = splat8(limits.upper);
      }
    }
  pop:
    do {
      if (top == stack) return best.found() ? best : Hit();
      --top;
    } while (top->near > limits.upper);
    word = top->word;
  }
}

bool cast_occluded(const WideTree& tree, const Ray& ray, std::uint32_t exclude_a,
                   std::uint32_t exclude_b, HitFilter* filter) {
  if (tree.empty) return false;
  const BoxRay r(tree, ray);
  if (!r.valid) return false;
  const BoxTest boxes(r, r.lower_limit(ray.t_min));
  const LeafTest triangles(r);
  const Limits limits{r.lower_limit(ray.t_min), r.upper_limit(ray.t_max),
                      r.tight_lower_limit(ray.t_min), r.tight_upper_limit(ray.t_max)};
  const V8f upper = splat8(limits.upper);
  // Whether a triangle of the leaf stops the ray.
  const auto stopped_in = [&](const Leaf& leaf) LB_LAMBDA_INLINE {
    V8f low, high;
    const LeafMasks masks = triangles(leaf, limits, low, high);
    for (unsigned maybe = masks.maybe; maybe != 0; maybe &= maybe - 1) {
      const std::size_t k = lowest(maybe);
      const std::uint32_t id = leaf.id(k) & ~WideTree::kFilteredFlag;
      if (id == exclude_a || id == exclude_b) continue;
      const bool ask = filter != nullptr && (leaf.id(k) & WideTree::kFilteredFlag) != 0;
      if (ask || ((masks.certain >> k) & 1u) == 0) {
        const ExactTest::Result result =
            ExactTest(ray.origin, ray.direction)(leaf.corners() + k, leaf.count);
        if (!result.hit || !(result.t > ray.t_min && result.t < ray.t_max)) continue;
        if (ask && !filter->stops({id, result.t, result.u, result.v, result.back})) continue;
      }
      return true;
    }
    return false;
  };
  std::uint32_t stack[kStackSize];
  std::uint32_t* top = stack;
  std::uint32_t word = 0;
  std::uint32_t waiting[2 * kWidth];  // leaves on their way from memory
  std::size_t count = 0;
  while (true) {
    // The next node is chosen before this one's children are known, so that it arrives meanwhile.
    const bool ahead = tree.large && top != stack;
    const std::uint32_t next = ahead ? *--top : 0;
    const WideNode& node = tree.node(word);
    V8f near;
    unsigned mask = boxes(node, upper, near);
    const std::size_t before = count;
    for (; mask != 0; mask &= mask - 1) {
      const std::uint32_t child = node.child[lowest(mask)];
      prefetch(tree, child);
      if (Child::is_leaf(child)) {
        waiting[count++] = child;
      } else {
        *top++ = child;
      }
    }
    if (before != 0) {
      for (std::size_t i = 0; i < before; ++i) {
        if (stopped_in(tree.leaf(waiting[i]))) return true;
      }
      count -= before;
      for (std::size_t i = 0; i < count; ++i) waiting[i] = waiting[i + before];
    }
    if (ahead) {
      word = next;
      continue;
    }
    if (top == stack) break;
    word = *--top;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (stopped_in(tree.leaf(waiting[i]))) return true;
  }
  return false;
}
