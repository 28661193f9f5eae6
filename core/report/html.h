#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/bytes.h"

namespace lightbatch::report {

enum class PictureKind { kView, kLightmap, kHierarchy };

/// A PNG to show. Views come first in the page, lightmap pages and hierarchy levels in their
/// sections.
struct Picture {
  std::string title;
  Bytes png;
  PictureKind kind = PictureKind::kView;
  std::string caption = {};
};

/// report.html: one file for people, made of the report that README.md describes. Style, drawings
/// and pictures are inside; it loads nothing and runs nothing. Whatever the report lacks is left
/// out of the page; whatever it holds is escaped. Same report and pictures, same bytes.
std::string html(const nlohmann::json& report, const std::vector<Picture>& pictures);

/// Error against time of a report's `quote` and `sweep`, both logarithmic: a drawing of its own.
std::string error_time_svg(const nlohmann::json& report);

/// `sweep` as CSV (RFC 4180): target, certified, interval, p95, bias, seconds, cpu seconds, peak
/// bytes, texels, draws; empty where not known.
std::string sweep_csv(const nlohmann::json& report);

}  // namespace lightbatch::report
