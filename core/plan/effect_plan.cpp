#include "core/plan/effect_plan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/plan/sky_probes.h"

namespace lightbatch::plan {
namespace {

using scene::LightKind;
using scene::Material;
using scene::Scene;

constexpr std::array<std::string_view, kEffectCount> kNames{"point_lights",
                                                            "spot_lights",
                                                            "directional_lights",
                                                            "emitters",
                                                            "sky",
                                                            "interreflection",
                                                            "shadows",
                                                            "textured_reflectance",
                                                            "textured_emission",
                                                            "alpha_cutout",
                                                            "alpha_blend",
                                                            "transmission",
                                                            "two_sided",
                                                            "diffuse_transmission",
                                                            "directional_lightmaps",
                                                            "probes"};

std::string material_name(const Scene& scene, std::uint32_t material) {
  const Material& m = scene.materials[material];
  return m.name.empty() ? "material " + std::to_string(material) : m.name;
}

std::string light_name(const scene::Light& light) {
  return light.name.empty() ? "light at node " + std::to_string(light.node) : light.name;
}

/// Which materials have at least one triangle for which `holds`.
template <typename Holds>
std::set<std::uint32_t> materials_where(const Scene& scene, Holds holds) {
  std::set<std::uint32_t> found;
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
    if (holds(i)) found.insert(scene.objects[scene.triangles[i].object].material);
  }
  return found;
}

void decide(Decision& d, const Scene& scene, const std::set<std::uint32_t>& materials,
            const std::string& yes, const std::string& no) {
  d.called_for = !materials.empty();
  d.reason = d.called_for ? std::to_string(materials.size()) + " " + yes : no;
  for (const std::uint32_t m : materials) {
    if (d.evidence.size() == kMaxEvidence) break;
    d.evidence.push_back("material " + material_name(scene, m));
  }
}

/// Where moving meshes can be, in recentred coordinates.
Aabb moving_box(const Scene& scene) {
  Aabb box;
  for (const scene::MovingMesh& moving : scene.moving) {
    box.add(to_float(moving.swept.lower - scene.origin));
    box.add(to_float(moving.swept.upper - scene.origin));
  }
  return box;
}

void decide_lights(EffectPlan& plan, const Scene& scene) {
  constexpr std::array<Effect, 3> kEffects{Effect::kPointLights, Effect::kSpotLights,
                                           Effect::kDirectionalLights};
  Aabb lit = scene.box;
  lit.add(moving_box(scene));
  for (std::size_t k = 0; k < kEffects.size(); ++k) {
    const auto kind = static_cast<LightKind>(k);
    Decision& d = plan[kEffects[k]];
    std::size_t reaching = 0, all = 0;
    for (const scene::Light& light : scene.lights) {
      if (light.kind != kind) continue;
      ++all;
      if (light.intensity.is_black()) continue;
      if (light.range > 0 && kind != LightKind::kDirectional &&
          lit.distance_to(light.position) >= light.range) {
        continue;
      }
      ++reaching;
      if (d.evidence.size() < kMaxEvidence) d.evidence.push_back(light_name(light));
    }
    d.called_for = reaching > 0;
    d.reason = reaching > 0
                   ? std::to_string(reaching) + " of " + std::to_string(all) + " reach geometry"
               : all > 0 ? "none of " + std::to_string(all) + " reaches geometry"
                         : "the scene has none";
  }
}

void decide_sky(EffectPlan& plan, const Scene& scene, const optics::Optics& optics,
                const rays::Caster& caster, const optics::Environment& sky, bool forced) {
  Decision& d = plan[Effect::kSky];
  if (sky.is_black()) {
    d.reason = "the request brings none";
    return;
  }
  if (scene.triangles.empty() && scene.moving.empty()) {
    d.reason = "there is no surface";
    return;
  }
  const SkyProbes surfaces = probe_surfaces(scene, optics, caster);
  const SkyProbes moving = probe_moving(scene, optics, caster);
  // The caller may know of a way out that no probe found.
  d.called_for = surfaces.escaped + moving.escaped > 0 || forced;
  d.reason = std::to_string(surfaces.escaped) + " of " + std::to_string(surfaces.cast) +
             " probe rays leave the scene";
  if (!scene.moving.empty()) {
    d.reason += ", " + std::to_string(moving.escaped) + " of " + std::to_string(moving.cast) +
                " from where meshes move";
  }
}

void decide_interreflection(EffectPlan& plan, const Scene& scene, bool any_light,
                            double target_error) {
  Decision& d = plan[Effect::kInterreflection];
  float brightest = 0;
  for (const Material& m : scene.materials) {
    brightest = std::max(
        brightest,
        std::max(m.base_color.max(), m.diffuse_transmission * m.diffuse_transmission_color.max()) *
            (1.0f - (m.metallic_texture.present() ? 0.0f : m.metallic)));
  }
  const bool to_probes = !scene.moving.empty() && !scene.triangles.empty();
  const bool mutual = to_probes || can_shadow(scene, false) || [&] {
    // A convex room: surfaces face each other unless all lie in one plane.
    if (scene.triangles.empty()) return false;
    const auto c = scene.corners(0);
    const Vec3d a = to_double(c[0]);
    const Vec3d n = normalized(cross(to_double(c[1]) - a, to_double(c[2]) - a));
    return std::any_of(scene.positions.begin(), scene.positions.end(), [&](const Vec3f& p) {
      return std::fabs(dot(n, to_double(p) - a)) > 1e-6 * static_cast<double>(scene.box.diagonal());
    });
  }();
  d.called_for = any_light && mutual && static_cast<double>(brightest) > 0.1 * target_error;
  d.reason = !any_light     ? "there is no light"
             : !mutual      ? "no surface sees another"
             : d.called_for ? "surfaces that see each other reflect up to " +
                                  std::to_string(static_cast<int>(
                                      std::lround(100 * static_cast<double>(brightest)))) +
                                  " %"
                            : "reflectances are below a tenth of the error asked for";
}

void decide_probes(Decision& d, const Scene& scene, bool any_light) {
  std::set<std::string> names;
  for (const scene::MovingMesh& moving : scene.moving) {
    names.insert("node " + std::to_string(moving.node) + " " + moving.name);
  }
  d.called_for = any_light && !names.empty();
  d.reason = names.empty() ? "nothing moves"
             : !any_light  ? "there is no light"
                           : std::to_string(names.size()) + " nodes with meshes move";
  for (const std::string& name : names) {
    if (d.evidence.size() == kMaxEvidence) break;
    d.evidence.push_back(name);
  }
}

Status apply_overrides(EffectPlan& plan, const std::vector<std::string>& overrides) {
  for (const std::string& text : overrides) {
    const std::string name = text.empty() ? text : text.substr(1);
    const auto found = std::find(kNames.begin(), kNames.end(), name);
    if (text.size() < 2 || (text[0] != '+' && text[0] != '-') || found == kNames.end()) {
      std::string known;
      for (const std::string_view n : kNames) known += (known.empty() ? "" : ", ") + std::string(n);
      return bad_option("effect '" + text + "': write +name or -name with one of " + known);
    }
    Decision& d = plan.decisions[static_cast<std::size_t>(found - kNames.begin())];
    if (text[0] == '-') {
      d.on = false;
      d.reason += "; switched off by the caller";
    } else if (!d.simulated) {
      return bad_option("effect " + name + ": this version does not simulate it");
    } else if (!d.called_for && name != "shadows" && name != "interreflection") {
      return bad_option("effect " + name + ": nothing to act on (" + d.reason + ")");
    } else {
      d.on = true;
      d.reason += "; switched on by the caller";
    }
  }
  return {};
}

}  // namespace

