#pragma once

#include <string>

namespace lightbatch::report {

/// Style sheet of the page: light and dark by the reader's setting, light on paper.
std::string page_style();

}  // namespace lightbatch::report
