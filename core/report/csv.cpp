#include <array>
#include <string_view>

#include "core/report/fields.h"
#include "core/report/html.h"
#include "core/report/text.h"

namespace lightbatch::report {

std::string sweep_csv(const nlohmann::json& report) {
  static constexpr std::array<std::string_view, 11> kColumns = {
      "target",  "certified",   "low",        "high",   "p95",  "bias",
      "seconds", "cpu_seconds", "peak_bytes", "texels", "draws"};
  std::string csv;
  for (const std::string_view column : kColumns) {
    if (!csv.empty()) csv += ',';
    csv += column;
  }
  csv += "\r\n";
  for (const Json& row : list(report, "sweep")) {
    bool first = true;
    for (const std::string_view column : kColumns) {
      if (!first) csv += ',';
      first = false;
      if (const auto value = number(row, column)) csv += significant(*value, 9);
    }
    csv += "\r\n";
  }
  return csv;
}

}  // namespace lightbatch::report
