#include "tests/fuzz/mutate.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>
#include <vector>

#include "core/gltf/glb_container.h"
#include "core/gltf/glb_writer.h"

namespace lightbatch::fuzz {
namespace {

using gltf::Json;

/// Every value of the tree, containers too; pointers stay good until the tree changes.
void collect(Json& json, std::vector<Json*>& values) {
  values.push_back(&json);
  if (!json.is_structured()) return;
  for (auto& item : json) collect(item, values);
}

Json telling_value(Random& random) {
  static const std::array<Json, 24> kValues = {0,
                                               1,
                                               2,
                                               3,
                                               -1,
                                               255,
                                               256,
                                               65535,
                                               65536,
                                               2147483647,
                                               2147483648,
                                               4294967295,
                                               4294967296,
                                               9007199254740991,
                                               0.5,
                                               -0.0,
                                               1e-300,
                                               1e300,
                                               nullptr,
                                               true,
                                               "",
                                               Json::array(),
                                               Json::object(),
                                               18446744073709551615ull};
  return kValues[random.below(kValues.size())];
}

void change_json(Json& json, Random& random) {
  std::vector<Json*> values;
  collect(json, values);
  Json& target = *values[random.below(values.size())];
  switch (random.below(6)) {
    case 0:
      target = telling_value(random);
      break;
    case 1: {
      const Json copy = *values[random.below(values.size())];
      target = copy;
      break;
    }
    case 2:
      if (target.is_number_integer()) {
        const auto step = static_cast<std::int64_t>(random.below(9)) - 4;
        target = target.get<std::int64_t>() + step;
      } else if (target.is_number()) {
        target = target.get<double>() * -3.0;
      } else {
        target = telling_value(random);
      }
      break;
    case 3:
      if (target.is_array() && !target.empty()) {
        target.erase(random.below(target.size()));
      } else if (target.is_object() && !target.empty()) {
        auto member = target.begin();
        std::advance(member, static_cast<std::ptrdiff_t>(random.below(target.size())));
        target.erase(member);
      }
      break;
    case 4:
      if (target.is_array() && !target.empty()) {
        const Json item = target[random.below(target.size())];
        target.push_back(item);
      }
      break;
    default:
      if (target.is_array() && target.size() > 1) {
        std::swap(target[random.below(target.size())], target[random.below(target.size())]);
      }
      break;
  }
}

void change_bytes(Bytes& bytes, Random& random) {
  if (bytes.empty()) return;
  const std::size_t at = random.below(bytes.size());
  switch (random.below(4)) {
    case 0:
      bytes[at] ^= static_cast<std::byte>(1u << random.below(8));
      break;
    case 1:
      bytes[at] = static_cast<std::byte>(random.below(256));
      break;
    case 2:
      for (std::size_t i = at; i < std::min(bytes.size(), at + 4); ++i) bytes[i] = std::byte{0xff};
      break;
    default:
      bytes.resize(at);
      break;
  }
}

}  // namespace

std::optional<Parts> split(const Bytes& file) {
  Parts parts;
  std::string_view text = as_text(file);
  if (gltf::is_glb(file)) {
    const auto chunks = gltf::split_glb(file, "seed");
    if (!chunks.ok()) return std::nullopt;
    text = chunks->json;
    if (chunks->binary) parts.binary.assign(chunks->binary->begin(), chunks->binary->end());
  }
  parts.json = Json::parse(text, nullptr, false);
  if (parts.json.is_discarded() || !parts.json.is_object()) return std::nullopt;
  return parts;
}

Bytes damage(const Bytes& file, const std::optional<Parts>& parts, Random& random,
             std::uint64_t most) {
  const std::uint64_t changes = 1 + random.below(most);
  if (!parts || random.below(8) == 0) {
    Bytes bytes = file;
    for (std::uint64_t i = 0; i < changes; ++i) change_bytes(bytes, random);
    return bytes;
  }
  Parts changed = *parts;
  for (std::uint64_t i = 0; i < changes; ++i) {
    if (random.below(3) == 0) {
      change_bytes(changed.binary, random);
    } else {
      change_json(changed.json, random);
    }
  }
  // The writer sets the length of buffer 0, which a damaged list may not have.
  const bool plain = changed.binary.empty() || !changed.json.is_object() ||
                     !changed.json.contains("buffers") || !changed.json["buffers"].is_array() ||
                     changed.json["buffers"].empty() || !changed.json["buffers"][0].is_object();
  if (plain) {
    const std::string text = changed.json.dump(-1, ' ', false, Json::error_handler_t::replace);
    const auto bytes = as_bytes(text);
    return Bytes(bytes.begin(), bytes.end());
  }
  auto glb = gltf::write_glb(changed.json, changed.binary);
  return glb.ok() ? std::move(glb).value() : file;
}

}  // namespace lightbatch::fuzz
