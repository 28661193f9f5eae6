// Up to sixteen segments through the tree together; included by kernel_impl.h only.
//
// Nodes are tested once for all, against the hull of the segments: on each axis, the interval that
// they cover moves linearly from that of the origins to that of the ends. What is left is tested
// ray by ray, a lane each, boxes first, then triangles; only what the float test leaves in doubt
// goes to ExactTest.

/// The segments side by side. Lanes that are not in `lanes` hold copies of one that is.
struct Packet {
  static constexpr float kMostShear = 8;
  alignas(64) float origin[3][kLanes], direction[3][kLanes];
  alignas(64) float inverse[3][kLanes], near_offset[3][kLanes], far_offset[3][kLanes];
  alignas(64) float t_min[kLanes], t_max[kLanes], inverse_scale[kLanes];
  alignas(64) float lower[kLanes], upper[kLanes], tight_lower[kLanes], tight_upper[kLanes];
  alignas(64) float sx[kLanes], sy[kLanes], sz[kLanes];
  alignas(64) float shear[kLanes];  // the larger of sx and sy, at least 1
  alignas(64) std::uint32_t exclude_a[kLanes], exclude_b[kLanes];
  unsigned lanes = 0;  // cast together
  unsigned apart = 0;  // to be cast by themselves
  unsigned backward[3];
  std::size_t kx = 0, ky = 1, kz = 2;
  float span = 0;
  // Hull: near = plane * slope + offset, from the lower plane (0) and from the upper one (1).
  float near_slope[3][2], near_start[3][2], far_slope[3][2], far_start[3][2];

  Packet(const WideTree& tree, std::span<const Segment> segments);

 private:
  void take(std::span<const Segment> segments);
  void make_hull(const WideTree& tree);
  void make_lanes(const WideTree& tree);
};

Packet::Packet(const WideTree& tree, std::span<const Segment> segments) {
  take(segments);
  if (lanes == 0) return;
  make_hull(tree);
  make_lanes(tree);
}

void Packet::take(std::span<const Segment> segments) {
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Segment& s = segments[i < segments.size() ? i : 0];
    for (std::size_t k = 0; k < 3; ++k) {
      origin[k][i] = s.ray.origin[k];
      direction[k][i] = s.ray.direction[k];
    }
    t_min[i] = s.ray.t_min;
    t_max[i] = s.ray.t_max;
    exclude_a[i] = s.exclude_a;
    exclude_b[i] = s.exclude_b;
  }
  const unsigned given = (1u << segments.size()) - 1;
  Wide sum = load16(t_max) - load16(t_max), largest = splat16(0);
  for (std::size_t k = 0; k < 3; ++k) {
    const Wide o = load16(origin[k]), d = load16(direction[k]);
    sum = sum + (o - o) + (d - d);
    largest = max16(abs16(d), largest);
  }
  // Finite, a direction, and a range to walk along: others take the ordinary way.
  lanes = given & at_most16(sum, splat16(0)) & less16(splat16(0), largest) &
          at_most16(splat16(0), load16(t_min)) & less16(load16(t_min), load16(t_max));
  apart = given & ~lanes;
  if (lanes == 0 || lanes == given) return;
  const std::size_t first = lowest(lanes);
  for (std::size_t i = 0; i < kLanes; ++i) {
    if ((lanes >> i & 1u) != 0 || i >= segments.size()) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      origin[k][i] = origin[k][first];
      direction[k][i] = direction[k][first];
    }
    t_min[i] = t_min[first];
    t_max[i] = t_max[first];
  }
  for (std::size_t i = segments.size(); i < kLanes; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      origin[k][i] = origin[k][first];
      direction[k][i] = direction[k][first];
    }
    t_min[i] = t_min[first];
    t_max[i] = t_max[first];
  }
}

