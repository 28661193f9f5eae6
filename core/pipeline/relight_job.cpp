// New intensities and colours on a finished bake, without a ray: light is linear in its sources, so
// that a page is the sum over its light groups, each scaled by what its source has become.

#include <algorithm>

#include "core/gltf/json_text.h"
#include "core/image/codecs.h"
#include "core/lightmap/pages.h"
#include "core/pipeline/artifacts.h"
#include "core/pipeline/jobs.h"
#include "core/pipeline/light_groups_json.h"
#include "core/report/html.h"
#include "core/scene_out/relit_scene.h"

namespace lightbatch::pipeline {
namespace {

constexpr int kJsonDepth = 64;
constexpr std::uint64_t kJsonMemory = std::uint64_t{1} << 28;
/// By which a group may grow; keeps its factor a finite float.
constexpr double kMostFactor = 1e30;

Result<Bytes> read(const JobInput& input, const std::string& name) {
  const auto file = input.files.find(name);
  if (file == input.files.end()) {
    return malformed(name, "is missing; give the whole folder that a bake made");
  }
  return read_file(file->second);
}

Result<Json> read_json(const JobInput& input, const std::string& name) {
  LB_ASSIGN_OR_RETURN(const Bytes bytes, read(input, name));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return gltf::parse_json(text, name, kJsonDepth, kJsonMemory);
}

/// A finished bake as its report tells of it.
struct Bake {
  Json report;
  /// Light of several sources: what the layers were baked with. Of one: what the lightmap holds.
  std::vector<GroupEntry> from;
  std::vector<GroupEntry> now;  // what the lightmap holds
  std::size_t pages = 0;
  bool has_layers() const { return from.size() > 1; }
};

Result<std::vector<GroupEntry>> read_entries(const Json& list, const char* key) {
  std::vector<GroupEntry> entries;
  for (std::size_t i = 0; list.is_array() && i < list.size(); ++i) {
    auto entry = group_entry(list[i]);
    if (!entry) {
      return malformed(std::string("report.json#/") + key + "/" + std::to_string(i),
                       "is no light group");
    }
    entries.push_back(std::move(*entry));
  }
  return entries;
}

Result<Bake> read_bake(const JobInput& input) {
  Bake bake;
  LB_ASSIGN_OR_RETURN(bake.report, read_json(input, "report.json"));
  const Json& r = bake.report;
  const Json::json_pointer pages("/lightmaps/pages"), carrier("/options/carrier");
  if (!r.is_object() || !r.contains(pages) || !r[pages].is_array()) {
    return malformed("report.json", "is no report of a bake with lightmaps");
  }
  if (r.contains(carrier) && r[carrier] == "portable") {
    return unsupported("report.json#/options/carrier",
                       "light in vertex colours cannot be relit; bake with --carrier lightmap");
  }
  if (!r.contains("light_groups")) {
    return unsupported("report.json#/light_groups",
                       "the bake keeps no light groups apart; bake again with the new lights");
  }
  bake.pages = r[pages].size();
  LB_ASSIGN_OR_RETURN(bake.from, read_entries(r["light_groups"], "light_groups"));
  if (bake.from.empty()) {
    return unsupported("report.json#/light_groups", "the bake has no light that could change");
  }
  bake.now = bake.from;
  if (r.contains("relit")) {
    LB_ASSIGN_OR_RETURN(bake.now, read_entries(r["relit"], "relit"));
    if (bake.now.size() != bake.from.size()) {
      return malformed("report.json#/relit", "does not fit light_groups");
    }
  }
  return bake;
}

/// By which each group's part is to be multiplied.
Result<std::vector<Rgb>> factors_of(const Bake& bake) {
  std::vector<Rgb> factors;
  for (std::size_t g = 0; g < bake.now.size(); ++g) {
    bool from_dark = false;
    const auto ratio = [&](double is, double was) {
      from_dark = from_dark || (is > 0 && !(was > 0));
      return was > 0 ? is / was : 0.0;
    };
    const Rgbd was = bake.from[g].light(), is = bake.now[g].light();
    const Rgbd factor{ratio(is.r, was.r), ratio(is.g, was.g), ratio(is.b, was.b)};
    if (!(factor.max() <= kMostFactor)) {
      return bad_option(bake.now[g].kind + " " + bake.now[g].name +
                        ": more than 1e30 times as strong as when it was baked");
    }
    factors.push_back(to_float(factor));
    if (from_dark) {
      return bad_option(
          bake.now[g].kind + " " + bake.now[g].name +
          ": had no light in a channel when it was baked; bake again to switch it on");
    }
  }
  return factors;
}

/// Sum over the light groups of page k.
Status add_layers(const JobInput& input, const Bake& bake, const std::vector<Rgb>& factors,
                  std::size_t k, image::ImageRgb& sum) {
  const std::string name = light_groups_file(k);
  LB_ASSIGN_OR_RETURN(const Bytes bytes, read(input, name));
  LB_ASSIGN_OR_RETURN(const auto layers, image::decode_exr_layers(bytes, name));
  std::fill(sum.pixels.begin(), sum.pixels.end(), Rgb{});
  for (std::size_t g = 0; g < factors.size(); ++g) {
    const auto layer = std::find_if(layers.begin(), layers.end(),
                                    [&](const auto& l) { return l.name == bake.from[g].layer; });
    if (layer == layers.end() || layer->image.width != sum.width ||
        layer->image.height != sum.height) {
      return malformed(name, "has no layer " + bake.from[g].layer + " of the page's size");
    }
    for (std::size_t i = 0; i < sum.pixels.size(); ++i) {
      sum.pixels[i] += layer->image.pixels[i] * factors[g];
    }
  }
  return {};
}

Result<lightmap::PageImage> relit_page(const JobInput& input, const Bake& bake,
                                       const std::vector<Rgb>& factors, std::size_t k) {
  const std::string name = "lightmap_" + std::to_string(k) + ".exr";
  LB_ASSIGN_OR_RETURN(const Bytes bytes, read(input, name));
  lightmap::PageImage page;
  LB_ASSIGN_OR_RETURN(page.irradiance, image::decode_image_rgb(bytes, name));
  LB_ASSIGN_OR_RETURN(page.coverage, image::decode_exr_alpha(bytes, name));
  std::vector<Rgb>& pixels = page.irradiance.pixels;
  if (page.coverage.size() != pixels.size()) return malformed(name, "its channels differ in size");
  if (!bake.has_layers()) {
    for (Rgb& pixel : pixels) pixel = pixel * factors[0];
  } else {
    LB_RETURN_IF_ERROR(add_layers(input, bake, factors, k, page.irradiance));
  }
  if (!std::all_of(pixels.begin(), pixels.end(), [](const Rgb& p) { return is_finite(p); })) {
    return bad_option(name + ": the new light is stronger than a page can hold");
  }
  return page;
}

/// The bake's report without what was measured on its light and its time.
Json relit_report(const Bake& bake, const gltf::FileMap& files) {
  Json report = bake.report;
  report["kind"] = "relight";
  for (const char* key : {"accuracy", "borders", "expected", "quote", "stages", "total"}) {
    report.erase(key);
  }
  report.erase("probes");
  const bool left_out = std::any_of(files.begin(), files.end(), [](const auto& file) {
    return file.first.ends_with("probes.json") || file.first.ends_with("_dir.exr");
  });
  if (left_out) {
    Json& warnings = report["warnings"];
    if (!warnings.is_array()) warnings = Json::array();
    warnings.push_back(
        "probes and directional pages are not made anew by a relight: bake again for them");
  }
  Json now = Json::array();
  for (const GroupEntry& entry : bake.now) now.push_back(to_json(entry));
  report[bake.has_layers() ? "relit" : "light_groups"] = std::move(now);
  return report;
}

}  // namespace

Result<JobOutcome> run_relight(const JobOptions& options, const JobInput& input,
                               const std::filesystem::path& output, const Progress& progress) {
  StageClock clock;
  clock.start("read");
  progress.report("read", 0);
  LB_ASSIGN_OR_RETURN(Bake bake, read_bake(input));
  LB_ASSIGN_OR_RETURN(const Json lights, read_json(input, options.lights_file));
  const std::vector<GroupEntry> before = bake.now;
  LB_RETURN_IF_ERROR(change_entries(lights, options.lights_file, bake.now));
  LB_ASSIGN_OR_RETURN(const std::vector<Rgb> factors, factors_of(bake));
  LB_ASSIGN_OR_RETURN(const Bytes scene, read(input, input.scene));

  clock.start("pages");
  Artifacts artifacts(output);
  std::vector<scene_out::RelitPage> pages;
  std::vector<report::Picture> pictures;
  for (std::size_t k = 0; k < bake.pages; ++k) {
    if (progress.cancelled()) return cancelled();
    progress.report("pages", static_cast<double>(k) / static_cast<double>(bake.pages));
    LB_ASSIGN_OR_RETURN(const lightmap::PageImage page, relit_page(input, bake, factors, k));
    LB_ASSIGN_OR_RETURN(const lightmap::EncodedPage encoded, lightmap::encode_page(page));
    LB_ASSIGN_OR_RETURN(const Bytes exr, lightmap::encode_exr(page));
    const std::string name = "lightmap_" + std::to_string(k);
    LB_RETURN_IF_ERROR(artifacts.add(name + ".exr", exr));
    pages.push_back({encoded.png, encoded.intensity});
    pictures.push_back(
        {name, image::encode_png(lightmap::preview(page), false), report::PictureKind::kLightmap});
    if (bake.has_layers()) {
      LB_ASSIGN_OR_RETURN(const Bytes layers, read(input, light_groups_file(k)));
      LB_RETURN_IF_ERROR(artifacts.add(light_groups_file(k), layers));
    }
  }
  clock.start("write");
  std::vector<scene_out::RelitLight> relit_lights;
  std::vector<scene_out::RelitMaterial> relit_materials;
  for (std::size_t g = 0; g < bake.now.size(); ++g) {
    const GroupEntry& entry = bake.now[g];
    if (to_json(entry) == to_json(before[g])) continue;
    if (entry.kind == "light") {
      relit_lights.push_back({entry.index, entry.color, entry.intensity});
    } else if (entry.kind == "material") {
      relit_materials.push_back({entry.index, entry.color, entry.intensity});
    }
  }
  LB_ASSIGN_OR_RETURN(const Bytes glb, scene_out::relit_scene(scene, input.scene, pages,
                                                              relit_lights, relit_materials));
  LB_RETURN_IF_ERROR(artifacts.add("scene.glb", glb));
  clock.stop();
  Json report = relit_report(bake, input.files);
  report_stages(report, clock);
  LB_RETURN_IF_ERROR(artifacts.add("report.json", report.dump(1) + "\n"));
  LB_RETURN_IF_ERROR(artifacts.add("report.html", report::html(report, pictures)));
  if (progress.cancelled()) return cancelled();
  artifacts.keep();
  JobOutcome outcome;
  outcome.artifacts = artifacts.names();
  outcome.summary = "relit    " + std::to_string(bake.pages) + " page(s), no ray cast\n";
  return outcome;
}

}  // namespace lightbatch::pipeline
