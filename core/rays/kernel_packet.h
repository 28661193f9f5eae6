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
  alignas(64) float span[kLanes];   // as BoxRay
  alignas(64) std::uint32_t exclude_a[kLanes], exclude_b[kLanes];
  unsigned lanes = 0;  // cast together
  unsigned apart = 0;  // to be cast by themselves
  unsigned backward[3];
  std::size_t kx = 0, ky = 1, kz = 2;
  // Hull, if asked for: near = plane * slope + start, from the lower plane (0) and
  // from the upper one (1), for three axes.
  float near_slope[2][4], near_start[2][4], far_slope[2][4], far_start[2][4];

  Packet(const WideTree& tree, std::span<const Segment> segments, bool with_hull);

 private:
  void take(std::span<const Segment> segments);
  void choose_axis();
  void make_hull(const WideTree& tree);
  void make_lanes(const WideTree& tree);
};

Packet::Packet(const WideTree& tree, std::span<const Segment> segments, bool with_hull) {
  take(segments);
  if (lanes == 0) return;
  choose_axis();
  if (with_hull) make_hull(tree);
  make_lanes(tree);
}

void Packet::take(std::span<const Segment> segments) {
  const auto segment = [&](std::size_t lane) LB_LAMBDA_INLINE -> const Segment& {
    return segments[lane < segments.size() ? lane : 0];
  };
  static_assert(sizeof(Ray) == sizeof(V8f));
  V8f low[8], high[8];
  for (std::size_t i = 0; i < 8; ++i) {
    low[i] = load8(&segment(i).ray.origin.x);
    high[i] = load8(&segment(i + 8).ray.origin.x);
  }
  transpose8(low);
  transpose8(high);
  for (std::size_t k = 0; k < 3; ++k) {
    store16(origin[k], join16(low[k], high[k]));
    store16(direction[k], join16(low[k + 3], high[k + 3]));
  }
  store16(t_min, join16(low[6], high[6]));
  store16(t_max, join16(low[7], high[7]));
  for (std::size_t i = 0; i < kLanes; ++i) {
    exclude_a[i] = segment(i).exclude_a;
    exclude_b[i] = segment(i).exclude_b;
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

/// That along which most segments run farthest.
void Packet::choose_axis() {
  const Wide x = abs16(load16(direction[0])), y = abs16(load16(direction[1])),
             z = abs16(load16(direction[2]));
  const int along[3] = {std::popcount(less16(max16(y, z), x)),
                        std::popcount(less16(max16(z, x), y)),
                        std::popcount(less16(max16(x, y), z))};
  kz = along[0] > along[1] ? (along[0] > along[2] ? 0 : 2) : (along[1] > along[2] ? 1 : 2);
  kx = (kz + 1) % 3;
  ky = (kz + 2) % 3;
}

void Packet::make_hull(const WideTree& tree) {
  // Of each axis the lower bounds, and the negated upper bounds, of origins and ends.
  V4f corner[4];
  for (std::size_t k = 0; k < 3; ++k) {
    const Wide o = load16(origin[k]), e = madd16(load16(direction[k]), load16(t_max), o);
    const Wide zero = splat16(0);
    corner[k] = least_of_four(o, zero - o, e, zero - e);
  }
  corner[3] = corner[2];
  transpose4(corner);
  const V4f reach =
      max4(max4(abs4(corner[0]), abs4(corner[1])), max4(abs4(corner[2]), abs4(corner[3]))) +
      load4(tree.reach);
  const float farthest = std::max(reach[0], std::max(reach[1], reach[2]));
  // Far more than any rounding here and of the ends.
  const float pad = farthest * 0x1p-19f + 1e-36f;
  // Highest and lowest.
  const V4f starts[2] = {pad - corner[1], corner[0] - pad};
  const V4f ends[2] = {pad - corner[3], corner[2] - pad};
  const V4f least = splat4(farthest * 0x1p-40f + 1e-37f);
  const V4f none = splat4(0), most = splat4(std::numeric_limits<float>::max());
  for (std::size_t side = 0; side < 2; ++side) {
    V4f slope = ends[side] - starts[side];
    slope = abs4(slope) < least ? (side == 0 ? least : -least) : slope;
    const V4f inv = 1.0f / slope, start = -starts[side] * inv;
    // The highest point must reach the lower plane, the lowest one the upper plane.
    const V4i bounds_near = side == 0 ? slope > none : slope < none;
    store4(near_slope[side], bounds_near ? inv : none);
    store4(near_start[side], bounds_near ? start : -most);
    store4(far_slope[side], bounds_near ? none : inv);
    store4(far_start[side], bounds_near ? most : start);
  }
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
  Wide spans = zero;
  for (std::size_t k = 0; k < 3; ++k) {
    spans = max16(abs16(load16(origin[k])) + splat16(tree.reach[k]), spans);
  }
  store16(span, spans);
  for (std::size_t k = 0; k < 3; ++k) {
    const Wide o = load16(origin[k]), d = load16(direction[k]) * scales;
    backward[k] = less16(d, zero);
    const Wide tiny = select16(backward[k], splat16(-0x1p-40f), splat16(0x1p-40f));
    const Wide inv = one / select16(less16(abs16(d), splat16(0x1p-40f)), tiny, d);
    const Wide slack = madd16(abs16(o) + splat16(tree.reach[k]), splat16(0x1p-20f),
                              madd16(spans, splat16(0x1p-38f), splat16(1e-37f)));
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
