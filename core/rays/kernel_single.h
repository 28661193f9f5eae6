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

/// Children that wait, the nearest of a node last, and lower bounds of their distances.
struct OrderedStack {
  static constexpr std::size_t kSize = kStackSize + kWidth;  // whole vectors are written
  std::uint32_t words[kSize];
  float nears[kSize];
  std::size_t size = 0;

  /// Among those from `base` on, which are in order.
  LB_INLINE void push(std::uint32_t word, float near, std::size_t base) {
    std::size_t k = size++;
    for (; k > base && nears[k - 1] < near; --k) {
      nears[k] = nears[k - 1];
      words[k] = words[k - 1];
    }
    words[k] = word;
    nears[k] = near;
  }
  /// All `count` children that were met.
  LB_INLINE void push_all(const WideNode& node, V8i met, V8f near, int count) {
    // Ordered as integers, the child's place in the last bits; the others come last.
    const V8f positive = max8(near, splat8(0));
    V8i keys;
    std::memcpy(&keys, &positive, sizeof keys);
    keys = sorted_down(((keys & ~7) | V8i{0, 1, 2, 3, 4, 5, 6, 7}) | ~met);
    const V8i distances = keys & ~7;
    permute8(words + size, node.child, keys & 7);
    std::memcpy(nears + size, &distances, sizeof distances);
    size += static_cast<std::size_t>(count);
  }
};

/// The nearest hit so far of one ray.
struct ClosestHit {
  const Ray& ray;
  std::uint32_t exclude;
  HitFilter* filter;
  const BoxRay& r;
  LeafTest triangles;
  Hit best;
  Limits limits;

  LB_INLINE ClosestHit(const Ray& given, const BoxRay& box_ray, std::uint32_t exclude_one,
                       HitFilter* ask)
      : ray(given), exclude(exclude_one), filter(ask), r(box_ray), triangles(box_ray) {
    best.t = ray.t_max;
    limits = {r.lower_limit(ray.t_min), r.upper_limit(ray.t_max), 0, 0};
  }

  LB_INLINE void look_in(const Leaf& leaf) {
    V8f low, high;
    unsigned maybe = triangles(leaf, limits, low, high).maybe;
    for (; maybe != 0; maybe &= maybe - 1) {
      const std::size_t k = lowest(maybe);
      const std::uint32_t id = leaf.id(k) & ~WideTree::kFilteredFlag;
      if (id == exclude) continue;
      const ExactTest::Result result =
          ExactTest(ray.origin, ray.direction)(leaf.corners() + k, leaf.count);
      if (!result.hit || !(result.t > ray.t_min && result.t < ray.t_max)) continue;
      if (!(result.t < best.t || (result.t == best.t && id < best.triangle))) continue;
      const Hit hit{id, result.t, result.u, result.v, result.back};
      if (filter != nullptr && (leaf.id(k) & WideTree::kFilteredFlag) != 0 && !filter->stops(hit)) {
        continue;
      }
      best = hit;
      limits.upper = r.upper_limit(best.t);
    }
  }
};

template <bool kGrids>
LB_INLINE Hit closest_in(const WideTree& tree, const Ray& ray, std::uint32_t exclude,
                         HitFilter* filter) {
  const BoxRay r(tree, ray);
  if (!r.valid) return Hit();
  const BoxTest boxes(r, r.lower_limit(ray.t_min));
  ClosestHit hit(ray, r, exclude, filter);
  OrderedStack stack;
  std::uint32_t word = 0;
  while (true) {
    while (!Child::is_leaf(word)) {
      if constexpr (kGrids) {
        if (Child::is_grid(word)) break;
      }
      const WideNode& node = tree.node(word);
      V8f near;
      const V8i met = boxes(node, splat8(hit.limits.upper), near);
      unsigned mask = mask8(met);
      if (mask == 0) goto pop;
      const std::size_t first = lowest(mask);
      word = node.child[first];
      mask &= mask - 1;
      if (mask == 0) continue;
      if (std::popcount(mask) > 2) {
        const std::size_t base = stack.size;
        stack.push_all(node, met, near, 1 + std::popcount(mask));
        word = stack.words[--stack.size];
        for (std::size_t i = base; i < stack.size; ++i) prefetch(tree, stack.words[i]);
        continue;
      }
      alignas(32) float distance[kWidth];
      std::memcpy(distance, &near, sizeof distance);
      float nearest = distance[first];
      const std::size_t base = stack.size;
      for (; mask != 0; mask &= mask - 1) {
        const std::size_t place = lowest(mask);
        std::uint32_t other = node.child[place];
        float farther = distance[place];
        prefetch(tree, other);
        if (farther < nearest) {
          std::swap(farther, nearest);
          std::swap(other, word);
        }
        stack.push(other, farther, base);
      }
    }
    if constexpr (kGrids) {
      if (Child::is_grid(word)) {
        walk_grid(tree.grid(word), r, r.lower_limit(ray.t_min), hit.limits.upper,
                  [&](std::uint32_t leaf) {
                    hit.look_in(tree.leaf(leaf));
                    return false;
                  });
        goto pop;
      }
    }
    hit.look_in(tree.leaf(word));
  pop:
    do {
      if (stack.size == 0) return hit.best.found() ? hit.best : Hit();
      --stack.size;
      // Distances on the stack are not negative.
    } while (stack.nears[stack.size] > std::max(hit.limits.upper, 0.0f));
    word = stack.words[stack.size];
  }
}

