#include "core/scene_out/new_binary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/scene_out/json_access.h"

namespace lightbatch::scene_out {
namespace {

constexpr std::uint32_t kVertices = 34962, kIndices = 34963, kPlain = 0;

/// min and max of the components, as stored.
template <typename T>
void add_bounds(std::span<const std::byte> packed, std::size_t components, Json& accessor) {
  std::vector<T> low(components), high(components);
  const std::size_t count = packed.size() / sizeof(T);
  for (std::size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, packed.data() + i * sizeof(T), sizeof(T));
    T& l = low[i % components];
    T& h = high[i % components];
    l = i < components ? value : std::min(l, value);
    h = i < components ? value : std::max(h, value);
  }
  accessor["min"] = low;
  accessor["max"] = high;
}

/// Directions of float must be unit vectors (glTF 3.7.2.1): others are scaled, those without a
/// direction become x.
Bytes unit_vectors(const AttributeType& type, std::span<const std::byte> packed) {
  constexpr float kClose = 1e-3f;
  Bytes fixed(packed.begin(), packed.end());
  for (std::size_t at = 0; at + type.bytes() <= fixed.size(); at += type.bytes()) {
    Vec3f v;
    std::memcpy(&v, fixed.data() + at, sizeof(v));
    const float size = length(v);
    if (std::abs(size - 1) <= kClose) continue;
    const Vec3d unit = normalized(to_double(v));
    v = unit == Vec3d{} ? Vec3f{1, 0, 0} : to_float(unit);
    std::memcpy(fixed.data() + at, &v, sizeof(v));
  }
  return fixed;
}

bool is_float_direction(const AttributeType& type) {
  return type.component_type == 5126 && ((type.name == "NORMAL" && type.components == 3) ||
                                         (type.name == "TANGENT" && type.components == 4));
}

}  // namespace

NewBinary::Stream& NewBinary::stream(std::uint32_t target, std::uint32_t stride) {
  const auto [it, fresh] = shared_.try_emplace({target, stride}, streams_.size());
  if (fresh) {
    Json view{{"buffer", first_buffer_ + streams_.size()}, {"byteLength", 0}};
    if (target != kPlain) view["target"] = target;
    if (target == kVertices) view["byteStride"] = stride;
    streams_.push_back({append(root_, "bufferViews", std::move(view)), {}});
  }
  return streams_[it->second];
}

std::uint32_t NewBinary::add_accessor(Stream& stream, std::span<const std::byte> bytes,
                                      Json accessor) {
  stream.bytes.resize((stream.bytes.size() + 3) / 4 * 4);
  accessor["bufferView"] = stream.view;
  if (!stream.bytes.empty()) accessor["byteOffset"] = stream.bytes.size();
  stream.bytes.insert(stream.bytes.end(), bytes.begin(), bytes.end());
  return append(root_, "accessors", std::move(accessor));
}

std::uint32_t NewBinary::add_attribute(const AttributeType& type,
                                       std::span<const std::byte> packed) {
  if (is_float_direction(type)) {
    const Bytes fixed = unit_vectors(type, packed);
    return add_attribute_as_is(type, fixed);
  }
  return add_attribute_as_is(type, packed);
}

std::uint32_t NewBinary::add_attribute_as_is(const AttributeType& type,
                                             std::span<const std::byte> packed) {
  const std::size_t size = type.bytes();
  const std::size_t stride = (size + 3) / 4 * 4;
  const std::size_t count = packed.size() / size;
  Json accessor{{"componentType", type.component_type}, {"count", count}, {"type", type.type}};
  if (type.normalized) accessor["normalized"] = true;
  if (type.name == "POSITION") {
    const auto components = static_cast<std::size_t>(type.components);
    switch (type.component_type) {
      case 5120:
        add_bounds<std::int8_t>(packed, components, accessor);
        break;
      case 5121:
        add_bounds<std::uint8_t>(packed, components, accessor);
        break;
      case 5122:
        add_bounds<std::int16_t>(packed, components, accessor);
        break;
      case 5123:
        add_bounds<std::uint16_t>(packed, components, accessor);
        break;
      default:
        add_bounds<float>(packed, components, accessor);
    }
  }
  Stream& into = stream(kVertices, static_cast<std::uint32_t>(stride));
  if (stride == size) return add_accessor(into, packed, std::move(accessor));
  Bytes padded(count * stride);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(padded.data() + i * stride, packed.data() + i * size, size);
  return add_accessor(into, padded, std::move(accessor));
}

std::uint32_t NewBinary::add_indices(std::span<const std::uint32_t> indices) {
  std::uint32_t largest = 0;
  for (const std::uint32_t i : indices) largest = std::max(largest, i);
  Json accessor{{"count", indices.size()}, {"type", "SCALAR"}};
  if (largest < 0xffff) {
    std::vector<std::uint16_t> narrow(indices.begin(), indices.end());
    accessor["componentType"] = 5123;
    return add_accessor(stream(kIndices, 2), std::as_bytes(std::span(narrow)), std::move(accessor));
  }
  accessor["componentType"] = 5125;
  return add_accessor(stream(kIndices, 4), std::as_bytes(indices), std::move(accessor));
}

std::uint32_t NewBinary::add_instance_floats(std::span<const float> values, int components) {
  Json accessor{{"componentType", 5126},
                {"count", values.size() / static_cast<std::size_t>(components)},
                {"type", components == 3 ? "VEC3" : "VEC4"}};
  return add_accessor(stream(kPlain, 4 * static_cast<std::uint32_t>(components)),
                      std::as_bytes(values), std::move(accessor));
}

std::uint32_t NewBinary::add_file(std::span<const std::byte> bytes) {
  const std::uint32_t view =
      append(root_, "bufferViews",
             Json{{"buffer", first_buffer_ + streams_.size()}, {"byteLength", bytes.size()}});
  streams_.push_back({view, Bytes(bytes.begin(), bytes.end())});
  return view;
}

std::vector<Bytes> NewBinary::finish() {
  std::vector<Bytes> buffers;
  for (Stream& s : streams_) {
    root_["bufferViews"][s.view]["byteLength"] = s.bytes.size();
    buffers.push_back(std::move(s.bytes));
  }
  return buffers;
}

}  // namespace lightbatch::scene_out
