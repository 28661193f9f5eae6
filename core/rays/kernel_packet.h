// Up to sixteen segments made ready to go through the tree together; included by kernel_impl.h
// only.
//
// Their hull: on each axis, the interval that they cover moves linearly from that of the origins to
// that of the ends.

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
