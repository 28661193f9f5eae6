// Casting loops over the 8-wide tree; included once by each kernel_*.cpp with its instruction set
// switched on, inside an anonymous namespace.
//
// Boxes: slab test with all rounding errors folded into the two origins of each axis (near planes
// see the origin moved one way, far planes the other, by more than any rounding of coordinates,
// inverses and products), after the idea of T. Ize, Robust BVH Ray Traversal, JCGT 2(2), 2013.
// Boxes so gain thickness: flat ones and axis-parallel rays need no special case.
// Triangles: Woop's test in float, eight at once, with a bound on its error; only triangles that it
// cannot rule out go to ExactTest.

using V8f = float __attribute__((vector_size(32)));
using V8i = std::int32_t __attribute__((vector_size(32)));

#define LB_INLINE inline __attribute__((always_inline))

LB_INLINE V8f load8(const float* p) {
  V8f v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
LB_INLINE V8f splat8(float x) { return V8f{x, x, x, x, x, x, x, x}; }
/// The second argument where either is NaN.
LB_INLINE V8f max8(V8f a, V8f b) { return a > b ? a : b; }
LB_INLINE V8f min8(V8f a, V8f b) { return a < b ? a : b; }
LB_INLINE V8f abs8(V8f a) {
  V8i bits;
  std::memcpy(&bits, &a, sizeof bits);
  bits &= 0x7fffffff;
  std::memcpy(&a, &bits, sizeof a);
  return a;
}
#ifdef LB_KERNEL_AVX2
LB_INLINE unsigned mask8(V8i v) {
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(v)));
}
LB_INLINE V8f madd8(V8f a, V8f b, V8f c) { return _mm256_fmadd_ps(a, b, c); }
#else
LB_INLINE unsigned mask8(V8i v) {
  unsigned mask = 0;
  for (unsigned i = 0; i < 8; ++i) mask |= v[i] < 0 ? 1u << i : 0u;
  return mask;
}
LB_INLINE V8f madd8(V8f a, V8f b, V8f c) { return a * b + c; }
#endif

/// A ray made ready for boxes and triangles. Distances inside the traversal are t / scale, so that
/// the scaled direction has its largest component in [0.5, 1) (barring extreme directions).
struct BoxRay {
  bool valid = false;
  float scale = 1;
  float inverse_scale = 1;
  float inverse[3];
  float near_offset[3];  // near distance = near plane * inverse + near_offset
  float far_offset[3];
  std::size_t near_plane[3];  // places in the planes of a node
  std::size_t far_plane[3];
  std::size_t kx, ky, kz;
  float sx, sy, sz;  // shear, and 1 / direction[kz], scaled
  float span;        // largest |coordinate| of the ray's origin or the boxes, added

  BoxRay(const WideTree& tree, const Ray& ray) {
    const Vec3f& o = ray.origin;
    const float ax = std::abs(ray.direction.x), ay = std::abs(ray.direction.y),
                az = std::abs(ray.direction.z);
    const float largest = std::max(ax, std::max(ay, az));
    valid = largest > 0 && is_finite(ray.direction) && is_finite(o);
    if (!valid) return;
    const std::uint32_t exponent =
        std::clamp(std::bit_cast<std::uint32_t>(largest) >> 23, 26u, 226u);
    scale = std::bit_cast<float>((253u - exponent) << 23);
    inverse_scale = std::bit_cast<float>((exponent + 1u) << 23);
    span = std::max(std::abs(o.x) + tree.reach.x,
                    std::max(std::abs(o.y) + tree.reach.y, std::abs(o.z) + tree.reach.z));
    for (std::size_t k = 0; k < 3; ++k) {
      float d = ray.direction[k] * scale;
      // Smaller components move the ray by less than the slack over the whole span.
      if (std::abs(d) < 0x1p-40f) d = std::signbit(d) ? -0x1p-40f : 0x1p-40f;
      const float slack = 0x1p-20f * (std::abs(o[k]) + tree.reach[k]) + 0x1p-38f * span + 1e-37f;
      const float toward = d < 0 ? -slack : slack;
      inverse[k] = 1.0f / d;
      near_offset[k] = -(o[k] + toward) * inverse[k];
      far_offset[k] = -(o[k] - toward) * inverse[k];
      near_plane[k] = k * kWidth + (d < 0 ? 3 * kWidth : 0);
      far_plane[k] = k * kWidth + (d < 0 ? 0 : 3 * kWidth);
    }
    kz = ax > ay ? (ax > az ? 0u : 2u) : (ay > az ? 1u : 2u);
    kx = (kz + 1) % 3;
    ky = (kz + 2) % 3;
    sz = inverse[kz];
    sx = ray.direction[kx] * scale * sz;
    sy = ray.direction[ky] * scale * sz;
  }

