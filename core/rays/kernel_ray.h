// A ray made ready for boxes and triangles; included by kernel_impl.h only.

/// Distances inside the traversal are t / scale, so that the scaled direction has its largest
/// component in [0.5, 1) (barring extreme directions). Set up without branches on its data.
struct BoxRay {
  alignas(16) float inverse[4];
  alignas(16) float near_offset[4];  // near distance = near plane * inverse + near_offset
  alignas(16) float far_offset[4];
  std::size_t near_plane[3];  // places in the planes of a node
  std::size_t far_plane[3];
  bool valid = false;
  float inverse_scale = 1;
  std::size_t kx, ky, kz;
  float ox, oy, oz;  // origin in the order kx, ky, kz
  float sx, sy, sz;  // shear, and 1 / direction[kz], scaled
  float span;        // largest |coordinate| of the ray's origin or the boxes, added

  BoxRay(const WideTree& tree, const Ray& ray) {
    // Fourth lanes hold whatever follows in the ray.
    const V4f o = load4(&ray.origin.x), d = load4(&ray.direction.x);
    const V4f size = abs4(d);
    const float ax = size[0], ay = size[1], az = size[2];
    const float largest = std::max(ax, std::max(ay, az));
    const V4f none = (o - o) + (d - d);  // NaN where either is not finite
    valid = (largest > 0) & (none[0] + none[1] + none[2] == 0);
    const std::uint32_t exponent =
        std::min(std::max(std::bit_cast<std::uint32_t>(largest) >> 23, 26u), 226u);
    const float scale = std::bit_cast<float>((253u - exponent) << 23);
    inverse_scale = std::bit_cast<float>((exponent + 1u) << 23);
    const V4f reach = abs4(o) + load4(tree.reach);
    span = std::max(reach[0], std::max(reach[1], reach[2]));
    // Smaller components move the ray by less than the slack over the whole span.
    const V4f scaled = d * scale;
    V4i bits;
    std::memcpy(&bits, &scaled, sizeof bits);
    const V4i signs = bits & std::numeric_limits<std::int32_t>::min();
    V4f least = splat4(0x1p-40f);
    V4i least_bits;
    std::memcpy(&least_bits, &least, sizeof least_bits);
    least_bits |= signs;
    std::memcpy(&least, &least_bits, sizeof least);
    const V4f safe = abs4(scaled) < splat4(0x1p-40f) ? least : scaled;
    const V4f slack = reach * 0x1p-20f + (0x1p-38f * span + 1e-37f);
    const V4f inv = 1.0f / safe;
    const V4f offset = -(o * inv), pad = slack * abs4(inv);
    const V4f nearer = offset - pad, farther = offset + pad;
    std::memcpy(inverse, &inv, sizeof inverse);
    std::memcpy(near_offset, &nearer, sizeof near_offset);
    std::memcpy(far_offset, &farther, sizeof far_offset);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t backward = static_cast<std::uint32_t>(bits[k]) >> 31;
      near_plane[k] = (k + 3 * backward) * kWidth;
      far_plane[k] = (k + 3 - 3 * backward) * kWidth;
    }
    // As ExactTest chooses it.
    static constexpr std::uint8_t kLargest[8] = {2, 2, 2, 0, 1, 2, 1, 0};
    const std::uint8_t z =
        kLargest[(ax > ay ? 1u : 0u) + (ax > az ? 2u : 0u) + (ay > az ? 4u : 0u)];
    static constexpr std::uint8_t kNext[5] = {0, 1, 2, 0, 1};
    kz = z;
    kx = kNext[z + 1];
    ky = kNext[z + 2];
    alignas(16) float origin[4], direction[4];
    std::memcpy(origin, &o, sizeof origin);
    std::memcpy(direction, &scaled, sizeof direction);
    ox = origin[kx];
    oy = origin[ky];
    oz = origin[kz];
    sz = inverse[kz];
    sx = direction[kx] * sz;
    sy = direction[ky] * sz;
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
    return x + std::abs(x) * 0x1p-20f + 1e-37f;
  }
  float tight_upper_limit(float t) const {
    const float x = t * inverse_scale;
    return x - std::abs(x) * 0x1p-20f - 1e-37f;
  }
};

/// Which of the eight boxes the ray meets between two distances, and where it enters them.
struct BoxTest {
  V8f inverse[3], near_offset[3], far_offset[3], lower;
  std::size_t near_plane[3], far_plane[3];

  LB_INLINE BoxTest(const BoxRay& r, float lower_limit) : lower(splat8(lower_limit)) {
    for (std::size_t k = 0; k < 3; ++k) {
      inverse[k] = splat8(r.inverse[k]);
      near_offset[k] = splat8(r.near_offset[k]);
      far_offset[k] = splat8(r.far_offset[k]);
      near_plane[k] = r.near_plane[k];
      far_plane[k] = r.far_plane[k];
    }
  }
  // A NaN (from infinities only) is replaced by the other operand: the box is kept.
  LB_INLINE V8i operator()(const WideNode& node, V8f upper, V8f& near) const {
    const float* planes = &node.lower[0][0];
    near = max8(madd8(load8(planes + near_plane[0]), inverse[0], near_offset[0]), lower);
    V8f far = min8(madd8(load8(planes + far_plane[0]), inverse[0], far_offset[0]), upper);
    near = max8(madd8(load8(planes + near_plane[1]), inverse[1], near_offset[1]), near);
    far = min8(madd8(load8(planes + far_plane[1]), inverse[1], far_offset[1]), far);
    near = max8(madd8(load8(planes + near_plane[2]), inverse[2], near_offset[2]), near);
    far = min8(madd8(load8(planes + far_plane[2]), inverse[2], far_offset[2]), far);
    return near <= far;
  }
};
