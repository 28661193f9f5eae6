#include "core/pipeline/prepare.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/parallel.h"
#include "core/image/codecs.h"
#include "core/scene_in/read_scene.h"

namespace lightbatch::pipeline {
namespace {

/// Told as evidence of the sky.
std::string describe(const optics::SkySun& sun) {
  const Vec3f& d = sun.towards();
  char text[160];
  std::snprintf(text, sizeof text, "a sun of %.4g lux at (%.2f, %.2f, %.2f)",
                static_cast<double>(luminance(to_double(sun.illuminance()))),
                static_cast<double>(d.x), static_cast<double>(d.y), static_cast<double>(d.z));
  return text;
}

/// Suns of a sky picture are lights of their own, but not where the sky is off.
void split_sky(Prepared& p) {
  plan::Decision& decision = p.effects[plan::Effect::kSky];
  if (!decision.on) p.whole_sky = optics::Environment();
  optics::SplitSky split = optics::split_suns(p.whole_sky);
  p.sky = std::move(split.rest);
  p.suns = std::move(split.suns);
  for (const optics::SkySun& sun : p.suns) {
    if (decision.evidence.size() < plan::kMaxEvidence) decision.evidence.push_back(describe(sun));
  }
}

Result<optics::Environment> read_sky(const JobOptions& options, const JobInput& input) {
  if (options.sky_file.empty()) {
    return optics::Environment(Rgb::grey(static_cast<float>(options.sky_nits)));
  }
  const auto file = input.files.find(options.sky_file);
  if (file == input.files.end()) {
    return bad_option("the sky file " + options.sky_file + " is not among the job's files");
  }
  LB_ASSIGN_OR_RETURN(const Bytes bytes, read_file(file->second));
  LB_ASSIGN_OR_RETURN(image::ImageRgb map, image::decode_image_rgb(bytes, options.sky_file));
  return optics::Environment(std::move(map));
}

std::vector<Aabb> triangle_boxes(const scene::Scene& scene) {
  std::vector<Aabb> boxes(scene.triangles.size());
  parallel_for(boxes.size(), 16384, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const Vec3f& p : scene.corners(static_cast<std::uint32_t>(i))) boxes[i].add(p);
    }
  });
  return boxes;
}

std::unique_ptr<rays::Caster> make_caster(const Prepared& p) {
  std::vector<std::array<std::uint32_t, 3>> triangles(p.scene->triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) triangles[i] = p.scene->triangles[i].vertex;
  return std::make_unique<rays::Caster>(p.tree, p.scene->positions, triangles,
                                        p.optics->surfaces());
}

/// Effects of materials that were switched off are not read at all.
optics::Optics::Options optics_options(const plan::EffectPlan& effects) {
  using plan::Effect;
  const auto wanted = [&](Effect e) { return effects.on(e) || !effects[e].called_for; };
  return {wanted(Effect::kAlphaCutout),        wanted(Effect::kAlphaBlend),
          wanted(Effect::kTransmission),       wanted(Effect::kTexturedReflectance),
          wanted(Effect::kTexturedEmission),   wanted(Effect::kTwoSided),
          wanted(Effect::kDiffuseTransmission)};
}

}  // namespace

Result<Prepared> prepare(const JobOptions& options, const JobInput& input, StageClock& clock,
                         const Progress& progress) {
  Prepared p;
  p.target_error = options.target_error > 0 ? options.target_error : 0.02;
  clock.start("read");
  progress.report("read", 0);
  LB_ASSIGN_OR_RETURN(p.document, gltf::read_document(input.files, input.scene));
  LB_ASSIGN_OR_RETURN(scene::Scene scene, scene_in::read_scene(p.document));
  p.scene = std::make_unique<scene::Scene>(std::move(scene));
  LB_ASSIGN_OR_RETURN(p.whole_sky, read_sky(options, input));
  if (progress.cancelled()) return cancelled();

  clock.start("hierarchy");
  progress.report("hierarchy", 0);
  const bool light = options.kind != JobKind::kBake || options.lightmaps;
  // Batches are far above the nodes that the second stage of construction mends.
  p.tree = hierarchy::build(triangle_boxes(*p.scene), {.reinsertion = light});
  if (light) {
    p.optics = std::make_unique<optics::Optics>(*p.scene);
    p.caster = make_caster(p);
  }
  clock.stop();
  p.tree_seconds = clock.stages().back().seconds;
  if (progress.cancelled()) return cancelled();

  p.tree_statistics = hierarchy::measure(p.tree);
  if (!light) return p;
  clock.start("plan");
  progress.report("plan", 0);
  LB_ASSIGN_OR_RETURN(p.effects, plan::make_plan(*p.scene, *p.optics, *p.caster, p.whole_sky,
                                                 p.target_error, options.effects));
  plan::Decision& directional = p.effects[plan::Effect::kDirectionalLightmaps];
  if (directional.on && options.kind == JobKind::kBake && options.carrier == Carrier::kPortable) {
    directional.on = false;
    directional.reason += "; the portable carrier has no lightmap";
  }
  if (!options.effects.empty()) {
    p.optics = std::make_unique<optics::Optics>(*p.scene, optics_options(p.effects));
    p.caster = make_caster(p);
  }
  split_sky(p);
  // From here on it gives clusters; rays have the caster.
  p.tree.compact();
  clock.stop();
  return p;
}

}  // namespace lightbatch::pipeline
