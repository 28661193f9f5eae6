#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/status.h"

namespace lightbatch::pipeline {

/// The files of one job's output folder: all of them, or (unless keep() was said) none.
class Artifacts {
 public:
  explicit Artifacts(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~Artifacts();
  Artifacts(const Artifacts&) = delete;
  Artifacts& operator=(const Artifacts&) = delete;

  Status add(const std::string& name, std::span<const std::byte> bytes);
  Status add(const std::string& name, std::string_view text) { return add(name, as_bytes(text)); }
  /// The job succeeded: the files stay.
  void keep() { keep_ = true; }
  /// Sorted names.
  std::vector<std::string> names() const;

 private:
  std::filesystem::path folder_;
  std::vector<std::string> names_;
  bool keep_ = false;
};

}  // namespace lightbatch::pipeline
