#include "core/lightmap/virtual_texel.h"

#include <algorithm>

#include "core/math/sobol.h"

namespace lightbatch::lightmap {

VirtualTexel::Value VirtualTexel::operator()(const TexelPoints& points,
                                             const radiosity::VirtualLights::ReceiverPatch& centre,
                                             int rays, std::uint32_t seed,
                                             radiosity::VirtualLights::Served& served,
                                             std::span<Rgb> by_group, BakeCounts& counts) const {
  Value value;
  if (lights_.is_empty()) return value;
  lights_.serve(centre, served);
  if (!(served.sum > 0)) return value;
  const OwenSobol8 sequence(seed);
  Receivers receivers(input_.scene, input_.layout, input_.direct.lift());
  for (int k = 0; k < rays; ++k) {
    const auto index = static_cast<std::uint32_t>(k);
    // A comb over the lights, which lie side by side as the elements do.
    const double part =
        (static_cast<double>(k) + static_cast<double>(sequence.coordinate(index, 0))) / rays;
    const std::size_t i = served.find(part * served.sum);
    if (!(served.by_light[i] > 0)) continue;
    const auto point =
        std::min(points.count - 1, static_cast<std::uint32_t>(sequence.coordinate(index, 1) *
                                                              static_cast<float>(points.count)));
    const radiosity::Receiver from = receivers(points.point[point], sequence.pair(index, 2));
    const radiosity::VirtualLights::Light& light = lights_[i];
    const Vec3d to = to_double(light.position) - to_double(from.frame.position);
    const double squared = dot(to, to);
    const double arrives = dot(to, to_double(from.frame.normal));
    const double leaves = -dot(to, to_double(light.normal));
    if (!(arrives > 0 && leaves > 0)) continue;
    const double share = arrives * leaves / (kPiDouble * squared * squared) * served.sum /
                         (static_cast<double>(served.by_light[i]) * rays);
    const Rgb seen =
        input_.direct.point_visibility(from, light.position, light.triangle, counts.rays);
    const Rgbd light_sum = to_double(light.flux * seen) * share;
    value.irradiance += light_sum;
    value.difference += (k % 2 == 0 ? 2.0 : -2.0) * light_sum.sum() / 3;
    if (!by_group.empty()) by_group[light.group] += to_float(light_sum);
  }
  return value;
}

}  // namespace lightbatch::lightmap
