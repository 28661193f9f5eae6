#pragma once

#include <string>

namespace lightbatch::server {

/// Tells programs apart that were built anew from changed sources and name the same version: 64
/// hexadecimal digits, the same for each run of one executable.
const std::string& executable_digest();

}  // namespace lightbatch::server
