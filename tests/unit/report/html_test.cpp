#include "core/report/html.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/unit/report/sample_report.h"

namespace lightbatch::report {
namespace {

using nlohmann::json;

bool holds(const std::string& page, const std::string& words) {
  return page.find(words) != std::string::npos;
}

TEST(Html, ShowsWhatTheReportSays) {
  const std::string page = html(sample_report(), {{"page 0", Bytes(4), PictureKind::kLightmap}});
  EXPECT_EQ(tag_fault(page), "");
  for (const char* words : {"small_room.draco_webp.glb",
                            "Target met: certified error 1.74 % (95 % interval 1.61 to 1.88 %)",
                            "171 → 38",
                            "47,402",
                            "area emitters",
                            "material &quot;Lamp&quot;",
                            "and 2 more",
                            "as asked",
                            "lightmap_0",
                            "stored rays",
                            "skinned",
                            "binned SAH",
                            "texture 3 is KTX2",
                            "scene.glb#/materials/2",
                            "12 times",
                            "data:image/png;base64,AAAAAA==",
                            "Price list",
                            "610 MiB",
                            "1.23 %",
                            "Skirting",
                            "bright points that no light reaches"}) {
    EXPECT_TRUE(holds(page, words)) << words;
  }
}

TEST(Html, MissedTargetIsSaid) {
  json report = sample_report();
  report["accuracy"]["certified"] = 0.031;
  report["accuracy"]["passed"] = false;
  EXPECT_TRUE(holds(html(report, {}), "Target missed: certified error 3.1 %"));
}

TEST(Html, LoadsNothingAndRunsNothing) {
  const std::string page = html(sample_report(), {});
  for (const char* words :
       {"<script", "http://", "https://", "url(", "@import", "javascript:", "<link"}) {
    std::string rest = page;
    // The name space of SVG is a name, not an address.
    const std::string name_space = "http://www.w3.org/2000/svg";
    for (std::size_t at = rest.find(name_space); at != std::string::npos;
         at = rest.find(name_space)) {
      rest.erase(at, name_space.size());
    }
    EXPECT_FALSE(holds(rest, words)) << words;
  }
}

TEST(Html, SameReportSameBytes) { EXPECT_EQ(html(sample_report(), {}), html(sample_report(), {})); }

TEST(Html, EachSectionMayBeMissing) {
  EXPECT_EQ(tag_fault(html(json::object(), {})), "");
  EXPECT_EQ(tag_fault(html(json(), {})), "");
  const json whole = sample_report();
  for (const auto& [key, value] : whole.items()) {
    json without = whole, alone = {{key, value}};
    without.erase(key);
    EXPECT_EQ(tag_fault(html(without, {})), "") << "without " << key;
    EXPECT_EQ(tag_fault(html(alone, {})), "") << key << " alone";
  }
  const std::string plan = html({{"kind", "plan"}, {"plan", whole["plan"]}}, {});
  EXPECT_TRUE(holds(plan, "Effect plan"));
  EXPECT_FALSE(holds(plan, "Lightmaps"));
}

/// Replaces every value below `node`, one at a time, by `wrong`, and makes the page.
void try_everywhere(const json& whole, json& copy, json& node, const json& wrong) {
  if (!node.is_structured()) return;
  for (auto& child : node) {
    const json kept = child;
    child = wrong;
    EXPECT_EQ(tag_fault(html(copy, {})), "");
    child = kept;
    try_everywhere(whole, copy, child, wrong);
  }
}

TEST(Html, ValuesOfAnyTypeAreTaken) {
  const json whole = sample_report();
  for (const json& wrong :
       {json(nullptr), json("text"), json(-1e308), json(json::array({1, "x", {}})),
        json({{"x", {{"y", 1}}}}), json(true)}) {
    json copy = whole;
    try_everywhere(whole, copy, copy, wrong);
  }
}

TEST(Html, HostileNamesAreText) {
  json report = sample_report();
  const std::string attack = "\"><img src=x onerror=alert(1)>'</title>\xFF\x01";
  const std::function<void(json&)> poison = [&](json& node) {
    if (node.is_string()) node = attack;
    if (node.is_object()) node[attack] = attack;
    if (node.is_structured()) {
      for (json& child : node) poison(child);
    }
  };
  poison(report);
  const std::string page = html(report, {{attack, Bytes(1), PictureKind::kView, attack}});
  EXPECT_EQ(tag_fault(page), "");
  EXPECT_FALSE(holds(page, "<img src=x"));
  EXPECT_FALSE(holds(page, "\xFF"));
}

TEST(Html, LongListsAreCut) {
  json report = sample_report();
  for (int i = 0; i < 5000; ++i) {
    std::string name = "n";
    name += std::to_string(i);
    report["batches"]["left_alone"].push_back({{"name", name}, {"reason", "skinned"}});
  }
  const std::string page = html(report, {});
  EXPECT_TRUE(holds(page, "and 4,801 more in report.json"));
  EXPECT_FALSE(holds(page, "n4000<"));
}

TEST(ErrorTime, IsADrawingOfItsOwn) {
  json report = sample_report();
  report["sweep"] = {
      {{"target", 0.1}, {"certified", 0.08}, {"low", 0.07}, {"high", 0.09}, {"seconds", 3}},
      {{"target", 0.01}, {"certified", 0.009}, {"seconds", 200}}};
  const std::string svg = error_time_svg(report);
  EXPECT_EQ(tag_fault(svg), "");
  EXPECT_TRUE(holds(svg, "<?xml"));
  EXPECT_TRUE(holds(svg, "certified, baked"));
  EXPECT_EQ(tag_fault(error_time_svg(json::object())), "");
}

TEST(SweepCsv, HasOneLineForEachBake) {
  const json report = {{"sweep",
                        {{{"target", 0.1}, {"certified", 0.0825}, {"seconds", 3.5}, {"draws", 12}},
                         "nonsense",
                         {{"target", 0.01}}}}};
  EXPECT_EQ(sweep_csv(report),
            "target,certified,low,high,p95,bias,seconds,cpu_seconds,peak_bytes,texels,draws\r\n"
            "0.1,0.0825,,,,,3.5,,,,12\r\n"
            ",,,,,,,,,,\r\n"
            "0.01,,,,,,,,,,\r\n");
  EXPECT_EQ(sweep_csv(json::object()).find("\r\n") + 2, sweep_csv(json::object()).size());
}

}  // namespace
}  // namespace lightbatch::report
