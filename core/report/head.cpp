// What a reader wants to know first: which scene, is it good enough, what did it cost.

#include "core/report/plot.h"
#include "core/report/sections.h"
#include "core/report/text.h"

namespace lightbatch::report {
namespace {

std::string kind_title(const std::string& kind) {
  if (kind == "plan") return "Effect plan";
  if (kind == "quote") return "Price list";
  if (kind == "sweep") return "Sweep of error targets";
  if (kind == "hierarchy") return "Bounding-volume hierarchy";
  if (kind == "relight") return "Relit bake";
  return "Bake";
}

std::string interval_text(const Json& report) {
  const auto low = number(report, "accuracy/low"), high = number(report, "accuracy/high");
  if (!low || !high) return {};
  return " (95 % interval " + significant(100 * *low, 3) + " to " + percent_text(*high) + ")";
}

std::string verdict(const Json& report) {
  const auto certified = number(report, "accuracy/certified");
  const auto target = number(report, "accuracy/target");
  if (!certified) return {};
  const std::string measured =
      "certified error " + percent_text(*certified) + interval_text(report);
  if (!target || *target <= 0) {
    return "<p class=\"verdict plain\">" + escape("Done: " + measured) + "</p>\n";
  }
  const bool passed = flag(report, "accuracy/passed").value_or(*certified <= *target);
  return std::string("<p class=\"verdict ") + (passed ? "good" : "bad") + "\">" +
         escape((passed ? "Target met: " : "Target missed: ") + measured + ", target " +
                percent_text(*target)) +
         "</p>\n";
}

std::string fact(const std::string& value, const std::string& name) {
  return "<div class=\"fact\"><b>" + escape(value) + "</b><span>" + escape(name) +
         "</span></div>\n";
}

std::string facts(const Json& report) {
  std::string html;
  const auto add = [&](std::string_view path, std::string (*format)(double), const char* name) {
    if (const auto value = number(report, path)) html += fact(format(*value), name);
  };
  add("total/seconds", seconds_text, "wall time");
  add("total/peak_bytes", bytes_text, "peak memory");
  add("scene/triangles", count_text, "triangles");
  add("lightmaps/texels", count_text, "texels");
  // All draws of the scene where they are told, else those of a view.
  const bool all = number(report, "batches/after/all_draws").has_value();
  const auto before = number(report, all ? "batches/before/all_draws" : "batches/before/draws");
  const auto after = number(report, all ? "batches/after/all_draws" : "batches/after/draws");
  if (before && after) {
    html += fact(count_text(*before) + " → " + count_text(*after), "draw calls");
  }
  return html.empty() ? html : "<div class=\"facts\">\n" + html + "</div>\n";
}

}  // namespace

std::string head_section(const Json& report) {
  const std::string name = text(report, "input/name");
  const std::string kind = kind_title(text(report, "kind"));
  std::string html = "<header>\n<p class=\"kicker\">lightbatch · " + escape(kind) + "</p>\n<h1>" +
                     escape(name.empty() ? "Report" : name) + "</h1>\n";
  html += verdict(report);
  if (const auto certified = number(report, "accuracy/certified")) {
    html += gauge_svg({*certified, number(report, "accuracy/low").value_or(0),
                       number(report, "accuracy/high").value_or(0),
                       number(report, "accuracy/target").value_or(0)});
  }
  return html + facts(report) + "</header>\n";
}

std::string warnings_section(const Json& report) {
  std::string items;
  for (const Json& warning : list(report, "warnings")) {
    std::string words = warning.is_string() ? warning.get<std::string>() : text(warning, "message");
    if (const std::string place = text(warning, "place"); !place.empty()) {
      words += " (at " + place + ")";
    }
    if (const auto count = number(warning, "count")) words += ", " + count_text(*count) + " times";
    if (!words.empty()) items += "<li>" + escape(words) + "</li>\n";
  }
  if (items.empty()) return {};
  return "<section class=\"warnings\">\n<h2>Warnings</h2>\n<ul class=\"plain\">\n" + items +
         "</ul>\n</section>\n";
}

}  // namespace lightbatch::report
