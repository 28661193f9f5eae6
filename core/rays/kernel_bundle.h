// Bundles of segments through the tree; included by kernel_impl.h only.
//
// What to look at next is found with few branches on data: mispredicted ones take more time than
// the tests of boxes. So with vectors of sixteen all eight boxes are tested, a lane a ray; with
// shorter ones, or in large trees, those that the hull of the segments meets. The triangles of
// leaves are tested a lane a ray, or ray by ray, eight at once, whichever is less. Only what the
// float test leaves in doubt goes to ExactTest. In large trees several bundles are under way at a
// time, a node each in turn: what one needs next arrives meanwhile.

/// Which of the eight boxes the hull of the segments may meet.
LB_INLINE unsigned meets_hull(const Packet& p, const WideNode& node) {
  V8f near = splat8(-0x1p-10f), far = splat8(1 + 0x1p-10f);
  for (std::size_t k = 0; k < 3; ++k) {
    const V8f lower = load8(node.lower[k]), upper = load8(node.upper[k]);
    near = max8(madd8(lower, splat8(p.near_slope[0][k]), splat8(p.near_start[0][k])), near);
    near = max8(madd8(upper, splat8(p.near_slope[1][k]), splat8(p.near_start[1][k])), near);
    far = min8(madd8(lower, splat8(p.far_slope[0][k]), splat8(p.far_start[0][k])), far);
    far = min8(madd8(upper, splat8(p.far_slope[1][k]), splat8(p.far_start[1][k])), far);
  }
  return mask8(near <= far);
}

/// Which of the eight boxes one ray meets.
LB_INLINE V8i meets_boxes(const Packet& p, const WideNode& node, std::size_t lane) {
  const float* planes = &node.lower[0][0];
  V8f near = splat8(p.lower[lane]), far = splat8(p.upper[lane]);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t backward = p.backward[k] >> lane & 1u;
    const V8f inv = splat8(p.inverse[k][lane]);
    near = max8(
        madd8(load8(planes + (k + 3 * backward) * kWidth), inv, splat8(p.near_offset[k][lane])),
        near);
    far = min8(
        madd8(load8(planes + (k + 3 - 3 * backward) * kWidth), inv, splat8(p.far_offset[k][lane])),
        far);
  }
  return near <= far;
}

/// Which of the rays `active` meet each of the eight boxes. `all`: without asking the hull.
LB_INLINE V8i meets(const Packet& p, const WideNode& node, unsigned active, bool all) {
  const unsigned others = active & (active - 1);
  if (std::popcount(active) <= 2) {
    const std::size_t one = lowest(active), other = others == 0 ? one : lowest(others);
    return (meets_boxes(p, node, one) & static_cast<std::int32_t>(1u << one)) |
           (meets_boxes(p, node, other) & static_cast<std::int32_t>(1u << other));
  }
  const auto lanes = [&](std::size_t child) LB_LAMBDA_INLINE -> std::uint64_t {
    Wide near = load16(p.lower), far = load16(p.upper);
    for (std::size_t k = 0; k < 3; ++k) {
      const Wide lower = splat16(node.lower[k][child]), upper = splat16(node.upper[k][child]);
      const Wide first = select16(p.backward[k], upper, lower);
      const Wide last = select16(p.backward[k], lower, upper);
      const Wide inverse = load16(p.inverse[k]);
      near = max16(madd16(first, inverse, load16(p.near_offset[k])), near);
      far = min16(madd16(last, inverse, load16(p.far_offset[k])), far);
    }
    return at_most16(near, far);
  };
  std::uint64_t words[2] = {0, 0};
  if (all) {
    words[0] = lanes(0) | lanes(1) << 16 | lanes(2) << 32 | lanes(3) << 48;
    words[1] = lanes(4) | lanes(5) << 16 | lanes(6) << 32 | lanes(7) << 48;
  } else {
    for (unsigned left = meets_hull(p, node); left != 0; left &= left - 1) {
      const std::size_t k = lowest(left);
      words[k / 4] |= lanes(k) << 16 * (k % 4);
    }
  }
  return spread8(words[0], words[1]) & static_cast<std::int32_t>(active);
}

