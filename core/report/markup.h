#pragma once

#include <initializer_list>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/report/fields.h"
#include "core/report/html.h"

namespace lightbatch::report {

/// Pieces of the page. Arguments named `html` are markup already; all others are escaped here.

/// A section; nothing when the body is empty.
std::string section(std::string_view title, const std::string& html);
/// A drawing with its caption.
std::string drawing(const std::string& svg, std::string_view caption);
/// The pictures of one kind, each with title and caption; nothing when there are none.
std::string pictures_of(const std::vector<Picture>& pictures, PictureKind kind);

enum class Format {
  kText,
  kNumber,  // by value_text
  kPercent,
  kSeconds,
};

/// One column of a table over an array of objects, or one line of a list of pairs.
struct Column {
  std::string key;    // path in the object
  std::string title;  // escaped
  Format format = Format::kNumber;
};
/// Columns that no row has are left out; at most kMostRows rows, then a line that says how many
/// more report.json has.
std::string table_of(const Json& rows, const std::vector<Column>& columns);
inline constexpr std::size_t kMostRows = 200;

/// Key and value of each member: those of `first` in their order, then the others, but for those in
/// `left_out`.
std::string pairs_of(const Json& object, const std::vector<Column>& first = {},
                     const std::set<std::string>& left_out = {});

/// A drawing (or nothing) with tables beside it where the page is wide enough.
std::string beside(const std::string& drawing_html, const std::string& tables_html);

/// Members of the rows that no column names, as further columns (scalars only).
std::vector<Column> with_further(const Json& rows, std::vector<Column> columns);

}  // namespace lightbatch::report
