// Lays out a scene file and prints what it took; with a third argument also writes a picture of
// each page, one colour a chart.
//   atlas_inspect scene.glb texels-per-unit [picture-prefix]
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include "core/atlas/layout.h"
#include "core/atlas/texels.h"
#include "core/base/random.h"
#include "core/gltf/document.h"
#include "core/image/codecs.h"
#include "core/scene_in/read_scene.h"

namespace lightbatch::atlas {
namespace {

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

image::Image8 picture(const Layout& layout, const TexelMap& map, std::size_t page) {
  image::Image8 out;
  out.width = layout.pages[page].width;
  out.height = layout.pages[page].height;
  out.rgba.assign(map.index[page].size() * 4, 20);
  for (std::size_t i = 0; i < map.index[page].size(); ++i) {
    out.rgba[4 * i + 3] = 255;
    if (map.index[page][i] == scene::kNone) continue;
    const std::uint64_t colour = mix_bits(map.texels[map.index[page][i]].chart + 1);
    for (std::size_t k = 0; k < 3; ++k) {
      out.rgba[4 * i + k] = static_cast<std::uint8_t>(80 + (colour >> (8 * k)) % 176);
    }
  }
  return out;
}

Status inspect(const std::string& file, double density, const char* prefix) {
  LB_ASSIGN_OR_RETURN(const gltf::Document document,
                      gltf::read_document({{"scene.glb", file}}, "scene.glb"));
  LB_ASSIGN_OR_RETURN(const scene::Scene scene, scene_in::read_scene(document));
  LayoutOptions options;
  options.texels_per_metre = density;
  const double start = cpu_seconds();
  const std::vector<std::uint8_t> lit(scene.triangles.size(), 1);
  LB_ASSIGN_OR_RETURN(const Layout layout, make_layout(scene, lit, options, Progress()));
  const double laid_out = cpu_seconds();
  const TexelMap map = cover_texels(scene, layout);
  const double covered = cpu_seconds();

  double texels = 0;
  for (const Page& p : layout.pages) texels += static_cast<double>(p.width) * p.height;
  std::size_t tiny = 0;
  for (const Chart& c : layout.charts) tiny += c.tiny ? 1 : 0;
  const double ideal = layout.charted_area * layout.texels_per_metre * layout.texels_per_metre;
  std::printf(
      "%s\n  triangles %zu, asked %g, given %g texels a unit, ideal %.0f texels\n"
      "  layout %.2f CPU s: pages %zu, charts %zu (tiny %zu), texels/ideal %.3f, "
      "utilisation %.3f, outside +-30 %% %.4f, conflicts %llu\n"
      "  coverage %.2f CPU s: texels %zu, fragments %zu\n",
      file.c_str(), scene.triangles.size(), layout.asked_texels_per_metre, layout.texels_per_metre,
      ideal, laid_out - start, layout.pages.size(), layout.charts.size(), tiny, texels / ideal,
      layout.utilisation, layout.out_of_density_area,
      static_cast<unsigned long long>(layout.footprint_conflicts), covered - laid_out,
      map.texels.size(), map.fragments.size());
  for (std::size_t p = 0; prefix != nullptr && p < layout.pages.size(); ++p) {
    const Bytes png = image::encode_png(picture(layout, map, p), false);
    LB_RETURN_IF_ERROR(write_file(std::string(prefix) + std::to_string(p) + ".png", png));
  }
  return {};
}

}  // namespace
}  // namespace lightbatch::atlas

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: atlas_inspect scene.glb texels-per-unit [picture-prefix]\n");
    return 2;
  }
  const lightbatch::Status status =
      lightbatch::atlas::inspect(argv[1], std::atof(argv[2]), argc > 3 ? argv[3] : nullptr);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.to_string().c_str());
  return status.ok() ? 0 : 1;
}
