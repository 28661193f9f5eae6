#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/report/html.h"

namespace lightbatch::report {

/// A report with every section of the schema, with figures of ordinary size.
nlohmann::json sample_report();

/// Empty when `markup` is well-formed XML as far as tags go (each opened tag closed in order, void
/// elements of HTML aside); else what is wrong.
std::string tag_fault(const std::string& markup);

}  // namespace lightbatch::report
