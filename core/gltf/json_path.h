#pragma once

#include <cstddef>
#include <string>

namespace lightbatch::gltf {

/// A JSON pointer that costs nothing until it is printed: each level of a walk keeps its own link
/// on the stack. The parent must outlive the child.
class JsonPath {
 public:
  explicit JsonPath(const std::string& file) : file_(&file) {}
  JsonPath(const JsonPath& parent, const char* name) : parent_(&parent), name_(name) {}
  JsonPath(const JsonPath& parent, const std::string& name)
      : parent_(&parent), name_(name.c_str()) {}
  JsonPath(const JsonPath& parent, std::size_t index) : parent_(&parent), index_(index) {}

  /// "scene.gltf#/accessors/3/count"
  std::string text() const {
    if (file_ != nullptr) return *file_ + "#";
    return parent_->text() + "/" + (name_ != nullptr ? escaped() : std::to_string(index_));
  }

 private:
  /// RFC 6901: ~ and / are written ~0 and ~1.
  std::string escaped() const {
    std::string text;
    for (const char* c = name_; *c != '\0'; ++c) {
      if (*c == '~') {
        text += "~0";
      } else if (*c == '/') {
        text += "~1";
      } else {
        text += *c;
      }
    }
    return text;
  }

  const std::string* file_ = nullptr;
  const JsonPath* parent_ = nullptr;
  const char* name_ = nullptr;
  std::size_t index_ = 0;
};

}  // namespace lightbatch::gltf