void Packet::make_hull(const WideTree& tree) {
  // Lower bounds, and negated upper bounds, of origins and ends.
  V4f corner[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const Wide o = load16(origin[k]), e = madd16(load16(direction[k]), load16(t_max), o);
    const Wide zero = splat16(0);
    corner[k] = least_of_four(o, zero - o, e, zero - e);
    const float most =
        std::max(std::max(-corner[k][0], -corner[k][1]), std::max(-corner[k][2], -corner[k][3]));
    const float least =
        std::max(std::max(corner[k][0], corner[k][1]), std::max(corner[k][2], corner[k][3]));
    span = std::max(span, std::max(most, least) + tree.reach[k]);
  }
  float widest = -1;
  for (std::size_t k = 0; k < 3; ++k) {
    // Far more than any rounding here and of the ends.
    const float pad = span * 0x1p-19f + 1e-36f;
    const float starts[2] = {-corner[k][1] + pad, corner[k][0] - pad};  // highest, lowest origin
    const float ends[2] = {-corner[k][3] + pad, corner[k][2] - pad};
    const float run = std::abs(ends[0] + ends[1] - starts[0] - starts[1]);
    if (run > widest) {
      widest = run;
      kz = k;
    }
    for (std::size_t side = 0; side < 2; ++side) {
      float slope = ends[side] - starts[side];
      const float least = span * 0x1p-40f + 1e-37f;
      if (std::abs(slope) < least) slope = side == 0 ? least : -least;
      const float inv = 1.0f / slope;
      // The highest point must reach the lower plane, the lowest one the upper plane.
      const bool bounds_near = (slope > 0) == (side == 0);
      constexpr float kMost = std::numeric_limits<float>::max();
      near_slope[k][side] = bounds_near ? inv : 0.0f;
      near_start[k][side] = bounds_near ? -starts[side] * inv : -kMost;
      far_slope[k][side] = bounds_near ? 0.0f : inv;
      far_start[k][side] = bounds_near ? kMost : -starts[side] * inv;
    }
  }
  kx = (kz + 1) % 3;
  ky = (kz + 2) % 3;
}

/// As BoxRay, for every lane.
void Packet::make_lanes(const WideTree& tree) {
  alignas(64) float scale[kLanes], largest[kLanes];
  store16(largest, max16(abs16(load16(direction[0])),
                         max16(abs16(load16(direction[1])), abs16(load16(direction[2])))));
  for (std::size_t i = 0; i < kLanes; ++i) {
    const std::uint32_t exponent =
        std::min(std::max(std::bit_cast<std::uint32_t>(largest[i]) >> 23, 26u), 226u);
    scale[i] = std::bit_cast<float>((253u - exponent) << 23);
    inverse_scale[i] = std::bit_cast<float>((exponent + 1u) << 23);
  }
  const Wide scales = load16(scale), zero = splat16(0), one = splat16(1);
  for (std::size_t k = 0; k < 3; ++k) {
    const Wide o = load16(origin[k]), d = load16(direction[k]) * scales;
    backward[k] = less16(d, zero);
    const Wide tiny = select16(backward[k], splat16(-0x1p-40f), splat16(0x1p-40f));
    const Wide inv = one / select16(less16(abs16(d), splat16(0x1p-40f)), tiny, d);
    const Wide slack =
        (abs16(o) + splat16(tree.reach[k])) * splat16(0x1p-20f) + splat16(0x1p-38f * span + 1e-37f);
    const Wide offset = zero - o * inv, pad = slack * abs16(inv);
    store16(inverse[k], inv);
    store16(near_offset[k], offset - pad);
    store16(far_offset[k], offset + pad);
  }
  // Steeper ones would blow up the error bounds of the test of triangles.
  const Wide along = load16(direction[kz]) * scales;
  const unsigned steep = less16(abs16(along) * splat16(kMostShear), load16(largest) * scales);
  apart |= lanes & steep;
  lanes &= ~steep;
  const Wide inv_z = load16(inverse[kz]);
  store16(sz, inv_z);
  const Wide x = load16(direction[kx]) * scales * inv_z, y = load16(direction[ky]) * scales * inv_z;
  store16(sx, x);
  store16(sy, y);
  store16(shear, max16(one, max16(abs16(x), abs16(y))));
  const Wide low = load16(t_min) * load16(inverse_scale),
             high = load16(t_max) * load16(inverse_scale), least = splat16(1e-37f);
  store16(lower, low - low * splat16(0x1p-21f) - least);
  store16(upper, high + high * splat16(0x1p-21f) + least);
  store16(tight_lower, low + low * splat16(0x1p-20f) + least);
  store16(tight_upper, high - high * splat16(0x1p-20f) - least);
}

/// Which of the eight boxes the hull of the segments may meet.
LB_INLINE unsigned meets_hull(const Packet& p, const WideNode& node) {
  V8f near = splat8(-0x1p-10f), far = splat8(1 + 0x1p-10f);
  for (std::size_t k = 0; k < 3; ++k) {
    const V8f lower = load8(node.lower[k]), upper = load8(node.upper[k]);
    near = max8(madd8(lower, splat8(p.near_slope[k][0]), splat8(p.near_start[k][0])), near);
    near = max8(madd8(upper, splat8(p.near_slope[k][1]), splat8(p.near_start[k][1])), near);
    far = min8(madd8(lower, splat8(p.far_slope[k][0]), splat8(p.far_start[k][0])), far);
    far = min8(madd8(upper, splat8(p.far_slope[k][1]), splat8(p.far_start[k][1])), far);
  }
  return mask8(near <= far);
}

