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
  std::string html;
  const Plot plot = error_time_plot(report);
  if (!plot.series.empty()) {
    html +=
        drawing(plot_svg(plot),
                "Error against time. Bars: 95 % interval of the certified error. Quoted: expected "
                "before baking.");
  }
  html += table_of(list(report, "sweep"), {{"target", "target", true},
                                           {"certified", "certified error", true},
                                           {"low", "low (95 %)", true},
                                           {"high", "high (95 %)", true},
                                           {"p95", "p95", true},
                                           {"bias", "bias", true},
                                           {"seconds", "time", true},
                                           {"cpu_seconds", "CPU time", true},
                                           {"peak_bytes", "peak memory", true},
                                           {"texels", "texels", true},
                                           {"draws", "draws", true}});
  if (const std::string quote = table_of(list(report, "quote"), {{"error", "expected error", true},
                                                                 {"seconds", "expected time", true},
                                                                 {"low", "at least", true},
                                                                 {"high", "at most", true}});
      !quote.empty()) {
    html += "<h3>Price list</h3>\n" + quote;
  }
  if (const std::string figures = pairs_of(object(report, "accuracy")); !figures.empty()) {
    html +=
        "<h3>Certificate</h3>\n"
        "<p class=\"soft\">Texels drawn at random, uniform by area, compared with an independent "
        "path tracer over the same geometry. Error: root of the mean square difference over the "
        "mean irradiance.</p>\n" +
        figures;
  }
  return section("Accuracy", html);
}

std::string time_section(const Json& report) {
  std::vector<Bar> bars;
  for (const Json& stage : list(report, "stages")) {
    const auto seconds = number(stage, "seconds");
    if (!seconds) continue;
    bars.push_back({text(stage, "name"), *seconds, seconds_text(*seconds), 0});
  }
  if (bars.empty()) return {};
  std::string html = drawing(bars_svg("time of each stage", bars), "Wall time of each stage.");
  html += table_of(list(report, "stages"), {{"name", "stage", false},
                                            {"seconds", "time", true},
                                            {"cpu_seconds", "CPU time", true},
                                            {"peak_bytes", "peak memory", true}});
  return section("Time and memory", html);
}

}  // namespace lightbatch::report
