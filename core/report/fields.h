#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace lightbatch::report {

using Json = nlohmann::json;

/// Reading a report that may lack anything and hold anything: nothing here throws.

/// Member by path ("lightmaps/pages"); null when a step is missing, no object, or null.
const Json* find(const Json& root, std::string_view path);
/// A finite number.
std::optional<double> number(const Json& root, std::string_view path);
/// A string; empty when there is none.
std::string text(const Json& root, std::string_view path);
std::optional<bool> flag(const Json& root, std::string_view path);
/// Elements of an array; an empty array when there is none.
const Json& list(const Json& root, std::string_view path);
/// Members of an object; an empty object when there is none.
const Json& object(const Json& root, std::string_view path);

/// A scalar for people, by what its key says: ..bytes, ..seconds, ..share or utilisation; other
/// numbers with thousands separated. Lists are joined, objects flattened. Not escaped.
std::string value_text(std::string_view key, const Json& value);
/// "texels_per_metre" -> "texels per metre"
std::string key_text(std::string_view key);

}  // namespace lightbatch::report
