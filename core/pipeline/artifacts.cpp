#include "core/pipeline/artifacts.h"

#include <algorithm>
#include <system_error>

namespace lightbatch::pipeline {

Artifacts::~Artifacts() {
  if (keep_) return;
  for (const std::string& name : names_) {
    std::error_code ignored;
    std::filesystem::remove(folder_ / name, ignored);
  }
}

Status Artifacts::add(const std::string& name, std::span<const std::byte> bytes) {
  LB_RETURN_IF_ERROR(write_file(folder_ / name, bytes));
  names_.push_back(name);
  return {};
}

std::vector<std::string> Artifacts::names() const {
  std::vector<std::string> sorted = names_;
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

}  // namespace lightbatch::pipeline