std::string_view effect_name(Effect effect) { return kNames[static_cast<std::size_t>(effect)]; }

Result<EffectPlan> make_plan(const Scene& scene, const optics::Optics& optics,
                             const rays::Caster& caster, const optics::Environment& sky,
                             double target_error, const std::vector<std::string>& overrides) {
  EffectPlan plan;
  decide_lights(plan, scene);
  decide(plan[Effect::kEmitters], scene,
         materials_where(scene, [&](std::uint32_t i) { return optics.emits(i); }), "materials emit",
         "no material emits");
  const bool forced_sky = std::find(overrides.begin(), overrides.end(), "+sky") != overrides.end();
  decide_sky(plan, scene, optics, caster, sky, forced_sky);
  const bool any_light = plan[Effect::kPointLights].called_for ||
                         plan[Effect::kSpotLights].called_for ||
                         plan[Effect::kDirectionalLights].called_for ||
                         plan[Effect::kEmitters].called_for || plan[Effect::kSky].called_for;
  decide_interreflection(plan, scene, any_light, target_error);
  Decision& shadows = plan[Effect::kShadows];
  shadows.called_for = any_light && can_shadow(scene, plan[Effect::kSky].called_for);
  shadows.reason = shadows.called_for
                       ? "surfaces can stand between others and their light"
                       : "nothing can stand between two surfaces, or a surface and a light";
  decide(plan[Effect::kTexturedReflectance], scene,
         materials_where(scene, [&](std::uint32_t i) { return optics.textured_reflectance(i); }),
         "materials vary over their triangles", "no reflectance varies over a triangle");
  decide(plan[Effect::kTexturedEmission], scene,
         materials_where(scene, [&](std::uint32_t i) { return optics.textured_emission(i); }),
         "emitting materials vary over their triangles", "no emission varies over a triangle");
  const auto filtered = [&](std::uint32_t i) {
    return optics.surfaces()[i] == rays::Surface::kFiltered;
  };
  decide(plan[Effect::kAlphaCutout], scene,
         materials_where(scene,
                         [&](std::uint32_t i) {
                           return filtered(i) &&
                                  scene.material_of(i).alpha_mode == scene::AlphaMode::kMask;
                         }),
         "materials have triangles with texels on both sides of the cutoff",
         "no triangle is cut out in part");
  decide(plan[Effect::kAlphaBlend], scene,
         materials_where(scene,
                         [&](std::uint32_t i) {
                           return filtered(i) &&
                                  scene.material_of(i).alpha_mode == scene::AlphaMode::kBlend;
                         }),
         "materials let light through by alpha", "no material blends");
  decide(plan[Effect::kTransmission], scene,
         materials_where(
             scene,
             [&](std::uint32_t i) { return filtered(i) && scene.material_of(i).transmission > 0; }),
         "materials transmit (thin sheets; Fresnel and refraction are left out)",
         "no material transmits");
  decide(plan[Effect::kTwoSided], scene,
         materials_where(scene, [&](std::uint32_t i) { return optics.double_sided(i); }),
         "materials are double-sided", "no material is double-sided");
  decide(plan[Effect::kDiffuseTransmission], scene,
         materials_where(
             scene, [&](std::uint32_t i) { return any_light && optics.transmits_diffusely(i); }),
         "materials transmit diffusely",
         any_light ? "no material transmits diffusely" : "there is no light");
  decide(plan[Effect::kDirectionalLightmaps], scene,
         materials_where(scene,
                         [&](std::uint32_t i) {
                           const Material& m = scene.material_of(i);
                           return any_light && m.has_normal_map && !m.unlit;
                         }),
         "lit materials have normal maps",
         any_light ? "no lit material has a normal map" : "there is no light");
  decide_probes(plan[Effect::kProbes], scene, any_light);
  for (Decision& d : plan.decisions) d.on = d.called_for && d.simulated;
  LB_RETURN_IF_ERROR(apply_overrides(plan, overrides));
  return plan;
}

}  // namespace lightbatch::plan