/// Which of the rays the leaf's triangles stop, triangle by triangle. All of `lanes` met its box.
/// Bounds as in LeafTest.
unsigned stopped_by_triangle(const Packet& p, std::span<const Segment> segments, const Leaf& leaf,
                             unsigned lanes) {
  constexpr float kUnit = 0x1p-24f;
  const Wide ox = load16(p.origin[p.kx]), oy = load16(p.origin[p.ky]), oz = load16(p.origin[p.kz]);
  const Wide sx = splat16(0) - load16(p.sx), sy = splat16(0) - load16(p.sy);
  const Wide shear = load16(p.shear), zero = splat16(0), tiny = splat16(1e-36f);
  const Wide flat = madd16(load16(p.span), splat16(0x1p-17f), splat16(leaf.size())) * shear;
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
    const Wide least = min16(u, min16(v, w)), most = max16(u, max16(v, w));
    const Wide coarse = madd16((flat + deep) * flat, splat16(24 * kUnit), tiny);
    unsigned maybe = lanes & ~(less16(least, zero - coarse) & less16(coarse, most));
    if (maybe == 0) continue;
    const Wide m = max16(max16(max16(abs16(x[0]), abs16(y[0])), max16(abs16(x[1]), abs16(y[1]))),
                         max16(abs16(x[2]), abs16(y[2])));
    const Wide error = madd16((m + deep) * m, splat16(24 * kUnit), tiny);
    maybe &= ~(less16(least, zero - error) & less16(error, most));
    if (maybe == 0) continue;
    const std::uint32_t id = leaf.id(i) & ~WideTree::kFilteredFlag;
    maybe &= ~equal16(p.exclude_a, id) & ~equal16(p.exclude_b, id);
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
      const Ray& ray = segments[lane].ray;
      const ExactTest::Result result = ExactTest(ray.origin, ray.direction)(c, step);
      if (result.hit && result.t > ray.t_min && result.t < ray.t_max) hit |= 1u << lane;
    }
    stopped |= hit;
    lanes &= ~hit;
    if (lanes == 0) break;
  }
  return stopped;
}

SteepLeafTest leaf_test(const Packet& p, std::size_t lane) {
  SteepLeafTest test;
  test.ox = splat8(p.origin[p.kx][lane]);
  test.oy = splat8(p.origin[p.ky][lane]);
  test.oz = splat8(p.origin[p.kz][lane]);
  test.sx = splat8(-p.sx[lane]);
  test.sy = splat8(-p.sy[lane]);
  test.sz = splat8(p.sz[lane]);
  test.kx = p.kx;
  test.ky = p.ky;
  test.kz = p.kz;
  test.slack = p.span[lane] * 0x1p-17f;
  test.steep = p.shear[lane];
  return test;
}

/// The same ray by ray.
unsigned stopped_by_ray(const Packet& p, std::span<const Segment> segments, const Leaf& leaf,
                        unsigned lanes) {
  unsigned stopped = 0;
  for (; lanes != 0; lanes &= lanes - 1) {
    const std::size_t i = lowest(lanes);
    const Segment& s = segments[i];
    const AnyHit<SteepLeafTest> any{
        s.ray,   s.exclude_a,     s.exclude_b,
        nullptr, leaf_test(p, i), {p.lower[i], p.upper[i], p.tight_lower[i], p.tight_upper[i]}};
    if (any.in(leaf)) stopped |= 1u << i;
  }
  return stopped;
}

LB_INLINE unsigned stopped_in_leaf(const Packet& p, std::span<const Segment> segments,
                                   const Leaf& leaf, unsigned lanes) {
  // A triangle on sixteen lanes takes about a third less than a ray on eight.
  return 3 * std::popcount(lanes) <= 2 * static_cast<int>(leaf.count)
             ? stopped_by_ray(p, segments, leaf, lanes)
             : stopped_by_triangle(p, segments, leaf, lanes);
}

/// Which of the rays a grid's triangles stop: ray by ray.
unsigned stopped_in_grid(const WideTree& tree, std::span<const Segment> segments,
                         std::uint32_t word, unsigned lanes) {
  unsigned stopped = 0;
  for (; lanes != 0; lanes &= lanes - 1) {
    const std::size_t i = lowest(lanes);
    const Segment& s = segments[i];
    const BoxRay r(tree, s.ray);
    const AnyHit<LeafTest> any = any_hit(s.ray, r, s.exclude_a, s.exclude_b, nullptr);
    if (any.in_grid(tree, word, r)) stopped |= 1u << i;
  }
  return stopped;
}

/// A bundle on its way.
template <bool kGrids>
class Walk {
 public:
  /// `all_boxes`: each is tested, without asking the hull.
  Walk(const WideTree& tree, std::span<const Segment> segments, bool all_boxes)
      : segments_(segments),
        packet_(tree, segments, !all_boxes),
        all_boxes_(all_boxes),
        open_(packet_.lanes),
        part_{0, open_} {
    std::fill_n(words_, kBottom, 0u);
    for (unsigned apart = packet_.apart; apart != 0; apart &= apart - 1) {
      const std::size_t i = lowest(apart);
      const Segment& s = segments[i];
      if (cast_occluded(tree, s.ray, s.exclude_a, s.exclude_b, nullptr)) stopped_ |= 1u << i;
    }
  }

  unsigned stopped() const { return stopped_ | (packet_.lanes & ~open_); }

  /// Looks at one node, and at the leaves found before. False when there is no more to do. `alone`:
  /// the next node is chosen before this one's children are known, so that it arrives meanwhile.
  LB_INLINE bool step(const WideTree& tree, bool alone) {
    if (open_ == 0) return false;
    Part next = alone && size_ != kBottom ? pop() : Part{0, 0};
    const Waiting& before = waiting_[turn_];
    turn_ ^= 1;
    waiting_[turn_].count = 0;
    const unsigned active = part_.lanes & open_;
    if (active != 0) look_at(tree, tree.node(part_.word), active);
    for (std::size_t i = 0; i < before.count && open_ != 0; ++i) {
      const unsigned lanes = before.lanes[i] & open_;
      if (lanes == 0) continue;
      open_ &= ~stopped_in_leaf(packet_, segments_, tree.leaf(before.words[i]), lanes);
    }
    if (next.lanes == 0 && size_ != kBottom) next = pop();
    part_ = next;
    return next.lanes != 0 || waiting_[turn_].count != 0;
  }