/// Which rays meet a child's box.
LB_INLINE unsigned meets_lanes(const Packet& p, const WideNode& node, std::size_t child) {
  Wide near = load16(p.lower), far = load16(p.upper);
  for (std::size_t k = 0; k < 3; ++k) {
    const Wide lower = splat16(node.lower[k][child]), upper = splat16(node.upper[k][child]);
    const Wide first = select16(p.backward[k], upper, lower);
    const Wide last = select16(p.backward[k], lower, upper);
    const Wide inv = load16(p.inverse[k]);
    near = max16(madd16(first, inv, load16(p.near_offset[k])), near);
    far = min16(madd16(last, inv, load16(p.far_offset[k])), far);
  }
  return at_most16(near, far);
}

/// Which of the rays the leaf's triangles stop. All of `lanes` met its box. Bounds as in LeafTest,
/// where the shear s may be larger than 1: m is below (1 + s) times the leaf's size, the error
/// below u m (12 m + 20 s M).
unsigned stopped_in_leaf(const Packet& p, const Leaf& leaf, unsigned lanes) {
  constexpr float kUnit = 0x1p-24f;
  const Wide ox = load16(p.origin[p.kx]), oy = load16(p.origin[p.ky]), oz = load16(p.origin[p.kz]);
  const Wide sx = splat16(0) - load16(p.sx), sy = splat16(0) - load16(p.sy);
  const Wide shear = load16(p.shear), zero = splat16(0), tiny = splat16(1e-36f);
  const Wide flat = splat16(leaf.size() + p.span * 0x1p-17f) * (shear + splat16(1));
  const std::size_t step = leaf.count;
  unsigned stopped = 0;
  for (std::size_t i = 0; i < leaf.count; ++i) {
    const float* c = leaf.corners() + i;
    Wide x[3], y[3], z[3];
    for (std::size_t k = 0; k < 3; ++k) {
      z[k] = splat16(c[(3 * k + p.kz) * step]) - oz;
      x[k] = madd16(sx, z[k], splat16(c[(3 * k + p.kx) * step]) - ox);
      y[k] = madd16(sy, z[k], splat16(c[(3 * k + p.ky) * step]) - oy);
    }
    const Wide u = x[2] * y[1] - y[2] * x[1];
    const Wide v = x[0] * y[2] - y[0] * x[2];
    const Wide w = x[1] * y[0] - y[1] * x[0];
    const Wide deep = max16(abs16(z[0]), max16(abs16(z[1]), abs16(z[2]))) * shear;
    const Wide coarse = madd16((flat + deep) * flat, splat16(24 * kUnit), tiny);
    const Wide least = min16(u, min16(v, w)), most = max16(u, max16(v, w));
    unsigned maybe = lanes & ~(less16(least, zero - coarse) & less16(coarse, most));
    if (maybe == 0) continue;
    const std::uint32_t id = leaf.id(i) & ~WideTree::kFilteredFlag;
    maybe &= ~equal16(p.exclude_a, id) & ~equal16(p.exclude_b, id);
    const Wide m = max16(max16(max16(abs16(x[0]), abs16(y[0])), max16(abs16(x[1]), abs16(y[1]))),
                         max16(abs16(x[2]), abs16(y[2])));
    const Wide error = madd16((m + deep) * m, splat16(24 * kUnit), tiny);
    maybe &= ~(less16(least, zero - error) & less16(error, most));
    if (maybe == 0) continue;
    const unsigned inside = less16(error, least) | less16(most, zero - error);
    const Wide det = u + v + w, sz = load16(p.sz);
    const Wide t = (u * z[0] + v * z[1] + w * z[2]) / det * sz;
    const Wide spread = max16(z[0], max16(z[1], z[2])) - min16(z[0], min16(z[1], z[2]));
    const Wide t_error =
        madd16(splat16(4) * spread, error / abs16(det), splat16(16 * kUnit) * deep) * abs16(sz) +
        abs16(t) * splat16(8 * kUnit);
    const Wide low = t - t_error, high = t + t_error;
    const unsigned beyond = less16(load16(p.upper), low) | less16(high, load16(p.lower));
    const unsigned within =
        less16(load16(p.tight_lower), low) & less16(high, load16(p.tight_upper));
    const unsigned left = maybe & ~(inside & beyond);
    unsigned hit = left & inside & within;
    for (unsigned doubt = left & ~hit; doubt != 0; doubt &= doubt - 1) {
      const std::size_t lane = lowest(doubt);
      const Vec3f o{p.origin[0][lane], p.origin[1][lane], p.origin[2][lane]};
      const Vec3f d{p.direction[0][lane], p.direction[1][lane], p.direction[2][lane]};
      const ExactTest::Result result = ExactTest(o, d)(c, step);
      if (result.hit && result.t > p.t_min[lane] && result.t < p.t_max[lane]) hit |= 1u << lane;
    }
    stopped |= hit;
    lanes &= ~hit;
    if (lanes == 0) break;
  }
  return stopped;
}

