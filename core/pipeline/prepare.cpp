#include "core/pipeline/prepare.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/parallel.h"
#include "core/image/codecs.h"
#include "core/scene_in/read_scene.h"

namespace lightbatch::pipeline {
namespace {

/// Pixels this many times as bright as the mean are a sun, ...
constexpr double kSun = 100;
/// ... of which is told from this share of all light on.
constexpr double kSunShare = 0.2;

/// Hemisphere rays seldom meet a sun in a picture.
void warn_of_sun(const image::ImageRgb& map, std::vector<std::string>& warnings) {
  const auto over_sphere = [&](auto value) {
    double sum = 0;
    for (int y = 0; y < map.height; ++y) {
      const double height = std::sin(kPiDouble * (y + 0.5) / map.height);
      for (int x = 0; x < map.width; ++x) {
        const Rgb& pixel = map.at(x, y);
        sum += height *
               value(std::clamp(static_cast<double>(pixel.sum()), 0.0, 3 * optics::kMostRadiance));
      }
    }
    return sum;
  };
  const double whole = over_sphere([](double) { return 1.0; });
  const double light = over_sphere([](double v) { return v; });
  if (!(light > 0)) return;
  const double bright = kSun * light / whole;
  const double share = over_sphere([&](double v) { return v > bright ? v : 0.0; }) / light;
  if (share < kSunShare) return;
  const double size = over_sphere([&](double v) { return v > bright ? 1.0 : 0.0; }) / whole;
  char text[256];
  std::snprintf(
      text, sizeof text,
      "the sky picture has a sun (%.0f %% of its light in %.2g %% of the sphere), which rays "
      "seldom meet: for small errors take it out and give it as a directional light",
      100 * share, 100 * size);
  warnings.emplace_back(text);
}

Result<optics::Environment> read_sky(const JobOptions& options, const JobInput& input,
                                     std::vector<std::string>& warnings) {
  if (options.sky_file.empty()) {
    return optics::Environment(Rgb::grey(static_cast<float>(options.sky_nits)));
  }
  const auto file = input.files.find(options.sky_file);
  if (file == input.files.end()) {
    return bad_option("the sky file " + options.sky_file + " is not among the job's files");
  }
  LB_ASSIGN_OR_RETURN(const Bytes bytes, read_file(file->second));
  LB_ASSIGN_OR_RETURN(image::ImageRgb map, image::decode_image_rgb(bytes, options.sky_file));
  warn_of_sun(map, warnings);
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
  LB_ASSIGN_OR_RETURN(p.sky, read_sky(options, input, p.scene->warnings));
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
  LB_ASSIGN_OR_RETURN(p.effects, plan::make_plan(*p.scene, *p.optics, *p.caster, p.sky,
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
  if (!p.effects.on(plan::Effect::kSky)) p.sky = optics::Environment();
  // From here on it gives clusters; rays have the caster.
  p.tree.compact();
  clock.stop();
  return p;
}

}  // namespace lightbatch::pipeline