  /// Bounds in traversal distance, never tighter than the ones given.
  float lower_limit(float t) const {
    const float x = t * inverse_scale;
    return x - std::abs(x) * 0x1p-21f - 1e-37f;
  }
  float upper_limit(float t) const {
    const float x = t * inverse_scale;
    return x + std::abs(x) * 0x1p-21f + 1e-37f;
  }
  /// Never looser.
  float tight_lower_limit(float t) const {
    const float x = t * inverse_scale;
    return (x > 0 ? x * (1 + 0x1p-20f) : x * (1 - 0x1p-20f)) + 1e-37f;
  }
  float tight_upper_limit(float t) const {
    const float x = t * inverse_scale;
    return (x > 0 ? x * (1 - 0x1p-20f) : x * (1 + 0x1p-20f)) - 1e-37f;
  }
};

/// Which of the eight boxes the ray meets between two distances, and where it enters them.
struct BoxTest {
  V8f inverse[3], near_offset[3], far_offset[3], lower;

  BoxTest(const BoxRay& r, float lower_limit) : lower(splat8(lower_limit)) {
    for (int k = 0; k < 3; ++k) {
      inverse[k] = splat8(r.inverse[k]);
      near_offset[k] = splat8(r.near_offset[k]);
      far_offset[k] = splat8(r.far_offset[k]);
    }
  }
  // A NaN (from infinities only) is replaced by the other operand: the box is kept.
  LB_INLINE unsigned operator()(const BoxRay& r, const float* planes, V8f upper, V8f& near) const {
    near = max8(madd8(load8(planes + r.near_plane[0]), inverse[0], near_offset[0]), lower);
    V8f far = min8(madd8(load8(planes + r.far_plane[0]), inverse[0], far_offset[0]), upper);
    near = max8(madd8(load8(planes + r.near_plane[1]), inverse[1], near_offset[1]), near);
    far = min8(madd8(load8(planes + r.far_plane[1]), inverse[1], far_offset[1]), far);
    near = max8(madd8(load8(planes + r.near_plane[2]), inverse[2], near_offset[2]), near);
    far = min8(madd8(load8(planes + r.far_plane[2]), inverse[2], far_offset[2]), far);
    return mask8(near <= far);
  }
};

/// Distance bounds for triangles: outside the loose ones there surely is no hit; a hit inside the
/// tight ones surely counts.
struct Limits {
  float lower, upper, tight_lower, tight_upper;
};

/// What the float test knows about the triangles of a leaf: bit masks.
struct LeafMasks {
  unsigned maybe;    // not ruled out
  unsigned certain;  // surely hit, and at a distance that surely counts
};

