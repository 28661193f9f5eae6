#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace lightbatch::cli {

/// Where results will go, tried before the work: what cannot be written is told at once, not after
/// hours. Folders are made, and taken away again when nothing came to lie in them.
class OutputPlace {
 public:
  OutputPlace() = default;
  OutputPlace(const OutputPlace&) = delete;
  OutputPlace& operator=(const OutputPlace&) = delete;
  ~OutputPlace();

  /// What is wrong with it, if anything.
  std::optional<std::string> claim_folder(const std::filesystem::path& folder);
  /// The same for a file in a folder that is there.
  static std::optional<std::string> check_file(const std::filesystem::path& file);

 private:
  std::vector<std::filesystem::path> made_;  // outermost first
};

}  // namespace lightbatch::cli
