#pragma once

#include <string>
#include <vector>

#include "core/report/fields.h"
#include "core/report/html.h"

namespace lightbatch::report {

/// The parts of the page, in its order; each is empty when the report holds nothing for it.
std::string head_section(const Json& report);
std::string warnings_section(const Json& report);
std::string accuracy_section(const Json& report);
std::string borders_section(const Json& report);
std::string time_section(const Json& report);
std::string plan_section(const Json& report);
std::string lightmap_section(const Json& report, const std::vector<Picture>& pictures);
std::string probes_section(const Json& report);
std::string radiosity_section(const Json& report);
std::string batches_section(const Json& report);
std::string hierarchy_section(const Json& report, const std::vector<Picture>& pictures);
std::string scene_section(const Json& report);

}  // namespace lightbatch::report