/// Which of the rays a grid's triangles stop: ray by ray.
unsigned stopped_in_grid(const WideTree& tree, std::span<const Segment> segments,
                         std::uint32_t word, unsigned lanes) {
  unsigned stopped = 0;
  for (; lanes != 0; lanes &= lanes - 1) {
    const std::size_t i = lowest(lanes);
    const Segment& s = segments[i];
    const BoxRay r(tree, s.ray);
    const AnyHit any(s.ray, r, s.exclude_a, s.exclude_b, nullptr);
    if (any.in_grid(tree, word, r)) stopped |= 1u << i;
  }
  return stopped;
}

template <bool kGrids>
LB_INLINE unsigned packet_in(const WideTree& tree, std::span<const Segment> segments) {
  const Packet p(tree, segments);
  unsigned stopped = 0;
  for (unsigned apart = p.apart; apart != 0; apart &= apart - 1) {
    const std::size_t i = lowest(apart);
    const Segment& s = segments[i];
    if (cast_occluded(tree, s.ray, s.exclude_a, s.exclude_b, nullptr)) stopped |= 1u << i;
  }
  if (p.lanes == 0) return stopped;
  struct Part {
    std::uint32_t word;
    unsigned lanes;
  };
  unsigned open = p.lanes;
  Part stack[kStackSize + 1];
  Part* top = stack;
  Part waiting[2 * kWidth + 1];  // leaves on their way from memory
  std::size_t count = 0;
  Part part{0, open}, next{0, 0};
  while (open != 0) {
    // The next node is chosen before this one's children are known, so that it arrives meanwhile.
    next = top != stack ? *--top : Part{0, 0};
    const std::size_t before = count;
    if ((part.lanes & open) != 0) {
      const WideNode& node = tree.node(part.word);
      // Every child is written; only those that count move the ends. So no branch asks.
      Part* const old_top = top;
      const std::size_t old_count = count;
      for (unsigned mask = meets_hull(p, node); mask != 0; mask &= mask - 1) {
        const std::size_t k = lowest(mask);
        const Part child{node.child[k], meets_lanes(p, node, k) & part.lanes & open};
        if constexpr (kGrids) {
          if (Child::is_grid(child.word)) {
            open &= ~stopped_in_grid(tree, segments, child.word, child.lanes);
            continue;
          }
        }
        const bool keep = child.lanes != 0, leaf = Child::is_leaf(child.word);
        *top = waiting[count] = child;
        top += (keep & !leaf) ? 1 : 0;
        count += (keep & leaf) ? 1 : 0;
      }
      // What stops most rays is likely below the child that most of them meet.
      Part* widest = old_top;
      for (Part* q = old_top; q != top; ++q) {
        prefetch(tree, q->word);
        if (std::popcount(q->lanes) > std::popcount(widest->lanes)) widest = q;
      }
      if (top != old_top) std::swap(*widest, top[-1]);
      for (std::size_t i = old_count; i < count; ++i) prefetch(tree, waiting[i].word);
    }
    for (std::size_t i = 0; i < before && open != 0; ++i) {
      const unsigned lanes = waiting[i].lanes & open;
      if (lanes != 0) open &= ~stopped_in_leaf(p, tree.leaf(waiting[i].word), lanes);
    }
    count -= before;
    for (std::size_t i = 0; i < count; ++i) waiting[i] = waiting[i + before];
    if (next.lanes == 0) {
      if (top != stack) {
        next = *--top;
      } else if (count == 0) {
        break;
      }
    }
    part = next;
  }
  return stopped | (p.lanes & ~open);
}

/// Bit i: something stops segment i. 1 to 16 segments.
unsigned cast_packet(const WideTree& tree, std::span<const Segment> segments) {
  if (tree.empty) return 0;
  return tree.grids.empty() ? packet_in<false>(tree, segments) : packet_in<true>(tree, segments);
}