/// The leaf's box was met, so a point of the ray lies in it (and its slack): corners are at most
/// the leaf's size from the ray in sheared x and y (m), and at most as far along it as the box can
/// be (M). The products of an edge function then carry an error below 36 u M m, u = 2^-24.
LB_INLINE LeafMasks test_leaf(const BoxRay& r, const Vec3f& origin, const Leaf& leaf,
                              const Limits& limits) {
  constexpr float kUnit = 0x1p-24f;
  const std::size_t step = leaf.count;
  const float* p = leaf.corners();
  const V8f ox = splat8(origin[r.kx]), oy = splat8(origin[r.ky]), oz = splat8(origin[r.kz]);
  const V8f sx = splat8(-r.sx), sy = splat8(-r.sy);
  V8f x[3], y[3], z[3];
  for (std::size_t k = 0; k < 3; ++k) {
    z[k] = load8(p + (3 * k + r.kz) * step) - oz;
    x[k] = madd8(sx, z[k], load8(p + (3 * k + r.kx) * step) - ox);
    y[k] = madd8(sy, z[k], load8(p + (3 * k + r.ky) * step) - oy);
  }
  const V8f u = madd8(x[2], y[1], -(y[2] * x[1]));
  const V8f v = madd8(x[0], y[2], -(y[0] * x[2]));
  const V8f w = madd8(x[1], y[0], -(y[1] * x[0]));
  const float flat = leaf.size() + r.span * 0x1p-17f;
  const float deep = flat + std::min(std::max(limits.upper, -limits.lower), r.span);
  const float bound = (flat + deep) * flat * (40 * kUnit) + 1e-36f;
  const V8f error = splat8(bound);
  const V8f least = min8(u, min8(v, w));
  const V8f most = max8(u, max8(v, w));
  const unsigned lanes = (1u << step) - 1;
  const unsigned maybe = lanes & ~mask8((least < -error) & (most > error));
  if (maybe == 0) return {0, 0};
  const V8i inside = (least > error) | (most < -error);
  const V8f det = u + v + w;
  const V8f t = (u * z[0] + v * z[1] + w * z[2]) / det * splat8(r.sz);
  // Errors of the weights move t only within the depth of the triangle, which is below `flat`.
  const V8f t_error =
      (6.0f * flat * error / abs8(det) + 16 * kUnit * deep) * splat8(std::abs(r.sz)) +
      abs8(t) * (8 * kUnit);
  const V8f t_low = t - t_error, t_high = t + t_error;
  const V8i beyond = (t_low > splat8(limits.upper)) | (t_high < splat8(limits.lower));
  const V8i within = (t_low > splat8(limits.tight_lower)) & (t_high < splat8(limits.tight_upper));
  return {maybe & ~mask8(inside & beyond), maybe & mask8(inside & within)};
}

/// Bounded by the depth of the binary tree: every wide level leaves at most 7 children waiting.
constexpr std::size_t kStackSize = (kWidth - 1) * (hierarchy::kMaxDepth + 1) + 1;

struct Entry {
  std::uint32_t word;
  float near;
};