 private:
  static constexpr std::size_t kBottom = 2;  // places that hold the root: prefetching needs no ends
  struct Part {
    std::uint32_t word;
    unsigned lanes;
  };
  struct Waiting {
    std::uint32_t words[kWidth] = {}, lanes[kWidth];
    std::size_t count = 0;
  };

  LB_INLINE Part pop() {
    --size_;
    return {words_[size_], lanes_[size_]};
  }

  LB_INLINE void look_at(const WideTree& tree, const WideNode& node, unsigned active) {
    const V8i lanes = meets(packet_, node, active, all_boxes_);
    V8i words;
    std::memcpy(&words, node.child, sizeof words);
    const unsigned met = mask8(lanes != 0), leaves = met & mask8(words);
    unsigned inner = met & ~leaves;
    if constexpr (kGrids) {
      for (unsigned left = inner; left != 0; left &= left - 1) {
        const std::size_t k = lowest(left);
        if (!Child::is_grid(node.child[k])) continue;
        inner &= ~(1u << k);
        const unsigned asked = static_cast<unsigned>(lanes[static_cast<int>(k)]) & open_;
        open_ &= ~stopped_in_grid(tree, segments_, node.child[k], asked);
      }
    }
    std::uint32_t each[kWidth];
    std::memcpy(each, &lanes, sizeof each);
    Waiting& waiting = waiting_[turn_];
    pack8(leaves, each, waiting.lanes);
    waiting.count = pack8(leaves, node.child, waiting.words);
    pack8(inner, each, lanes_ + size_);
    size_ += pack8(inner, node.child, words_ + size_);
    for (std::size_t i = 0; i < 2; ++i) {
      prefetch(tree, waiting.words[i]);
      prefetch(tree, words_[size_ - 1 - i]);
    }
  }

  std::span<const Segment> segments_;
  Packet packet_;
  bool all_boxes_;
  unsigned open_;         // of the packet, not stopped so far
  unsigned stopped_ = 0;  // of those apart
  Part part_;             // to be looked at next
  Waiting waiting_[2];    // leaves on their way from memory, and those found now
  unsigned turn_ = 0;     // which are which
  std::size_t size_ = kBottom;
  // Nodes to be looked at, and which rays meet them.
  std::uint32_t words_[kBottom + kStackSize + kWidth], lanes_[kBottom + kStackSize + kWidth];
};

/// The first bundle of these segments will be asked for.
LB_INLINE void prefetch_bundle(std::span<const Segment> segments) {
  const auto bytes = std::as_bytes(segments.first(std::min(kLanes, segments.size())));
  for (std::size_t i = 0; i < bytes.size(); i += 64) __builtin_prefetch(bytes.data() + i);
}

template <bool kGrids>
LB_INLINE void cast_bundles_in(const WideTree& tree, std::span<const Segment> segments,
                               std::span<std::uint32_t> stopped) {
  // Nothing has to be waited for where the tree fits the caches; turns only disturb predictions.
  constexpr std::size_t kAtOnce = 8, kCached = std::size_t{16} << 20;
  struct Place {
    std::optional<Walk<kGrids>> walk;
    std::size_t bundle;
  };
  const std::size_t most = tree.data.size() > kCached ? kAtOnce : 1;
  Place places[kAtOnce];
  std::size_t begun = 0;
  const auto begin = [&](Place& place) {
    place.bundle = begun++;
    const std::span<const Segment> rest = segments.subspan(place.bundle * kLanes);
    if (begun < stopped.size()) prefetch_bundle(rest.subspan(kLanes));
    place.walk.emplace(tree, rest.first(std::min(kLanes, rest.size())), kAllBoxes && most == 1);
  };
  std::size_t number = 0;
  while (number < most && begun < stopped.size()) begin(places[number++]);
  for (std::size_t left = number; left > 0;) {
    for (std::size_t i = 0; i < number; ++i) {
      Place& place = places[i];
      if (!place.walk || place.walk->step(tree, most == 1)) continue;
      stopped[place.bundle] = place.walk->stopped();
      if (begun < stopped.size()) {
        begin(place);
      } else {
        place.walk.reset();
        --left;
      }
    }
  }
}

/// Bit j of stopped[i]: something stops segment 16 i + j.
void cast_bundles(const WideTree& tree, std::span<const Segment> segments,
                  std::span<std::uint32_t> stopped) {
  if (tree.empty) {
    std::fill(stopped.begin(), stopped.end(), 0u);
  } else if (tree.grids.empty()) {
    cast_bundles_in<false>(tree, segments, stopped);
  } else {
    cast_bundles_in<true>(tree, segments, stopped);
  }
}
