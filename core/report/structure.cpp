// How the scene was cut: batches, hierarchy; and what went in.

#include "core/report/markup.h"
#include "core/report/plot.h"
#include "core/report/sections.h"
#include "core/report/text.h"

namespace lightbatch::report {
namespace {

/// Before and after side by side, with the ratio.
std::string before_after(const Json& batches) {
  const Json& before = object(batches, "before");
  const Json& after = object(batches, "after");
  std::string rows;
  for (const auto& [key, value] : before.items()) {
    if (!value.is_number() || !number(after, key)) continue;
    const double old_value = value.get<double>(), new_value = *number(after, key);
    rows += "<tr><th scope=\"row\">" + escape(key_text(key)) + "</th><td class=\"n\">" +
            escape(value_text(key, value)) + "</td><td class=\"n\">" +
            escape(value_text(key, *find(after, key))) + "</td><td class=\"n\">" +
            (old_value > 0 ? escape("× " + significant(new_value / old_value, 3)) : "") +
            "</td></tr>\n";
  }
  if (rows.empty()) return {};
  return "<div class=\"wide\"><table>\n<thead><tr><th scope=\"col\"></th><th scope=\"col\" "
         "class=\"n\">before</th><th scope=\"col\" class=\"n\">after</th><th scope=\"col\" "
         "class=\"n\">ratio</th></tr></thead>\n<tbody>\n" +
         rows + "</tbody></table></div>\n";
}

std::string batch_curve(const Json& curve) {
  Plot plot;
  plot.title = "draws against triangles of cuts through the hierarchy";
  plot.x = {"draw calls", Unit::kNumber, true, false};
  plot.y = {"triangles submitted (mean)", Unit::kNumber, true, false};
  Series cuts{"cuts", {}, true, false}, chosen{"chosen", {}, false, false};
  for (const Json& row : curve) {
    const auto draws = number(row, "draws"), triangles = number(row, "triangles");
    if (!draws || !triangles) continue;
    const bool is_chosen = flag(row, "chosen").value_or(false);
    (is_chosen ? chosen : cuts).points.push_back({*draws, *triangles});
    if (is_chosen) cuts.points.push_back({*draws, *triangles});
  }
  if (cuts.points.empty()) return {};
  plot.series.push_back(std::move(cuts));
  if (!chosen.points.empty()) plot.series.push_back(std::move(chosen));
  return drawing(
      plot_svg(plot),
      "Finer cuts draw fewer unseen triangles and need more draw calls; the profile's cost "
      "decides.");
}

std::string level_plots(const Json& levels) {
  Plot plot;
  plot.title = "surface area and void by level";
  plot.x = {"level", Unit::kNumber, false, true};
  plot.y = {"ratio", Unit::kNumber, false, true};
  Series area{"area of the boxes over the root's", {}, true, false};
  Series empty{"void over area of the boxes", {}, true, false};
  for (const Json& row : levels) {
    const auto level = number(row, "level");
    if (!level) continue;
    if (const auto value = number(row, "area")) area.points.push_back({*level, *value});
    if (const auto value = number(row, "void_share")) empty.points.push_back({*level, *value});
  }
  if (!area.points.empty()) plot.series.push_back(std::move(area));
  if (!empty.points.empty()) plot.series.push_back(std::move(empty));
  return plot.series.empty() ? std::string()
                             : drawing(plot_svg(plot), "What the boxes of each level enclose.");
}

}  // namespace

std::string batches_section(const Json& report) {
  const Json& batches = object(report, "batches");
  std::string tables = before_after(batches);
  const std::string figures =
      pairs_of(batches, {{"count", "batches"}}, {"before", "after", "curve", "left_alone"});
  if (!figures.empty()) tables += "<h3>Figures</h3>\n" + figures;
  std::string html = beside(batch_curve(list(batches, "curve")), tables);
  const std::string alone =
      table_of(list(batches, "left_alone"),
               {{"name", "node", Format::kText}, {"reason", "left alone because", Format::kText}});
  if (!alone.empty()) html += "<h3>Left alone</h3>\n" + alone;
  return section("Batches", html);
}

std::string hierarchy_section(const Json& report, const std::vector<Picture>& pictures) {
  const Json& hierarchy = object(report, "hierarchy");
  std::string html = beside(
      level_plots(list(hierarchy, "levels")),
      pairs_of(hierarchy,
               {{"sah_cost", "SAH cost"}, {"depth", "depth"}, {"build_seconds", "time to build"}},
               {"levels", "compare", "grids"}));
  const Json& levels = list(hierarchy, "levels");
  const std::string table =
      table_of(levels, with_further(levels, {{"level", "level"},
                                             {"nodes", "nodes"},
                                             {"area", "area, of the root's"},
                                             {"void_share", "void"},
                                             {"triangles_most", "most triangles in a node"}}));
  if (!table.empty()) html += "<h3>Levels</h3>\n" + table;
  const Json& grids = object(hierarchy, "grids");
  const std::string inside =
      table_of(list(grids, "taken"), {{"node", "node"},
                                      {"triangles", "triangles"},
                                      {"cells", "cells"},
                                      {"cost_share", "cost, of the tree's"}}) +
      pairs_of(object(grids, "refused"),
               {{"node", "next node, left a tree"},
                {"triangles", "its triangles"},
                {"cost_share_at_least", "as a grid, at least times as costly"}},
               {});
  if (!inside.empty()) html += "<h3>Regular grids inside</h3>\n" + inside;
  const Json& compare = list(hierarchy, "compare");
  const std::string peers =
      table_of(compare, with_further(compare, {{"builder", "builder", Format::kText}}));
  if (!peers.empty()) html += "<h3>Beside other builders</h3>\n" + peers;
  html += pictures_of(pictures, PictureKind::kHierarchy);
  return section("Hierarchy", html);
}

std::string scene_section(const Json& report) {
  std::string html;
  const auto add = [&](const char* title, const std::string& pairs) {
    if (!pairs.empty()) html += "<div><h3>" + escape(title) + "</h3>\n" + pairs + "</div>\n";
  };
  add("Scene", pairs_of(object(report, "scene")));
  add("Input", pairs_of(object(report, "input"), {{"name", "name"}}, {"files"}) +
                   table_of(list(report, "input/files"),
                            {{"name", "file", Format::kText}, {"bytes", "size"}}));
  add("Options", pairs_of(object(report, "options")));
  add("Build", pairs_of(object(report, "build")));
  if (html.empty()) return {};
  return section("Scene and options", "<div class=\"columns\">\n" + html + "</div>\n");
}

}  // namespace lightbatch::report
