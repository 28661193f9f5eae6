#include "core/report/fields.h"

#include <algorithm>
#include <cmath>

#include "core/report/text.h"

namespace lightbatch::report {
namespace {

constexpr std::size_t kLongestList = 12;

const Json& empty_list() {
  static const Json value = Json::array();
  return value;
}
const Json& empty_object() {
  static const Json value = Json::object();
  return value;
}

bool ends_with_any(std::string_view key, std::initializer_list<std::string_view> ends) {
  return std::any_of(ends.begin(), ends.end(),
                     [&](std::string_view e) { return key.ends_with(e); });
}

std::string number_text(std::string_view key, double value) {
  if (ends_with_any(key, {"bytes"})) return bytes_text(value);
  if (ends_with_any(key, {"seconds", "time_budget"})) return seconds_text(value);
  if (ends_with_any(key, {"share", "utilisation", "error", "errors"})) return percent_text(value);
  return count_text(value);
}

}  // namespace

const Json* find(const Json& root, std::string_view path) {
  const Json* at = &root;
  while (!path.empty()) {
    const std::size_t slash = std::min(path.find('/'), path.size());
    if (!at->is_object()) return nullptr;
    const auto member = at->find(std::string(path.substr(0, slash)));
    if (member == at->end()) return nullptr;
    at = &*member;
    path.remove_prefix(std::min(slash + 1, path.size()));
  }
  return at->is_null() ? nullptr : at;
}

std::optional<double> number(const Json& root, std::string_view path) {
  const Json* value = find(root, path);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  const double held = value->get<double>();
  return std::isfinite(held) ? std::optional(held) : std::nullopt;
}

std::string text(const Json& root, std::string_view path) {
  const Json* value = find(root, path);
  return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
}

std::optional<bool> flag(const Json& root, std::string_view path) {
  const Json* value = find(root, path);
  return value != nullptr && value->is_boolean() ? std::optional(value->get<bool>()) : std::nullopt;
}

const Json& list(const Json& root, std::string_view path) {
  const Json* value = find(root, path);
  return value != nullptr && value->is_array() ? *value : empty_list();
}

const Json& object(const Json& root, std::string_view path) {
  const Json* value = find(root, path);
  return value != nullptr && value->is_object() ? *value : empty_object();
}

std::string value_text(std::string_view key, const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number()) return number_text(key, value.get<double>());
  if (value.is_array() || value.is_object()) {
    std::string joined;
    std::size_t shown = 0;
    for (const auto& [name, item] : value.items()) {
      if (shown++ > 0) joined += ", ";
      if (shown > kLongestList) return joined + "… (" + std::to_string(value.size()) + ")";
      if (value.is_object()) joined += key_text(name) + " ";
      joined += value_text(value.is_object() ? std::string_view(name) : key, item);
    }
    return joined.empty() ? "none" : joined;
  }
  return "-";
}

std::string key_text(std::string_view key) {
  std::string out(key);
  std::replace(out.begin(), out.end(), '_', ' ');
  return out;
}

}  // namespace lightbatch::report
