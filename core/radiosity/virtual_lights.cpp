// Virtual point lights of the light that strong lights bring: Keller 1997 (Instant Radiosity).
// Deviations: points are dealt to elements by the flux that the first stage found there, so none
// is wasted on the outside of a building; they serve far receivers only, with the distance fixed
// by element, so that what they bring and what cosine rays meet add up to the whole without bias;
// and receivers pick among all of them by unoccluded irradiance.

#include "core/radiosity/virtual_lights.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/math/sampling.h"
#include "core/math/sobol.h"
#include "core/radiosity/area_sum.h"
#include "core/radiosity/element_rays.h"
#include "core/radiosity/resolved_light.h"

namespace lightbatch::radiosity {
namespace {

/// Radiosity where the light falls, against the mean irradiance from the hemisphere.
constexpr double kBright = 4;
/// Distance that is served, in spacings of the points.
constexpr double kSpacings = 3;
/// Points tried on an element for each that is due, at most, where the light reaches a part of it.
constexpr float kMostTries = 16;
/// Flux of such an element, at least, of what it would be wholly lit: few samples may have missed
/// the light.
constexpr float kLeastLit = 0.02f;

}  // namespace

VirtualLights::VirtualLights(const scene::Scene& scene, const Elements& elements,
                             const DirectLight& direct, const Solution& solution,
                             const VirtualLightOptions& options) {
  const std::uint32_t count = elements.count();
  if (options.count == 0 || solution.light_state.empty() || solution.indirect.empty()) return;
  double area = 0;
  for (ElementId e = 0; e < count; ++e) area += static_cast<double>(elements.covered_area(e));
  const double received =
      area_sum(elements, [&](ElementId e) { return to_double(solution.indirect[e]); }).sum();
  const auto bright = static_cast<float>(area > 0 ? kBright * received / area : 0);
  const auto receiver = [&](ElementId e, Vec2f ab) {
    return receiver_on(scene, elements, e, ab, direct.lift());
  };
  std::vector<double> flux(count);
  std::vector<std::uint8_t> tries(count, 1);
  double total = 0;
  for (ElementId e = 0; e < count; ++e) {
    if (solution.light_state[e] == 0) continue;
    Rgb open;
    bool doubtful = false;
    for_each_resolved(direct, solution, e, receiver(e, {0.5f, 0.5f}).frame,
                      [&](const PunctualLight&, const Rgb& lux, bool mixed) {
                        open += lux;
                        doubtful = doubtful || mixed;
                      });
    const float lit = (open * elements.reflectance(e)).sum();
    if (!(lit > bright)) continue;
    const float part =
        std::max(kLeastLit, (solution.radiosity[e] - solution.unresolved[e]).sum() / lit);
    if (doubtful) {
      tries[e] = static_cast<std::uint8_t>(std::clamp(std::ceil(1 / part), 1.0f, kMostTries));
    }
    flux[e] = static_cast<double>(elements.covered_area(e)) * static_cast<double>(part * lit);
    total += flux[e];
  }
  if (!(total > 0)) return;
  distance_.assign(count, 0.0f);
  RayCounts unused;
  double due = Random(item_seed(options.seed, 0, 60)).next_double();
  for (ElementId e = 0; e < count; ++e) {
    if (!(flux[e] > 0)) continue;
    // Points of an element on average; how many come now: one comb through all elements.
    const double share = static_cast<double>(options.count) * flux[e] / total;
    distance_[e] = static_cast<float>(std::max(
        options.nearest, kSpacings * std::sqrt(static_cast<double>(elements.area(e)) / share)));
    const double before = std::floor(due);
    due += share;
    const auto now = static_cast<std::uint32_t>(std::floor(due) - before);
    const OwenSobol2 points(static_cast<std::uint32_t>(item_seed(options.seed, e, 61)));
    const OwenSobol2 suns(static_cast<std::uint32_t>(item_seed(options.seed, e, 62)));
    const float each = elements.covered_area(e) / static_cast<float>(share * tries[e]);
    for (std::uint32_t s = 0; s < tries[e] * now; ++s) {
      const Vec2f ab = points.point(s);
      const Receiver at = receiver(e, ab);
      const ElementPoint p = elements.point(e, ab.x, ab.y);
      const Rgb reflectance = reflectance_at(direct.optics(), elements, e, p.triangle, p.u, p.v);
      for_each_resolved(
          direct, solution, e, at.frame,
          [&](const PunctualLight& light, const Rgb& open, bool doubtful) {
            const Rgb seen = doubtful ? direct.punctual_visibility(at, light, suns.point(s), unused)
                                      : Rgb{1, 1, 1};
            const Rgb sent = reflectance * open * seen * each;
            if (sent.is_black()) return;
            add({at.frame.position, at.frame.normal, sent, at.triangle, light.group}, distance_[e]);
          });
    }
  }
  finish();
}

void VirtualLights::add(const Light& light, float distance) {
  light_.push_back(light);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    position_[axis].push_back(light.position[axis]);
    normal_[axis].push_back(light.normal[axis]);
  }
  intensity_.push_back(light.flux.sum() / kPi);
  nearest_.push_back(distance * distance);
}

void VirtualLights::finish() {
  const std::size_t padded = (light_.size() + kRun - 1) / kRun * kRun;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    position_[axis].resize(padded, 0.0f);
    normal_[axis].resize(padded, 0.0f);
  }
  intensity_.resize(padded, 0.0f);
  nearest_.resize(padded, 1.0f);
}

void VirtualLights::serve(const ReceiverPatch& receiver, Served& served) const {
  constexpr std::size_t kLanes = 8;
  served.by_light.resize(intensity_.size());
  served.by_run.resize(intensity_.size() / kRun);
  served.sum = 0;
  const Vec3f p = receiver.position, n = receiver.normal;
  for (std::size_t run = 0; run < served.by_run.size(); ++run) {
    std::array<float, kLanes> sum{};
    for (std::size_t i = run * kRun; i < (run + 1) * kRun; i += kLanes) {
      for (std::size_t j = 0; j < kLanes; ++j) {
        const float x = position_[0][i + j] - p.x;
        const float y = position_[1][i + j] - p.y;
        const float z = position_[2][i + j] - p.z;
        const float squared = x * x + y * y + z * z;
        const float arrives = std::max(0.0f, x * n.x + y * n.y + z * n.z);
        const float leaves = std::max(
            0.0f, -(x * normal_[0][i + j] + y * normal_[1][i + j] + z * normal_[2][i + j]));
        const float lux = intensity_[i + j] * arrives * leaves / (squared * squared);
        served.by_light[i + j] = receiver.takes(squared, arrives, nearest_[i + j]) ? lux : 0.0f;
        sum[j] += served.by_light[i + j];
      }
    }
    float all = 0;
    for (const float s : sum) all += s;
    served.by_run[run] = all;
    served.sum += static_cast<double>(all);
  }
}

std::size_t VirtualLights::Served::find(double part) const {
  std::size_t run = 0;
  while (run + 1 < by_run.size() && part >= static_cast<double>(by_run[run])) {
    part -= static_cast<double>(by_run[run++]);
  }
  std::size_t i = run * kRun, last = i;
  for (const std::size_t end = i + kRun; i < end; ++i) {
    if (!(by_light[i] > 0)) continue;
    last = i;
    if (part < static_cast<double>(by_light[i])) break;
    part -= static_cast<double>(by_light[i]);
  }
  return last;
}

}  // namespace lightbatch::radiosity
