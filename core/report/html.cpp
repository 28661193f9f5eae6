#include "core/report/html.h"

#include "core/report/fields.h"
#include "core/report/markup.h"
#include "core/report/sections.h"
#include "core/report/style.h"
#include "core/report/text.h"

namespace lightbatch::report {

std::string html(const nlohmann::json& report, const std::vector<Picture>& pictures) {
  const std::string name = text(report, "input/name");
  std::string page =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      // The browser itself holds the page to its promise: no script, nothing from outside.
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
      "style-src 'unsafe-inline'; img-src data:\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      escape(name.empty() ? "lightbatch report" : name + " · lightbatch") + "</title>\n<style>" +
      page_style() + "</style>\n</head>\n<body>\n<main>\n";
  page += head_section(report);
  page += warnings_section(report);
  page += section("Views", pictures_of(pictures, PictureKind::kView));
  page += accuracy_section(report);
  page += borders_section(report);
  page += time_section(report);
  page += plan_section(report);
  page += lightmap_section(report, pictures);
  page += probes_section(report);
  page += radiosity_section(report);
  page += batches_section(report);
  page += hierarchy_section(report, pictures);
  page += scene_section(report);
  page +=
      "<footer>Everything on this page is in report.json, too. Errors are relative, light is in "
      "lux, lengths in metres.</footer>\n</main>\n</body>\n</html>\n";
  return page;
}

}  // namespace lightbatch::report
