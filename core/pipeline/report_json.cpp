#include "core/pipeline/report_json.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

namespace lightbatch::pipeline {
namespace {

Json rgb(const Rgbd& c) { return Json::array({c.r, c.g, c.b}); }

const char* kind_name(JobKind kind) {
  switch (kind) {
    case JobKind::kBake:
      return "bake";
    case JobKind::kPlan:
      return "plan";
    case JobKind::kQuote:
      return "quote";
    case JobKind::kSweep:
      return "sweep";
    case JobKind::kHierarchy:
      return "hierarchy";
    case JobKind::kRelight:
      return "relight";
    case JobKind::kViews:
      return "views";
  }
  return "unknown";
}

const char* compression_name(Compression c) {
  switch (c) {
    case Compression::kAsInput:
      return "as input";
    case Compression::kNone:
      return "none";
    case Compression::kMeshopt:
      return "meshopt";
    case Compression::kDraco:
      return "draco";
  }
  return "unknown";
}

const char* quantization_name(Quantization q) {
  return q == Quantization::kAll ? "all" : q == Quantization::kNone ? "none" : "as input";
}

Json option_section(const JobOptions& o) {
  Json json = {{"seed", o.seed}, {"lightmap_size", o.lightmap_size}, {"profile", o.profile}};
  if (o.target_error > 0) json["target_error"] = o.target_error;
  if (o.time_budget > 0) json["time_budget_seconds"] = o.time_budget;
  if (o.texels_per_metre > 0) json["texels_per_metre"] = o.texels_per_metre;
  if (o.sky_nits > 0) json["sky_nits"] = o.sky_nits;
  if (!o.sky_file.empty()) json["sky_file"] = o.sky_file;
  json["carrier"] = o.carrier == Carrier::kLightmap   ? "lightmap"
                    : o.carrier == Carrier::kPortable ? "portable"
                                                      : "both";
  json["lights"] = o.lights == LightsPolicy::kKeep ? "keep" : "remove";
  json["compression"] = compression_name(o.compression);
  json["quantization"] = quantization_name(o.quantization);
  json["batches"] = o.batches;
  json["lightmaps"] = o.lightmaps;
  if (!o.cameras_file.empty()) json["cameras_file"] = o.cameras_file;
  if (o.pvs) json["pvs"] = true;
  if (o.max_batches > 0) json["max_batches"] = o.max_batches;
  if (o.max_vertices > 0) json["max_vertices"] = o.max_vertices;
  if (o.batches) {
    json["max_growth"] = o.max_growth;
    json["draws_share"] = o.draws_share;
    json["keep_materials"] = o.keep_materials;
  }
  std::string effects;
  for (const std::string& e : o.effects) effects += (effects.empty() ? "" : ",") + e;
  if (!effects.empty()) json["effects"] = effects;
  return json;
}

Json scene_section(const scene::Scene& scene) {
  std::set<std::uint32_t> nodes, meshes;
  for (const scene::Object& o : scene.objects) {
    nodes.insert(o.node);
    meshes.insert(o.mesh);
  }
  std::size_t emitters = 0;
  for (const scene::Material& m : scene.materials) emitters += m.emission.is_black() ? 0u : 1u;
  Json dropped = Json::object();
  if (scene.counts.zero_area_triangles > 0)
    dropped["triangles without area"] = scene.counts.zero_area_triangles;
  if (scene.counts.zero_scale_nodes > 0)
    dropped["nodes of zero scale"] = scene.counts.zero_scale_nodes;
  return {{"triangles", scene.triangles.size()},
          {"objects", scene.objects.size()},
          {"nodes", nodes.size()},
          {"meshes", meshes.size()},
          {"materials", scene.materials.size()},
          {"lights", scene.lights.size()},
          {"emitters", emitters},
          {"passed_through", scene.skipped.size()},
          {"textures_not_decoded", scene.counts.textures_not_decoded},
          {"reflectances_clamped", scene.counts.clamped_reflectance},
          {"dropped", dropped}};
}

Json plan_section(const JobOptions& options, const plan::EffectPlan& effects) {
  Json list = Json::array();
  for (std::size_t i = 0; i < plan::kEffectCount; ++i) {
    const plan::Decision& d = effects.decisions[i];
    const std::string name(plan::effect_name(static_cast<plan::Effect>(i)));
    const bool overridden = std::any_of(options.effects.begin(), options.effects.end(),
                                        [&](const std::string& e) { return e.substr(1) == name; });
    list.push_back({{"name", name},
                    {"on", d.on},
                    {"called_for", d.called_for},
                    {"simulated", d.simulated},
                    {"overridden", overridden},
                    {"why", d.reason},
                    {"evidence", d.evidence},
                    {"cost_share", d.cost_share}});
  }
  return {{"effects", list}};
}

/// Which nodes are regular grids, and how far the next was from paying.
Json report_grids(const rays::Caster& caster) {
  Json taken = Json::array();
  for (const rays::GridNode& grid : caster.grids()) {
    taken.push_back({{"node", grid.node},
                     {"triangles", grid.triangles},
                     {"cells", grid.cells},
                     {"cost_share", grid.cost_share}});
  }
  Json section = {{"taken", taken}};
  if (const rays::GridNode& next = caster.refused_grid(); next.triangles > 0) {
    section["refused"] = {{"node", next.node},
                          {"triangles", next.triangles},
                          {"cost_share_at_least", next.cost_share}};
  }
  return section;
}

}  // namespace

Json report_hierarchy(const hierarchy::Statistics& s, double build_seconds) {
  Json levels = Json::array();
  for (const auto& level : s.levels) {
    levels.push_back({{"level", level.level},
                      {"nodes", level.inner + level.leaves},
                      {"leaves", level.leaves},
                      {"area", level.area},
                      {"void_share", level.area > 0 ? level.void_area / level.area : 0.0}});
  }
  return {{"sah_cost", s.sah_cost}, {"sah_cost_merged", s.sah_cost_merged},
          {"depth", s.depth},       {"void_area", s.void_area},
          {"nodes", s.nodes},       {"build_seconds", build_seconds},
          {"levels", levels}};
}

Json report_head(const JobOptions& options, const JobInput& input, const Prepared& p) {
  Json report;
  report["schema"] = 1;
  report["kind"] = kind_name(options.kind);
  report["input"] = {{"name", std::filesystem::path(input.scene).filename().string()},
                     {"sha256", p.document.sha256},
                     {"bytes", p.document.input_bytes}};
  report["options"] = option_section(options);
  report["build"] = {{"id", build_id()}};
  report["scene"] = scene_section(*p.scene);
  if (p.optics != nullptr) report["plan"] = plan_section(options, p.effects);
  report["hierarchy"] = report_hierarchy(p.tree_statistics, p.tree_seconds);
  if (p.caster != nullptr) report["hierarchy"]["grids"] = report_grids(*p.caster);
  Json warnings = Json::array();
  for (const std::string& w : p.document.warnings) warnings.push_back(w);
  for (const std::string& w : p.scene->warnings) warnings.push_back(w);
  for (const scene::Material& m : p.scene->materials) {
    const bool left_out = options.carrier != Carrier::kLightmap && !m.unlit &&
                          m.base_color_texture.present() && !m.emission.is_black();
    if (!left_out) continue;
    warnings.push_back("material " + m.name +
                       ": its emission is left out of the portable file, where its base colour "
                       "texture multiplies all light");
  }
  for (std::size_t i = 0; i < plan::kEffectCount; ++i) {
    const plan::Decision& d = p.effects.decisions[i];
    if (d.called_for && !d.simulated) {
      warnings.push_back("effect " + std::string(plan::effect_name(static_cast<plan::Effect>(i))) +
                         ": " + d.reason);
    }
  }
  report["warnings"] = warnings;
  return report;
}

Json report_radiosity(const LightBake& bake) {
  const auto& s = bake.radiosity;
  const double in = s.emitted.sum();
  const double out = s.absorbed.sum() + s.escaped.sum();
  return {{"mode", bake.mode},
          {"elements", s.elements},
          {"element_edge_metres", bake.element_edge},
          {"iterations", s.iterations},
          {"residual", s.residual},
          {"links", {{bake.mode, s.links}}},
          {"memory_bytes", s.memory_bytes},
          {"mean_irradiance_lux", bake.mean_irradiance},
          {"energy",
           {{"emitted", rgb(s.emitted)},
            {"absorbed", rgb(s.absorbed)},
            {"escaped", rgb(s.escaped)},
            {"error", in > 0 ? std::fabs(in - out) / in : 0.0}}}};
}

Json report_layout(const LightmapPlaces& places) {
  const atlas::Layout& layout = places.layout;
  return {{"charts", layout.charts.size()},
          {"texels", places.texels.texels.size()},
          {"texels_per_metre_asked", layout.asked_texels_per_metre},
          {"texels_per_metre_given", layout.texels_per_metre},
          {"utilisation", layout.utilisation},
          {"area_off_density", layout.out_of_density_area},
          {"footprint_conflicts", layout.footprint_conflicts}};
}

Json report_lightmaps(const LightmapPlaces& places, const lightmap::BakeCounts& counts,
                      const std::vector<lightmap::EncodedPage>& encoded) {
  const atlas::Layout& layout = places.layout;
  std::vector<std::uint64_t> charts(layout.pages.size()), texels(layout.pages.size());
  for (const atlas::Chart& c : layout.charts) ++charts[c.page];
  for (const atlas::Texel& t : places.texels.texels) ++texels[t.page];
  Json pages = Json::array();
  for (std::size_t i = 0; i < layout.pages.size(); ++i) {
    const double all = static_cast<double>(layout.pages[i].width) * layout.pages[i].height;
    pages.push_back({{"name", "lightmap_" + std::to_string(i)},
                     {"width", layout.pages[i].width},
                     {"height", layout.pages[i].height},
                     {"charts", charts[i]},
                     {"texels", texels[i]},
                     {"utilisation", static_cast<double>(texels[i]) / all},
                     {"intensity", encoded[i].intensity},
                     {"clipped_texels", encoded[i].clipped_texels}});
  }
  const double all_texels = static_cast<double>(std::max<std::uint64_t>(1, counts.texels));
  Json json = report_layout(places);
  json["gathered_share"] = static_cast<double>(counts.computed_texels) / all_texels;
  json["refined_share"] = static_cast<double>(counts.refined_texels) / all_texels;
  json["pages"] = std::move(pages);
  return json;
}

Json report_batches(const gltf::Document& document, const scene::Scene& scene,
                    const batches::BatchPlan& plan, const batches::ViewsReport& views,
                    const std::string& profile) {
  const auto figures = [](const batches::ViewsFigures& f) -> Json {
    return {{"draws", f.inside.draws},
            {"triangles", f.inside.triangles},
            {"draws_outside", f.outside.draws},
            {"triangles_outside", f.outside.triangles},
            {"cost_us", f.inside.cost}};
  };
  Json before = figures(views.before);
  Json after = figures(views.after);
  before["all_draws"] = plan.draws_before;
  after["all_draws"] = plan.draws_after;
  Json curve = Json::array();
  const auto add_point = [&](double draws, double triangles, bool chosen) {
    curve.push_back({{"draws", draws}, {"triangles", triangles}, {"chosen", chosen}});
  };
  // Few draws first; what was chosen is a point of its own.
  bool placed = plan.expected_draws == 0;
  const auto add_chosen = [&] {
    add_point(plan.expected_draws, plan.expected_triangles, true);
    placed = true;
  };
  for (const batches::CurvePoint& c : plan.curve) {
    if (!placed && c.draws >= plan.expected_draws) add_chosen();
    add_point(c.draws, c.triangles, false);
  }
  if (!placed) add_chosen();
  Json left = Json::array();
  for (const batches::LeftAlone& l : plan.left_alone) {
    left.push_back({{"name", scene.objects[l.object].name}, {"reason", l.reason}});
  }
  for (const scene::Skipped& s : scene.skipped) {
    const Json& node = document.json["nodes"][s.node];
    const std::string number = "node " + std::to_string(s.node);
    left.push_back({{"name", node.value("name", number)}, {"reason", s.reason}});
  }
  return {{"count", plan.batches.size()},
          {"instance_cells", plan.cells.size()},
          {"instance_parts", plan.parts.size()},
          {"draw_price_us", plan.draw_price},
          {"split_objects", plan.split_objects},
          {"profile", profile},
          {"views", views.inside_views + views.outside_views},
          {"ideal_triangles", views.ideal_inside},
          {"ideal_triangles_outside", views.ideal_outside},
          {"copied_bytes", plan.copied_bytes},
          {"before", before},
          {"after", after},
          {"curve", curve},
          {"left_alone", left}};
}

Json report_quote(const std::vector<Price>& prices) {
  Json list = Json::array();
  for (const Price& price : prices) {
    list.push_back({{"error", price.target},
                    {"measured_error", price.error},
                    {"seconds", price.seconds},
                    {"low", 0.7 * price.seconds},
                    {"high", 1.3 * price.seconds}});
  }
  return list;
}

Json report_expected(const Tuned& tuned) {
  const auto part = [](const accuracy::PartPilot& pilot, double rung) {
    return Json{{"error", accuracy::error_at(pilot, rung)}, {"rung", rung}};
  };
  return {{"error", error_at(tuned.pilot, tuned.rungs)},
          {"excess", tuned.pilot.excess},
          {"direct", part(tuned.pilot.direct, tuned.rungs.direct)},
          {"indirect", part(tuned.pilot.indirect, tuned.rungs.gather)},
          {"first_stage", {{"rung", tuned.rungs.first}}}};
}

void report_counters(Json& report, const Prepared& p, const LightBake& bake) {
  const plan::EffectPlan& effects = p.effects;
  for (std::size_t i = 0; i < plan::kEffectCount; ++i) {
    report["plan"]["effects"][i]["cost_share"] = effects.decisions[i].cost_share;
  }
  radiosity::RayCounts rays = bake.radiosity.rays;
  rays += bake.baked.counts.rays;
  rays += bake.directional.counts.rays;
  rays += bake.probes.counts.rays;
  const auto set = [&](std::string_view effect, Json counters) {
    for (Json& e : report["plan"]["effects"]) {
      if (e["name"] == effect) e["counters"] = std::move(counters);
    }
  };
  using plan::Effect;
  // Shared counters belong to what is on.
  const auto counted = [&](Effect e, std::uint64_t n) { return effects.on(e) ? n : 0; };
  for (const Effect e : {Effect::kPointLights, Effect::kSpotLights, Effect::kDirectionalLights}) {
    set(plan::effect_name(e), {{"punctual shadow rays", counted(e, rays.punctual_shadow)}});
  }
  set("emitters",
      {{"emitter shadow rays", rays.emitter_shadow}, {"polygon factors", rays.polygon_factors}});
  set("shadows", {{"shadow rays", rays.punctual_shadow + rays.emitter_shadow}});
  set("sky", {{"hemisphere rays", counted(Effect::kSky, rays.hemisphere)},
              {"rays to the sky", counted(Effect::kSky, rays.sky_escapes)},
              {"rays to suns of the sky", rays.sun_shadow}});
  set("interreflection", {{"hemisphere rays", counted(Effect::kInterreflection, rays.hemisphere)},
                          {"links", bake.radiosity.links}});
  set("alpha_cutout", {{"alpha look-ups", counted(Effect::kAlphaCutout, rays.alpha_lookups)}});
  set("alpha_blend", {{"alpha look-ups", counted(Effect::kAlphaBlend, rays.alpha_lookups)},
                      {"sheet crossings", counted(Effect::kAlphaBlend, rays.sheet_crossings)}});
  std::uint64_t reflecting = 0, emitting = 0, two_sided = 0, transmitting = 0;
  for (std::uint32_t i = 0; i < p.scene->triangles.size(); ++i) {
    reflecting += p.optics->textured_reflectance(i) ? 1u : 0u;
    emitting += p.optics->textured_emission(i) ? 1u : 0u;
    two_sided += p.optics->double_sided(i) ? 1u : 0u;
    transmitting += p.optics->transmits_diffusely(i) ? 1u : 0u;
  }
  // Textures are looked up on these triangles alone.
  set("textured_reflectance", {{"textured triangles", reflecting}});
  set("textured_emission", {{"textured triangles", emitting}});
  set("two_sided", {{"two-sided triangles", two_sided}});
  set("diffuse_transmission", {{"transmitting triangles", transmitting}});
  set("directional_lightmaps", {{"directional texels", bake.directional.texels},
                                {"directional rays", bake.directional.counts.rays.cast()}});
  set("probes", {{"probes", bake.probes.grid.positions.size()},
                 {"probe rays", bake.probes.counts.rays.cast()}});
  set("transmission", {{"sheet crossings", counted(Effect::kTransmission, rays.sheet_crossings)}});
}

void report_stages(Json& report, const StageClock& clock) {
  Json stages = Json::array();
  std::uint64_t peak = 0;
  for (const Stage& s : clock.stages()) {
    stages.push_back({{"name", s.name},
                      {"seconds", s.seconds},
                      {"cpu_seconds", s.cpu_seconds},
                      {"peak_bytes", s.peak_bytes}});
    peak = std::max(peak, s.peak_bytes);
  }
  report["stages"] = stages;
  report["total"] = {
      {"seconds", clock.seconds()}, {"cpu_seconds", clock.cpu_seconds()}, {"peak_bytes", peak}};
}

}  // namespace lightbatch::pipeline
