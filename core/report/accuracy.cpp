// Accuracy and time: certificate, price list, sweep, stages.

#include "core/report/markup.h"
#include "core/report/plot.h"
#include "core/report/sections.h"
#include "core/report/text.h"

namespace lightbatch::report {
namespace {

Plot error_time_plot(const Json& report) {
  Plot plot;
  plot.title = "error against time";
  plot.x = {"time", Unit::kSeconds, true, false};
  plot.y = {"error (relRMSE)", Unit::kPercent, true, false};
  Series sweep{"certified, baked", {}, true, false};
  for (const Json& row : list(report, "sweep")) {
    const auto seconds = number(row, "seconds"), error = number(row, "certified");
    if (!seconds || !error) continue;
    sweep.points.push_back(
        {*seconds, *error, number(row, "low").value_or(0), number(row, "high").value_or(0)});
  }
  Series quote{"quoted", {}, true, true};
  for (const Json& row : list(report, "quote")) {
    const auto seconds = number(row, "seconds"), error = number(row, "error");
    if (seconds && error) quote.points.push_back({*seconds, *error});
  }
  if (!sweep.points.empty()) plot.series.push_back(std::move(sweep));
  if (!quote.points.empty()) plot.series.push_back(std::move(quote));
  if (list(report, "sweep").empty()) {
    const auto certified = number(report, "accuracy/certified");
    const auto seconds = number(report, "total/seconds");
    if (certified && seconds && !plot.series.empty()) {
      plot.series.insert(plot.series.begin(),
                         {"this bake, certified",
                          {{*seconds, *certified, number(report, "accuracy/low").value_or(0),
                            number(report, "accuracy/high").value_or(0)}},
                          false,
                          false});
    }
  }
  if (const auto target = number(report, "accuracy/target"); target && *target > 0) {
    plot.marks.push_back({"target", *target, false});
  }
  return plot;
}

}  // namespace

std::string error_time_svg(const nlohmann::json& report) {
  return standalone_svg(plot_svg(error_time_plot(report)));
}

std::string accuracy_section(const Json& report) {
  std::string tables = pairs_of(object(report, "accuracy"),
                                {{"target", "target", Format::kPercent},
                                 {"certified", "certified error", Format::kPercent},
                                 {"low", "95 % interval from", Format::kPercent},
                                 {"high", "to", Format::kPercent},
                                 {"p95", "error of the worst 5 % above", Format::kPercent},
                                 {"bias", "bias", Format::kPercent},
                                 {"bias_low", "95 % interval of the bias from", Format::kPercent},
                                 {"bias_high", "to", Format::kPercent},
                                 {"probes", "texels compared"}},
                                {"passed"});
  if (!tables.empty()) {
    tables +=
        "<p class=\"soft\">Texels drawn at random, uniform by area, are compared with an "
        "independent path tracer over the same geometry. Error: root of the mean square "
        "difference over the mean irradiance.</p>\n";
  }
  const std::string quote =
      table_of(list(report, "quote"), {{"error", "expected error", Format::kPercent},
                                       {"seconds", "expected time", Format::kSeconds},
                                       {"low", "at least", Format::kSeconds},
                                       {"high", "at most", Format::kSeconds}});
  if (!quote.empty()) tables += "<h3>Price list</h3>\n" + quote;
  const Plot plot = error_time_plot(report);
  std::string caption = "Error against time.";
  if (object(report, "accuracy").contains("certified") || !list(report, "sweep").empty()) {
    caption += " Bars: 95 % interval of the certified error.";
  }
  if (!list(report, "quote").empty()) caption += " Quoted: expected before baking.";
  std::string html =
      beside(plot.series.empty() ? std::string() : drawing(plot_svg(plot), caption), tables);
  html += table_of(list(report, "sweep"), {{"target", "target", Format::kPercent},
                                           {"certified", "certified error", Format::kPercent},
                                           {"low", "low (95 %)", Format::kPercent},
                                           {"high", "high (95 %)", Format::kPercent},
                                           {"p95", "p95", Format::kPercent},
                                           {"bias", "bias", Format::kPercent},
                                           {"seconds", "time", Format::kSeconds},
                                           {"cpu_seconds", "CPU time", Format::kSeconds},
                                           {"peak_bytes", "peak memory"},
                                           {"texels", "texels"},
                                           {"draws", "draws"}});
  return section("Accuracy", html);
}

std::string borders_section(const Json& report) {
  const std::string seams =
      table_of(list(report, "borders/seams"), {{"surface", "surface", Format::kText},
                                               {"metres", "metres of border"},
                                               {"points", "points"},
                                               {"rms", "step (rms)", Format::kPercent},
                                               {"p95", "p95", Format::kPercent},
                                               {"largest", "largest", Format::kPercent}});
  std::string html;
  if (!seams.empty()) {
    html +=
        "<h3>Seams</h3>\n" + seams +
        "<p class=\"soft\">Where two charts meet on one surface, the finished pages are read on "
        "both "
        "sides as a viewer reads them; the step is a share of the mean irradiance. Flat surfaces "
        "do "
        "not fold at the border, so all of the step is error; where they fold by up to 10 degrees "
        "the change of the light itself is in it.</p>\n";
  }
  const std::string leaks = pairs_of(object(report, "borders/leaks"),
                                     {{"points", "points looked at"},
                                      {"leaks", "bright points that no light reaches"},
                                      {"area_share", "share of the surface", Format::kPercent},
                                      {"largest", "brightest of them", Format::kPercent},
                                      {"brightest_on", "on", Format::kText},
                                      {"hidden", "further ones, hidden"}});
  if (!leaks.empty()) {
    html +=
        "<h3>Leaks</h3>\n" + leaks +
        "<p class=\"soft\">Random points, half of them at the edges of darkness. A leak is shown "
        "brighter than the target error times the mean although path tracing finds less than a "
        "ten-thousandth of the mean there. Hidden ones see little but what is closer than a "
        "texel, "
        "or the insides of solids: nobody looks in there.</p>\n";
  }
  return section("Seams and leaks", html);
}

std::string time_section(const Json& report) {
  const Json& stages = list(report, "stages");
  std::vector<Bar> bars;
  for (const Json& stage : stages) {
    const auto seconds = number(stage, "seconds");
    if (seconds) bars.push_back({text(stage, "name"), *seconds, seconds_text(*seconds)});
  }
  if (bars.empty()) return {};
  const std::string table = table_of(stages, {{"name", "stage", Format::kText},
                                              {"seconds", "time", Format::kSeconds},
                                              {"cpu_seconds", "CPU time", Format::kSeconds},
                                              {"peak_bytes", "peak memory"}});
  return section(
      "Time and memory",
      beside(drawing(bars_svg("time of each stage", bars), "Wall time of each stage."), table));
}

}  // namespace lightbatch::report
