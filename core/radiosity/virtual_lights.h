#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/radiosity/direct_light.h"
#include "core/radiosity/elements.h"
#include "core/radiosity/solution.h"

namespace lightbatch::radiosity {

struct VirtualLightOptions {
  std::size_t count = 2048;  // about so many for each resolved light; 0: none
  double nearest = 0;        // metres: what lies nearer is never served
  std::uint64_t seed = 1;
};

/// Points on what the resolved lights shine at, where that sends on far more than the rest: patches
/// of sun in a room. Each stands for an equal part of the light sent on, so that receivers ask for
/// it by shadow rays, where cosine rays would meet a small bright patch by luck. Receivers are
/// served from a distance, against how far the points lie apart; nearer ones have to meet the patch
/// themselves. Immutable; thread-safe.
class VirtualLights {
 public:
  VirtualLights() = default;
  VirtualLights(const scene::Scene& scene, const Elements& elements, const DirectLight& direct,
                const Solution& solution, const VirtualLightOptions& options);

  struct Light {
    Vec3f position, normal;
    Rgb flux;                    // sent on, lm
    std::uint32_t triangle = 0;  // that it lies on
    std::uint32_t group = 0;     // of lights
  };
  bool is_empty() const { return light_.empty(); }
  std::size_t count() const { return light_.size(); }
  const Light& operator[](std::size_t i) const { return light_[i]; }

  /// One point and direction for all points of a receiver, and how far these differ: lights are
  /// picked by what they bring to the one, so that they must bring about as much to the others.
  struct ReceiverPatch {
    Vec3f position, normal;
    float extent = 0;  // metres between positions, at most
    float tilt = 0;    // length of the difference of unit normals, at most

    /// Whether to serve what lies there. lift: towards it along the normal, metres.
    bool takes(float squared, float lift, float nearest_squared) const {
      return squared >= std::max(nearest_squared, 4 * extent * extent) &&
             lift * lift >= tilt * tilt * squared;
    }
  };

  /// What the resolved lights bring to a point of an element's side is served to the receiver, by
  /// the same rule as in serve(): together with what rays meet elsewhere it is the whole.
  bool serves(ElementId e, const ReceiverPatch& receiver, const optics::SurfaceFrame& at) const {
    if (distance_.empty() || !(distance_[e] > 0)) return false;
    const Vec3f to = at.position - receiver.position;
    const float lift = dot(to, receiver.normal);
    return lift > 0 && dot(to, at.normal) < 0 &&
           receiver.takes(dot(to, to), lift, distance_[e] * distance_[e]);
  }

  /// Lights are summed up in runs of this many.
  static constexpr std::size_t kRun = 64;
  /// Unoccluded irradiance at a receiver, channel sum, lux.
  struct Served {
    std::vector<float> by_light, by_run;
    double sum = 0;
    /// The light under the part [0, sum) of the sum.
    std::size_t find(double part) const;
  };
  void serve(const ReceiverPatch& receiver, Served& served) const;

 private:
  void add(const Light& light, float distance);
  void finish();

  std::vector<Light> light_;
  std::vector<float> distance_;  // per element, metres: served from here on; 0: not at all
  /// Of the lights, padded to whole runs: position, normal, flux / pi (channel sum), distance^2.
  std::array<std::vector<float>, 3> position_, normal_;
  std::vector<float> intensity_, nearest_;
};

}  // namespace lightbatch::radiosity