Hit cast_closest(const WideTree& tree, const Ray& ray, std::uint32_t exclude, HitFilter* filter) {
  if (tree.empty) return Hit();
  return tree.grids.empty() ? closest_in<false>(tree, ray, exclude, filter)
                            : closest_in<true>(tree, ray, exclude, filter);
}

/// Whether triangles stop one ray.
template <typename Test>
struct AnyHit {
  const Ray& ray;
  std::uint32_t exclude_a, exclude_b;
  HitFilter* filter;
  Test triangles;
  Limits limits;

  LB_INLINE bool in(const Leaf& leaf) const {
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
  }
  LB_INLINE bool in_grid(const WideTree& tree, std::uint32_t word, const BoxRay& r) const {
    return walk_grid(tree.grid(word), r, limits.lower, limits.upper,
                     [&](std::uint32_t leaf) { return in(tree.leaf(leaf)); });
  }
};

LB_INLINE AnyHit<LeafTest> any_hit(const Ray& ray, const BoxRay& r, std::uint32_t exclude_a,
                                   std::uint32_t exclude_b, HitFilter* filter) {
  return {ray,
          exclude_a,
          exclude_b,
          filter,
          LeafTest(r),
          {r.lower_limit(ray.t_min), r.upper_limit(ray.t_max), r.tight_lower_limit(ray.t_min),
           r.tight_upper_limit(ray.t_max)}};
}

template <bool kGrids>
LB_INLINE bool occluded_in(const WideTree& tree, const Ray& ray, std::uint32_t exclude_a,
                           std::uint32_t exclude_b, HitFilter* filter) {
  const BoxRay r(tree, ray);
  if (!r.valid) return false;
  const BoxTest boxes(r, r.lower_limit(ray.t_min));
  const AnyHit<LeafTest> stopped = any_hit(ray, r, exclude_a, exclude_b, filter);
  const V8f upper = splat8(stopped.limits.upper);
  std::uint32_t stack[kStackSize];
  std::uint32_t* top = stack;
  std::uint32_t word = 0;
  std::uint32_t waiting[2 * kWidth];  // leaves on their way from memory
  std::size_t count = 0;
  while (true) {
    // The next node is chosen before this one's children are known, so that it arrives meanwhile.
    const bool ahead = top != stack;
    const std::uint32_t next = ahead ? *--top : 0;
    const WideNode& node = tree.node(word);
    V8f near;
    unsigned mask = mask8(boxes(node, upper, near));
    const std::size_t before = count;
    for (; mask != 0; mask &= mask - 1) {
      const std::uint32_t child = node.child[lowest(mask)];
      if constexpr (kGrids) {
        if (Child::is_grid(child)) {
          if (stopped.in_grid(tree, child, r)) return true;
          continue;
        }
      }
      prefetch(tree, child);
      if (Child::is_leaf(child)) {
        waiting[count++] = child;
      } else {
        *top++ = child;
      }
    }
    if (before != 0) {
      for (std::size_t i = 0; i < before; ++i) {
        if (stopped.in(tree.leaf(waiting[i]))) return true;
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
    if (stopped.in(tree.leaf(waiting[i]))) return true;
  }
  return false;
}

bool cast_occluded(const WideTree& tree, const Ray& ray, std::uint32_t exclude_a,
                   std::uint32_t exclude_b, HitFilter* filter) {
  if (tree.empty) return false;
  return tree.grids.empty() ? occluded_in<false>(tree, ray, exclude_a, exclude_b, filter)
                            : occluded_in<true>(tree, ray, exclude_a, exclude_b, filter);
}
