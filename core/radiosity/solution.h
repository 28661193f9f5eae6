#pragma once

#include <cstdint>
#include <vector>

#include "core/math/rgb.h"
#include "core/radiosity/direct_light.h"
#include "core/radiosity/elements.h"

namespace lightbatch::radiosity {

/// Punctual lights whose sharp shadows are kept apart from the elements, strongest first.
constexpr std::size_t kResolvedLights = 8;

/// How much of an element a resolved light reaches.
enum class LightState : std::uint8_t { kDark = 0, kLit = 1, kMixed = 2 };

/// What every element sends out, ready to be read where a ray lands.
///
/// Radiosity B = rho (E_direct + E_sky + E_indirect), without what the element emits itself:
/// emission is direct light, computed at the receiver. Light of the resolved lights is in
/// `radiosity` as a mean too, and so is that of emitters on uneven elements; a reader that wants
/// them sharp takes `unresolved` and adds the lights itself (lit: formula; mixed: formula and one
/// shadow ray; uneven: one ray to an emitter).
struct Solution {
  std::vector<Rgb> radiosity;           // per element, lm/m2, all light
  std::vector<Rgb> unresolved;          // per element, without the resolved lights' direct part
  std::vector<Rgb> irradiance;          // per element, lux, all light
  std::vector<Rgb> indirect;            // per element, lux, from the hemisphere: sky and
                                        // interreflection
  std::vector<float> crowding;          // per element, share of its hemisphere that is nearer
                                        // than 1.5 element edges; empty: not known
  std::vector<std::uint32_t> resolved;  // indices of punctual lights, at most kResolvedLights
  GroupedLight unresolved_by_group;     // per element, unresolved by light group; empty: not asked
  std::vector<std::uint16_t> light_state;  // 2 bits per resolved light; empty when there is none
  std::vector<std::uint8_t> uneven;  // per element, 1: emitters light a part of it far more than
                                     // the rest, and by much; empty when there are no emitters

  struct Statistics {
    std::uint64_t elements = 0;
    std::uint64_t links = 0;
    int iterations = 0;
    double residual = 0;  // of the last iteration, relative
    Rgbd emitted;         // lm: emission, punctual and sky light that reached elements, directly
    Rgbd absorbed;        // lm: by elements
    Rgbd escaped;         // lm: reflected light that left the scene or met absorbing backs
    std::uint64_t memory_bytes = 0;
    RayCounts rays;
  } statistics;

  bool is_uneven(ElementId e) const { return !uneven.empty() && uneven[e] != 0; }
  LightState state(ElementId e, std::size_t resolved_index) const {
    return static_cast<LightState>((light_state[e] >> (2 * resolved_index)) & 3u);
  }
};

}  // namespace lightbatch::radiosity
