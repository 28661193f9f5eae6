#include "client/cli/output_place.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace lightbatch::cli {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> check_writable(const fs::path& folder) {
  if (::access(folder.c_str(), W_OK | X_OK) == 0) return {};
  return "cannot write in " + folder.string() + ": " + std::strerror(errno);
}

}  // namespace

OutputPlace::~OutputPlace() {
  std::error_code not_empty;
  for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) {
    fs::remove(*folder, not_empty);
  }
}

std::optional<std::string> OutputPlace::claim_folder(const fs::path& folder) {
  fs::path part;
  for (const fs::path& name : fs::absolute(folder)) {
    part /= name;
    if (name.empty()) continue;  // after a slash at the end
    std::error_code error;
    if (fs::is_directory(part, error)) continue;
    if (fs::exists(part, error)) return part.string() + " is a file; results need a folder";
    if (!fs::create_directory(part, error)) {
      return "cannot create the folder " + part.string() + ": " + error.message();
    }
    made_.push_back(part);
  }
  return check_writable(folder);
}

std::optional<std::string> OutputPlace::check_file(const fs::path& file) {
  std::error_code error;
  if (fs::is_directory(file, error)) return file.string() + " is a folder; a file is meant";
  const fs::path folder = fs::absolute(file).parent_path();
  if (!fs::is_directory(folder, error)) return "there is no folder " + folder.string();
  return check_writable(folder);
}

}  // namespace lightbatch::cli
