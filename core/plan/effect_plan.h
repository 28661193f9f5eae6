#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/status.h"
#include "core/optics/environment.h"
#include "core/optics/optics.h"
#include "core/rays/caster.h"
#include "core/scene/scene.h"

namespace lightbatch::plan {

/// The effects a scene may call for; what is off costs nothing.
enum class Effect : std::uint8_t {
  kPointLights,
  kSpotLights,
  kDirectionalLights,
  kEmitters,
  kSky,
  kInterreflection,
  kShadows,
  kTexturedReflectance,
  kTexturedEmission,
  kAlphaCutout,
  kAlphaBlend,
  kTransmission,
  kTwoSided,
  kDiffuseTransmission,
  kDirectionalLightmaps,
  kProbes,
};
constexpr std::size_t kEffectCount = 16;

/// "point_lights", "sky"...: the word of reports and of --effects.
std::string_view effect_name(Effect effect);

struct Decision {
  bool on = false;
  /// The scene calls for it (on, unless overridden or not simulated by this version).
  bool called_for = false;
  bool simulated = true;              // false: this version has no simulation of it
  std::string reason;                 // one sentence
  std::vector<std::string> evidence;  // materials, lights or nodes by name; at most kMaxEvidence
  double cost_share = 0;              // of all rays, those cast for it; shares overlap
};
constexpr std::size_t kMaxEvidence = 8;

struct EffectPlan {
  std::array<Decision, kEffectCount> decisions;
  bool on(Effect e) const { return decisions[static_cast<std::size_t>(e)].on; }
  Decision& operator[](Effect e) { return decisions[static_cast<std::size_t>(e)]; }
  const Decision& operator[](Effect e) const { return decisions[static_cast<std::size_t>(e)]; }
};

/// Reads what a scene contains and decides. overrides: "+name" or "-name"; an unknown name, or
/// "+" for an effect that has nothing to act on, is BAD_OPTION. target_error: relRMSE; an effect
/// that cannot matter at it is off.
Result<EffectPlan> make_plan(const scene::Scene& scene, const optics::Optics& optics,
                             const rays::Caster& caster, const optics::Environment& sky,
                             double target_error, const std::vector<std::string>& overrides);

/// Whether any triangle can stand between two points of the scene's surfaces (or a surface point
/// and a light): false for convex rooms and single planes. Scenes above a few hundred triangles
/// count as true.
bool can_shadow(const scene::Scene& scene, bool light_from_outside);

}  // namespace lightbatch::plan
