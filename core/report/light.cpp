// What was simulated, and what came of it: effect plan, lightmaps, radiosity.

#include <algorithm>
#include <set>
#include <string>

#include "core/report/markup.h"
#include "core/report/plot.h"
#include "core/report/sections.h"
#include "core/report/text.h"

namespace lightbatch::report {
namespace {

constexpr std::size_t kMostEvidence = 6;  // items shown of an effect's evidence

std::string evidence_of(const Json& effect) {
  std::string html = escape(text(effect, "why"));
  const Json& evidence = list(effect, "evidence");
  std::string items;
  for (std::size_t i = 0; i < std::min(evidence.size(), kMostEvidence); ++i) {
    items += (i > 0 ? ", " : "") + escape(value_text("evidence", evidence[i]));
  }
  if (evidence.size() > kMostEvidence) {
    items += escape(" and " + std::to_string(evidence.size() - kMostEvidence) + " more");
  }
  if (!items.empty())
    html += (html.empty() ? "" : "<br>") + ("<span class=\"soft\">" + items) + "</span>";
  return html;
}

std::string effect_row(const Json& effect) {
  const bool on = flag(effect, "on").value_or(false);
  std::string html = std::string("<tr") + (on ? "" : " class=\"off\"") + "><th scope=\"row\">" +
                     escape(key_text(text(effect, "name"))) + "</th><td><span class=\"tag " +
                     (on ? "on\">on" : "off\">off") + "</span>" +
                     (flag(effect, "overridden").value_or(false) ? " as asked" : "") + "</td><td>" +
                     evidence_of(effect) + "</td><td class=\"n\">";
  if (const auto share = number(effect, "cost_share"); share && on && *share > 0) {
    html += escape(percent_text(*share)) + "<span class=\"meter\"><i style=\"width:" +
            coordinate(100 * std::clamp(*share, 0.0, 1.0)) + "%\"></i></span>";
  }
  html += "</td><td>";
  bool first = true;
  for (const auto& [name, value] : object(effect, "counters").items()) {
    html += (first ? "" : "<br>") + escape(key_text(name) + ": " + value_text(name, value));
    first = false;
  }
  return html + "</td></tr>\n";
}

}  // namespace

std::string plan_section(const Json& report) {
  std::string rows;
  for (const Json& effect : list(report, "plan/effects")) {
    if (effect.is_object()) rows += effect_row(effect);
  }
  if (rows.empty()) return {};
  return section("Effect plan",
                 "<p class=\"soft\">Only what the scene calls for is simulated; what is off costs "
                 "nothing.</p>\n<div class=\"wide\"><table>\n<thead><tr><th "
                 "scope=\"col\">effect</th><th scope=\"col\"></th><th scope=\"col\">why</th><th "
                 "scope=\"col\" class=\"n\">share of rays</th><th scope=\"col\">work "
                 "done</th></tr></thead>\n<tbody>\n" +
                     rows + "</tbody></table></div>\n");
}

std::string lightmap_section(const Json& report, const std::vector<Picture>& pictures) {
  std::set<std::string> left_out = {"pages"};
  if (number(object(report, "lightmaps"), "texels_per_metre_asked").value_or(0) <= 0) {
    left_out.insert("texels_per_metre_asked");  // chosen from the scene
  }
  std::string html = pairs_of(object(report, "lightmaps"),
                              {{"texels_per_metre_asked", "texels per metre, asked"},
                               {"texels_per_metre_given", "texels per metre, given"},
                               {"texels", "texels"},
                               {"charts", "charts"},
                               {"utilisation", "utilisation"}},
                              left_out);
  const Json& pages = list(report, "lightmaps/pages");
  const std::string table = table_of(pages, with_further(pages, {{"name", "page", Format::kText},
                                                                 {"width", "width"},
                                                                 {"height", "height"},
                                                                 {"texels", "texels"},
                                                                 {"charts", "charts"},
                                                                 {"utilisation", "utilisation"},
                                                                 {"intensity", "scale to lux"}}));
  if (!table.empty()) html += "<h3>Pages</h3>\n" + table;
  html += pictures_of(pictures, PictureKind::kLightmap);
  return section("Lightmaps", html);
}

std::string probes_section(const Json& report) {
  return section("Light probes", pairs_of(object(report, "probes")));
}

std::string radiosity_section(const Json& report) {
  const Json& radiosity = object(report, "radiosity");
  std::string html = pairs_of(
      radiosity, {{"mode", "mode"}, {"elements", "elements"}, {"iterations", "iterations"}},
      {"residuals"});
  Plot plot;
  plot.title = "residual by iteration";
  plot.x = {"iteration", Unit::kNumber, false, true};
  plot.y = {"residual", Unit::kNumber, true, false};
  Series series{"residual", {}, true, false};
  double iteration = 0;
  for (const Json& value : list(radiosity, "residuals")) {
    iteration += 1;
    if (value.is_number()) series.points.push_back({iteration, value.get<double>()});
  }
  if (series.points.size() > 1) {
    plot.series.push_back(std::move(series));
    plot.height = 260;
    html = beside(drawing(plot_svg(plot), "What is left unbalanced after each iteration."), html);
  }
  return section("Radiosity", html);
}

}  // namespace lightbatch::report
