#include <array>
#include <charconv>
#include <cmath>

#include "core/gltf/json_text.h"

namespace lightbatch::gltf {
namespace {

Status internal_error(const char* message) {
  return {StatusCode::kInternal, "JSON_WRITE_FAILED", message};
}

/// Depth of recursion is that of the tree: bounded for what parse_json read
/// (ReadLimits::json_depth), a handful of levels more for what writers add.
class Writer {
 public:
  Status write(const Json& json) {
    switch (json.type()) {
      case Json::value_t::object:
        return write_object(json);
      case Json::value_t::array:
        return write_array(json);
      case Json::value_t::string:
        return write_string(json.get_ref<const std::string&>());
      case Json::value_t::boolean:
        text += json.get<bool>() ? "true" : "false";
        return {};
      case Json::value_t::number_integer:
        write_number(json.get<std::int64_t>());
        return {};
      case Json::value_t::number_unsigned:
        write_number(json.get<std::uint64_t>());
        return {};
      case Json::value_t::number_float:
        if (!std::isfinite(json.get<double>())) return internal_error("a number is not finite");
        write_number(json.get<double>());
        return {};
      case Json::value_t::null:
        text += "null";
        return {};
      case Json::value_t::binary:
      case Json::value_t::discarded:
        break;
    }
    return internal_error("a value has no JSON form");
  }

  std::string text;

 private:
  template <typename Number>
  void write_number(Number number) {
    std::array<char, 32> buffer;
    const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number);
    text.append(buffer.data(), result.ptr);
  }

  Status write_string(const std::string& value) {
    try {
      text += Json(value).dump();
    } catch (const Json::exception&) {
      return internal_error("a string is not UTF-8");
    }
    return {};
  }

  Status write_object(const Json& json) {
    char separator = '{';
    for (const auto& [name, value] : json.items()) {
      text += separator;
      separator = ',';
      LB_RETURN_IF_ERROR(write_string(name));
      text += ':';
      LB_RETURN_IF_ERROR(write(value));
    }
    text += separator == '{' ? "{}" : "}";
    return {};
  }

  Status write_array(const Json& json) {
    char separator = '[';
    for (const Json& value : json) {
      text += separator;
      separator = ',';
      LB_RETURN_IF_ERROR(write(value));
    }
    text += separator == '[' ? "[]" : "]";
    return {};
  }
};

}  // namespace

Result<std::string> write_json(const Json& json) {
  Writer writer;
  LB_RETURN_IF_ERROR(writer.write(json));
  return std::move(writer.text);
}

}  // namespace lightbatch::gltf
