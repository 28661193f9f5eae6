#include "core/report/markup.h"

#include <algorithm>

#include "core/report/text.h"

namespace lightbatch::report {
namespace {

std::string formatted(const Column& column, const Json& value) {
  if (value.is_number()) {
    if (column.format == Format::kPercent) return percent_text(value.get<double>());
    if (column.format == Format::kSeconds) return seconds_text(value.get<double>());
  }
  return value_text(column.key, value);
}

}  // namespace

std::string section(std::string_view title, const std::string& html) {
  if (html.empty()) return {};
  return "<section>\n<h2>" + escape(title) + "</h2>\n" + html + "</section>\n";
}

std::string drawing(const std::string& svg, std::string_view caption) {
  return "<figure>" + svg + "<figcaption>" + escape(caption) + "</figcaption></figure>\n";
}

std::string pictures_of(const std::vector<Picture>& pictures, PictureKind kind) {
  std::string figures;
  for (const Picture& picture : pictures) {
    if (picture.kind != kind || picture.png.empty()) continue;
    const std::string texels = kind == PictureKind::kLightmap ? " class=\"texels\"" : "";
    figures += "<figure><img" + texels + " alt=\"" + escape(picture.title) +
               "\" src=\"data:image/png;base64," + base64(picture.png) + "\"><figcaption>" +
               escape(picture.title);
    if (!picture.caption.empty()) figures += " · " + escape(picture.caption);
    figures += "</figcaption></figure>\n";
  }
  if (figures.empty()) return {};
  const std::string size = kind == PictureKind::kView ? " large" : "";
  return "<div class=\"pictures" + size + "\">\n" + figures + "</div>\n";
}

std::string table_of(const Json& rows, const std::vector<Column>& columns) {
  std::vector<Column> held;
  for (const Column& column : columns) {
    const auto has = [&](const Json& row) { return find(row, column.key) != nullptr; };
    if (std::any_of(rows.begin(), rows.end(), has)) held.push_back(column);
  }
  if (held.empty()) return {};
  std::string html = "<div class=\"wide\"><table>\n<thead><tr>";
  for (const Column& column : held) {
    html += std::string("<th scope=\"col\"") +
            (column.format == Format::kText ? ">" : " class=\"n\">") + escape(column.title) +
            "</th>";
  }
  html += "</tr></thead>\n<tbody>\n";
  std::size_t shown = 0;
  for (const Json& row : rows) {
    if (shown++ == kMostRows) break;
    html += "<tr>";
    for (const Column& column : held) {
      const Json* value = find(row, column.key);
      html += column.format == Format::kText ? "<td>" : "<td class=\"n\">";
      html += (value == nullptr ? "" : escape(formatted(column, *value))) + "</td>";
    }
    html += "</tr>\n";
  }
  html += "</tbody></table></div>\n";
  if (rows.size() > kMostRows) {
    html += "<p class=\"soft\">and " + count_text(static_cast<double>(rows.size() - kMostRows)) +
            " more in report.json</p>\n";
  }
  return html;
}

std::string pairs_of(const Json& object, const std::vector<Column>& first,
                     const std::set<std::string>& left_out) {
  if (!object.is_object()) return {};
  std::string rows;
  std::set<std::string> done = left_out;
  const auto add = [&](const Column& column, const Json& value) {
    if (!done.insert(column.key).second || value.is_null()) return;
    const bool code = column.key.find("sha256") != std::string::npos || column.key == "id";
    rows += "<tr><th scope=\"row\">" + escape(column.title) + "</th><td>" + (code ? "<code>" : "") +
            escape(formatted(column, value)) + (code ? "</code>" : "") + "</td></tr>\n";
  };
  for (const Column& column : first) {
    if (const Json* value = find(object, column.key)) add(column, *value);
  }
  for (const auto& [key, value] : object.items()) add({key, key_text(key)}, value);
  if (rows.empty()) return {};
  return "<table class=\"pairs\"><tbody>\n" + rows + "</tbody></table>\n";
}

std::string beside(const std::string& drawing_html, const std::string& tables_html) {
  if (drawing_html.empty() || tables_html.empty()) return drawing_html + tables_html;
  return "<div class=\"beside\"><div>" + drawing_html + "</div><div>" + tables_html +
         "</div></div>\n";
}

std::vector<Column> with_further(const Json& rows, std::vector<Column> columns) {
  for (const Json& row : rows) {
    if (!row.is_object()) continue;
    for (const auto& [key, value] : row.items()) {
      const auto named = [&key = key](const Column& column) { return column.key == key; };
      if (value.is_structured() || std::any_of(columns.begin(), columns.end(), named)) continue;
      columns.push_back({key, key_text(key), value.is_number() ? Format::kNumber : Format::kText});
    }
  }
  return columns;
}

}  // namespace lightbatch::report