Hit cast_closest(const WideTree& tree, const Ray& ray, std::uint32_t exclude, HitFilter* filter) {
  Hit best;
  best.t = ray.t_max;
  if (tree.empty) return Hit();
  const BoxRay r(tree, ray);
  if (!r.valid) return Hit();
  const BoxTest boxes(r, r.lower_limit(ray.t_min));
  Limits limits{r.lower_limit(ray.t_min), r.upper_limit(ray.t_max), 0, 0};
  V8f upper = splat8(limits.upper);
  Entry stack[kStackSize];
  std::size_t size = 0;
  std::uint32_t word = 0;
  while (true) {
    while (!Child::is_leaf(word)) {
      const WideNode& node = tree.nodes[word];
      V8f near;
      unsigned mask = boxes(r, &node.lower[0][0], upper, near);
      if (mask == 0) goto pop;
      {
        alignas(32) float distance[kWidth];
        std::memcpy(distance, &near, sizeof distance);
        Entry first{node.child[std::countr_zero(mask)], distance[std::countr_zero(mask)]};
        const std::size_t base = size;
        for (mask &= mask - 1; mask != 0; mask &= mask - 1) {
          const auto place = static_cast<std::size_t>(std::countr_zero(mask));
          Entry entry{node.child[place], distance[place]};
          if (entry.near < first.near) std::swap(entry, first);
          std::size_t k = size++;  // nearest on top
          for (; k > base && stack[k - 1].near < entry.near; --k) stack[k] = stack[k - 1];
          stack[k] = entry;
        }
        word = first.word;
      }
    }
    {
      const Leaf leaf = tree.leaf(word);
      unsigned maybe = test_leaf(r, ray.origin, leaf, limits).maybe;
      for (; maybe != 0; maybe &= maybe - 1) {
        const auto k = static_cast<std::size_t>(std::countr_zero(maybe));
        const std::uint32_t id = leaf.id(k) & ~WideTree::kFilteredFlag;
        if (id == exclude) continue;
        const ExactTest::Result result =
            ExactTest(ray.origin, ray.direction)(leaf.corners() + k, leaf.count);
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
      if (size == 0) return best.found() ? best : Hit();
      --size;
    } while (stack[size].near > limits.upper);
    word = stack[size].word;
  }
}

/// Starts from the given nodes instead of the root. Says where the ray was stopped.
bool occluded_from(const WideTree& tree, std::span<const WideNode* const> start, const Ray& ray,
                   std::uint32_t exclude_a, std::uint32_t exclude_b, HitFilter* filter,
                   const WideNode*& blocker) {
  const BoxRay r(tree, ray);
  if (!r.valid) return false;
  const BoxTest boxes(r, r.lower_limit(ray.t_min));
  const Limits limits{r.lower_limit(ray.t_min), r.upper_limit(ray.t_max),
                      r.tight_lower_limit(ray.t_min), r.tight_upper_limit(ray.t_max)};
  const V8f upper = splat8(limits.upper);
  struct Waiting {
    std::uint32_t word;
    const WideNode* parent;
  };
  Waiting stack[kStackSize];
  std::size_t size = 0, next = 0;
  const WideNode* node = start[0];
  while (true) {
    if (node != nullptr) {
      V8f near;
      unsigned mask = boxes(r, &node->lower[0][0], upper, near);
      for (; mask != 0; mask &= mask - 1) {
        stack[size++] = {node->child[std::countr_zero(mask)], node};
      }
      node = nullptr;
    }
    if (size == 0) {
      if (++next >= start.size()) return false;
      node = start[next];
      continue;
    }
    const auto [word, parent] = stack[--size];
    if (!Child::is_leaf(word)) {
      node = &tree.nodes[word];
      continue;
    }
    const Leaf leaf = tree.leaf(word);
    const LeafMasks masks = test_leaf(r, ray.origin, leaf, limits);
    for (unsigned maybe = masks.maybe; maybe != 0; maybe &= maybe - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(maybe));
      const std::uint32_t id = leaf.id(k) & ~WideTree::kFilteredFlag;
      if (id == exclude_a || id == exclude_b) continue;
      const bool ask = filter != nullptr && (leaf.id(k) & WideTree::kFilteredFlag) != 0;
      if (ask || ((masks.certain >> k) & 1u) == 0) {
        const ExactTest::Result result =
            ExactTest(ray.origin, ray.direction)(leaf.corners() + k, leaf.count);
        if (!result.hit || !(result.t > ray.t_min && result.t < ray.t_max)) continue;
        if (ask && !filter->stops({id, result.t, result.u, result.v, result.back})) continue;
      }
      blocker = parent;
      return true;
    }
  }
}

bool cast_occluded(const WideTree& tree, const Ray& ray, std::uint32_t exclude_a,
                   std::uint32_t exclude_b, HitFilter* filter) {
  if (tree.empty) return false;
  const WideNode* const root = tree.nodes.data();
  const WideNode* unused = nullptr;
  return occluded_from(tree, {&root, 1}, ray, exclude_a, exclude_b, filter, unused);
}

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
  add_children(shaft, tree.nodes[0], found);
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
    add_children(shaft, tree.nodes[word], found);
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
