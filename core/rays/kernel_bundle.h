// Bundles of segments through the tree; included by kernel_impl.h only.
//
// Nodes are tested once for all, against the hull of the segments; what is left is tested a lane a
// ray, box by box, or ray by ray, eight boxes at once, whichever is less; the same goes for the
// triangles of leaves. Only what the float test leaves in doubt goes to ExactTest. In large trees
// several bundles are under way at a time, a node each in turn: what one needs next arrives
// meanwhile.

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

/// Which of the rays `active` meet each child; returns the children that any may meet.
LB_INLINE unsigned meets(const Packet& p, const WideNode& node, unsigned active, unsigned* lanes) {
  constexpr int kFew = 2;
  const int rays = std::popcount(active);
  unsigned mask = rays <= kFew ? 255u : meets_hull(p, node);
  if (rays >= std::popcount(mask)) {
    for (unsigned left = mask; left != 0; left &= left - 1) {
      const std::size_t k = lowest(left);
      lanes[k] = meets_lanes(p, node, k) & active;
    }
    return mask;
  }
  V8i met{};
  for (unsigned left = active; left != 0; left &= left - 1) {
    const std::size_t lane = lowest(left);
    met |= meets_boxes(p, node, lane) & static_cast<std::int32_t>(1u << lane);
  }
  std::memcpy(lanes, &met, sizeof met);
  return mask8(met != 0);
}

/// Which of the rays the leaf's triangles stop, triangle by triangle. All of `lanes` met its box.
/// Bounds as in LeafTest.
unsigned stopped_by_triangle(const Packet& p, std::span<const Segment> segments, const Leaf& leaf,
                             unsigned lanes) {
  constexpr float kUnit = 0x1p-24f;
  const Wide ox = load16(p.origin[p.kx]), oy = load16(p.origin[p.ky]), oz = load16(p.origin[p.kz]);
  const Wide sx = splat16(0) - load16(p.sx), sy = splat16(0) - load16(p.sy);
  const Wide shear = load16(p.shear), zero = splat16(0), tiny = splat16(1e-36f);
  const Wide flat = splat16(leaf.size() + p.span * 0x1p-17f) * shear;
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
  test.slack = p.span * 0x1p-17f;
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
  Walk(const WideTree& tree, std::span<const Segment> segments)
      : segments_(segments), packet_(tree, segments), open_(packet_.lanes), part_{0, open_} {
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
    Part next = alone && size_ != 0 ? stack_[--size_] : Part{0, 0};
    const std::size_t before = count_;
    const unsigned active = part_.lanes & open_;
    if (active != 0) look_at(tree, tree.node(part_.word), active);
    for (std::size_t i = 0; i < before && open_ != 0; ++i) {
      const unsigned lanes = waiting_[i].lanes & open_;
      if (lanes == 0) continue;
      open_ &= ~stopped_in_leaf(packet_, segments_, tree.leaf(waiting_[i].word), lanes);
    }
    count_ -= before;
    for (std::size_t i = 0; i < count_; ++i) waiting_[i] = waiting_[i + before];
    if (next.lanes == 0 && size_ != 0) next = stack_[--size_];
    part_ = next;
    return next.lanes != 0 || count_ != 0;
  }

 private:
  struct Part {
    std::uint32_t word;
    unsigned lanes;
  };

  LB_INLINE void look_at(const WideTree& tree, const WideNode& node, unsigned active) {
    const std::size_t old_size = size_, old_count = count_;
    alignas(32) unsigned lanes[kWidth];
    // Every child is written; only those that count move the ends. So no branch asks.
    for (unsigned mask = meets(packet_, node, active, lanes); mask != 0; mask &= mask - 1) {
      const std::size_t k = lowest(mask);
      const Part child{node.child[k], lanes[k]};
      if constexpr (kGrids) {
        if (Child::is_grid(child.word)) {
          open_ &= ~stopped_in_grid(tree, segments_, child.word, child.lanes & open_);
          continue;
        }
      }
      const bool keep = child.lanes != 0, leaf = Child::is_leaf(child.word);
      stack_[size_] = waiting_[count_] = child;
      size_ += (keep & !leaf) ? 1 : 0;
      count_ += (keep & leaf) ? 1 : 0;
    }
    // What stops most rays is likely below the child that most of them meet.
    std::size_t widest = old_size;
    for (std::size_t i = old_size; i < size_; ++i) {
      prefetch(tree, stack_[i].word);
      if (std::popcount(stack_[i].lanes) > std::popcount(stack_[widest].lanes)) widest = i;
    }
    if (size_ != old_size) std::swap(stack_[widest], stack_[size_ - 1]);
    for (std::size_t i = old_count; i < count_; ++i) prefetch(tree, waiting_[i].word);
  }

  std::span<const Segment> segments_;
  Packet packet_;
  unsigned open_;         // of the packet, not stopped so far
  unsigned stopped_ = 0;  // of those apart
  Part part_;             // to be looked at next
  std::size_t size_ = 0, count_ = 0;
  Part waiting_[2 * kWidth + 1];  // leaves on their way from memory
  Part stack_[kStackSize + 1];
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
  Place places[kAtOnce];
  std::size_t begun = 0;
  const auto begin = [&](Place& place) {
    place.bundle = begun++;
    const std::span<const Segment> rest = segments.subspan(place.bundle * kLanes);
    if (begun < stopped.size()) prefetch_bundle(rest.subspan(kLanes));
    place.walk.emplace(tree, rest.first(std::min(kLanes, rest.size())));
  };
  const std::size_t most = tree.data.size() > kCached ? kAtOnce : 1;
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
