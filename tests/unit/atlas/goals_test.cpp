#include <gtest/gtest.h>

#include <cstring>
#include <ctime>
#include <filesystem>

#include "core/atlas/layout.h"
#include "core/base/parallel.h"
#include "core/gltf/document.h"
#include "core/scene_in/read_scene.h"
#include "tests/unit/atlas/check_layout.h"

namespace lightbatch::atlas {
namespace {

/// texels: of the pages over area x density^2; at most 0.85 of what xatlas (padding 0) takes.
struct Goal {
  const char* file;
  double texels_per_unit;
  double texels;
  double utilisation;
  double cpu_seconds;
};
constexpr Goal kGoals[] = {
    {"classroom.glb", 50, 0.85 * 1.50, 0.75, 0.7},
    {"hotel_room.glb", 0.05, 0.85 * 1.43, 0.75, 0.7},  // drawn in millimetres
    {"vianney_house.glb", 5, 0.85 * 1.63, 0.75, 0.9},
    // Long curved kerbs of several shapes in one page: 0.75 measured, 0.32 for xatlas.
    {"folio_areas.glb", 5, 0.85 * 3.29, 0.70, 0.9},
    {"hotel_block_1m.draco.glb", 0.05, 0.85 * 1.46, 0.75, 7.0},
    // 48 rooms of 99,029 triangles, charted once.
    {"hotel_block_instanced.glb", 0.05, 0.85 * 1.46, 0.75, 7.0},
};

TEST(SharedScenes, ReachTheGoals) {
  for (const Goal& goal : kGoals) {
    const auto path = std::filesystem::path(LIGHTBATCH_SHARED) / "scenes" / goal.file;
    if (!std::filesystem::exists(path)) continue;
    SCOPED_TRACE(goal.file);
    const auto document = gltf::read_document({{goal.file, path}}, goal.file);
    ASSERT_TRUE(document.ok()) << document.status().to_string();
    const auto scene = scene_in::read_scene(*document);
    ASSERT_TRUE(scene.ok()) << scene.status().to_string();
    const std::vector<std::uint8_t> lit(scene->triangles.size(), 1);
    LayoutOptions options;
    options.texels_per_metre = goal.texels_per_unit;
    options.max_texels = 1e8;
    const int before = thread_count();
    set_thread_count(1);
    const std::clock_t start = std::clock();
    const auto layout = make_layout(*scene, lit, options, Progress());
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    set_thread_count(2);
    const auto again = make_layout(*scene, lit, options, Progress());
    set_thread_count(before);
    ASSERT_TRUE(layout.ok()) << layout.status().to_string();
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(layout->chart_of, again->chart_of);
    EXPECT_EQ(
        std::memcmp(layout->uv.data(), again->uv.data(), layout->uv.size() * sizeof(layout->uv[0])),
        0);

    double texels = 0;
    for (const Page& p : layout->pages) texels += static_cast<double>(p.width) * p.height;
    const double ideal = layout->charted_area * goal.texels_per_unit * goal.texels_per_unit;
    EXPECT_EQ(layout->texels_per_metre, goal.texels_per_unit);
    EXPECT_LE(texels / ideal, goal.texels);
    EXPECT_GE(layout->utilisation, goal.utilisation);
    EXPECT_LE(layout->out_of_density_area, 0.01);
    EXPECT_EQ(layout->footprint_conflicts, 0u);
    EXPECT_EQ(brute_conflicts(*layout), 0u);
    // Three times the goal where other work shares the caches; measured 1/3 to 1/5 of it alone.
    EXPECT_LE(seconds, 3 * goal.cpu_seconds);
  }
}

}  // namespace
}  // namespace lightbatch::atlas
