// The float test of a leaf's triangles against one ray; included by kernel_impl.h only.

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

/// Errors, u = 2^-24: with corners at most m from the ray in sheared x and y and at most M along
/// it, x and y are off by at most u (2 m + 5 s M), so the edge functions by u m (12 m + 20 s M),
/// where s is the largest factor of the shear, at least 1. First with s times the size of the leaf
/// as m: its box was met, so a point of the ray lies in it (and its slack). What that does not rule
/// out is looked at with its own m.
template <bool kSteep>
struct LeafTestOf {
  static constexpr float kUnit = 0x1p-24f;
  V8f ox, oy, oz, sx, sy, sz;
  std::size_t kx, ky, kz;
  float slack;
  float steep = 1;  // s

  LB_INLINE LeafTestOf() = default;
  LB_INLINE explicit LeafTestOf(const BoxRay& r)
      : ox(splat8(r.ox)),
        oy(splat8(r.oy)),
        oz(splat8(r.oz)),
        sx(splat8(-r.sx)),
        sy(splat8(-r.sy)),
        sz(splat8(r.sz)),
        kx(r.kx),
        ky(r.ky),
        kz(r.kz),
        slack(r.span * 0x1p-17f) {}

  /// `low` and `high` bound t where `maybe`; they are set if any is.
  LB_INLINE LeafMasks operator()(const Leaf& leaf, const Limits& limits, V8f& low,
                                 V8f& high) const {
    const std::size_t step = leaf.count, three = 3 * step;
    const float* px = leaf.corners() + kx * step;
    const float* py = leaf.corners() + ky * step;
    const float* pz = leaf.corners() + kz * step;
    V8f x[3], y[3], z[3];
    for (std::size_t k = 0; k < 3; ++k) {
      z[k] = load8(pz + k * three) - oz;
      x[k] = madd8(sx, z[k], load8(px + k * three) - ox);
      y[k] = madd8(sy, z[k], load8(py + k * three) - oy);
    }
    const V8f u = madd8(x[2], y[1], -(y[2] * x[1]));
    const V8f v = madd8(x[0], y[2], -(y[0] * x[2]));
    const V8f w = madd8(x[1], y[0], -(y[1] * x[0]));
    V8f flat = splat8(leaf.size() + slack);
    V8f deep = max8(abs8(z[0]), max8(abs8(z[1]), abs8(z[2])));
    if constexpr (kSteep) {
      flat *= splat8(steep);
      deep *= splat8(steep);
    }
    const V8f coarse = (flat + deep) * flat * (24 * kUnit) + 1e-36f;
    const V8f least = min8(u, min8(v, w));
    const V8f most = max8(u, max8(v, w));
    // A NaN rules nothing out.
    unsigned maybe = ((1u << step) - 1) & ~mask8((least < -coarse) & (most > coarse));
    if (maybe == 0) return {0, 0};
    const V8f m = max8(max8(max8(abs8(x[0]), abs8(y[0])), max8(abs8(x[1]), abs8(y[1]))),
                       max8(abs8(x[2]), abs8(y[2])));
    const V8f error = (m + deep) * m * (24 * kUnit) + 1e-36f;
    maybe &= ~mask8((least < -error) & (most > error));
    if (maybe == 0) return {0, 0};
    const V8i inside = (least > error) | (most < -error);
    const V8f det = u + v + w;
    const V8f t = (u * z[0] + v * z[1] + w * z[2]) / det * sz;
    // The weights of a hit inside have one sign: their errors move t within the triangle's depth.
    const V8f spread = max8(z[0], max8(z[1], z[2])) - min8(z[0], min8(z[1], z[2]));
    const V8f t_error = (4.0f * spread * (error / abs8(det)) + 16 * kUnit * deep) * abs8(sz) +
                        abs8(t) * (8 * kUnit);
    low = t - t_error;
    high = t + t_error;
    const V8i beyond = (low > splat8(limits.upper)) | (high < splat8(limits.lower));
    const V8i within = (low > splat8(limits.tight_lower)) & (high < splat8(limits.tight_upper));
    return {maybe & ~mask8(inside & beyond), maybe & mask8(inside & within)};
  }
};
using LeafTest = LeafTestOf<false>;  // sheared along the longest axis
using SteepLeafTest = LeafTestOf<true>;
