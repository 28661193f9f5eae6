#include "core/scene_out/corners.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace lightbatch::scene_out {
namespace {

template <typename T>
double load(const std::byte* at, bool normalized) {
  T v;
  std::memcpy(&v, at, sizeof(T));
  const double value = static_cast<double>(v);
  return normalized ? std::max(value / static_cast<double>(std::numeric_limits<T>::max()), -1.0)
                    : value;
}

template <typename T>
void store(double value, bool normalized, Bytes& bytes) {
  constexpr double kHigh = std::numeric_limits<T>::max(), kLow = std::numeric_limits<T>::lowest();
  const double scaled = normalized ? value * kHigh : value;
  const T v =
      static_cast<T>(std::clamp(std::round(scaled), normalized && kLow < 0 ? -kHigh : kLow, kHigh));
  std::byte raw[sizeof(T)];
  std::memcpy(raw, &v, sizeof(T));
  bytes.insert(bytes.end(), raw, raw + sizeof(T));
}

bool is_direction(const AttributeType& type) {
  return (type.name == "NORMAL" || type.name == "TANGENT") && type.components >= 3 &&
         (type.component_type == 5126 || type.component_type == 5120 ||
          type.component_type == 5122);
}

/// Of a normalised component; 0 for floats.
double largest_value(const AttributeType& type) {
  return type.component_type == 5120 ? 127 : type.component_type == 5122 ? 32767 : 0;
}

/// So near to an integer, a turn by right angles led there.
constexpr double kWhole = 1e-3;

/// Between two numbers of features or joints lies no third.
bool is_number_of_something(const AttributeType& type) {
  if (type.name.starts_with("_FEATURE_ID_") || type.name.starts_with("JOINTS_")) return true;
  return type.name.starts_with("_") && type.component_type != 5126 && !type.normalized;
}

}  // namespace

double component(const AttributeType& type, const std::byte* element, std::size_t i) {
  const std::byte* at = element + i * type.component_bytes();
  // Directions of bytes and shorts count as normalised whether they say so or not.
  const bool n = type.normalized || is_direction(type);
  switch (type.component_type) {
    case 5120:
      return load<std::int8_t>(at, n);
    case 5121:
      return load<std::uint8_t>(at, n);
    case 5122:
      return load<std::int16_t>(at, n);
    case 5123:
      return load<std::uint16_t>(at, n);
    case 5125:
      return load<std::uint32_t>(at, n);
    default:
      return load<float>(at, false);
  }
}

void push_component(const AttributeType& type, double value, Bytes& bytes) {
  const bool n = type.normalized || is_direction(type);
  switch (type.component_type) {
    case 5120:
      return store<std::int8_t>(value, n, bytes);
    case 5121:
      return store<std::uint8_t>(value, n, bytes);
    case 5122:
      return store<std::int16_t>(value, n, bytes);
    case 5123:
      return store<std::uint16_t>(value, n, bytes);
    case 5125:
      return store<std::uint32_t>(value, n, bytes);
    default: {
      const auto v = static_cast<float>(value);
      push_floats(bytes, &v, 1);
    }
  }
}

void push_floats(Bytes& bytes, const float* values, std::size_t count) {
  const std::byte* raw = reinterpret_cast<const std::byte*>(values);
  bytes.insert(bytes.end(), raw, raw + count * sizeof(float));
}

CornerPlan plan_corners(const std::vector<AttributeType>& types, bool drop_uv1,
                        std::uint32_t moved_set) {
  CornerPlan plan;
  for (std::size_t i = 0; i < types.size(); ++i) {
    AttributeType type = types[i];
    if (type.name == "TEXCOORD_1") {
      if (moved_set != kNone)
        type.name = "TEXCOORD_" + std::to_string(moved_set);
      else if (drop_uv1)
        continue;
    }
    if (type.name == "POSITION") {
      type.component_type = 5126;
      type.normalized = false;
    }
    plan.source.push_back(i);
    plan.types.push_back(std::move(type));
  }
  return plan;
}

bool leads_to_integers(const Affine& m) {
  constexpr double kRounding = 1e-6;
  const double size = length(m.x);
  for (const Vec3d& axis : {m.x, m.y, m.z}) {
    int zeros = 0;
    for (std::size_t c = 0; c < 3; ++c) zeros += std::abs(axis[c]) <= kRounding * size ? 1 : 0;
    if (zeros != 2 || std::abs(length(axis) - size) > kRounding * size) return false;
  }
  return true;
}

void widen_directions(CornerPlan& plan) {
  for (AttributeType& type : plan.types)
    if (is_direction(type) && type.component_type == 5120) {
      type.component_type = 5122;
      type.normalized = true;
    }
}

CornerCopier::CornerCopier(const CornerPlan& plan, const SourcePrimitive& source,
                           const scene::Object& object, const Vec3d& frame)
    : plan_(plan), source_(source), to_frame_(object.to_world), mirrored_(object.mirrored) {
  to_frame_.t = object.to_world.t - frame;
}

CornerCopier::CornerCopier(const CornerPlan& plan, const SourcePrimitive& source)
    : plan_(plan), source_(source) {}

void CornerCopier::push_direction(const AttributeType& type, const AttributeType& to,
                                  const Vec3d& direction, Bytes& out) const {
  const bool normal = type.name == "NORMAL";
  const Vec3d turned =
      normalized(normal ? to_frame_.normal(direction) : to_frame_.vector(direction));
  // Integers are as long as rounding left them. Where the turn leads to integers again, they are
  // not rounded a second time.
  if (const double most = largest_value(type); most > 0 && to == type) {
    const Vec3d as_long = turned * (length(direction) * most);
    bool whole = true;
    for (std::size_t c = 0; c < 3; ++c)
      whole = whole && std::abs(as_long[c] - std::round(as_long[c])) < kWhole;
    if (whole) {
      for (std::size_t c = 0; c < 3; ++c) push_component(type, as_long[c] / most, out);
      return;
    }
  }
  for (std::size_t c = 0; c < 3; ++c) push_component(to, turned[c], out);
}

void CornerCopier::copy(std::uint32_t vertex, std::vector<CornerStream>& streams) const {
  for (std::size_t k = 0; k < plan_.source.size(); ++k) {
    const std::size_t s = plan_.source[k];
    const AttributeType& type = source_.types[s];
    const std::byte* element = source_.data[s].data() + vertex * type.bytes();
    Bytes& out = streams[k].bytes;
    const AttributeType& to = plan_.types[k];
    if (to.name == "POSITION" && to.component_type == 5126) {
      const Vec3f p = to_float(to_frame_.point(to_double(source_.positions[vertex])));
      push_floats(out, &p.x, 3);
    } else if (is_direction(type)) {
      push_direction(
          type, to,
          {component(type, element, 0), component(type, element, 1), component(type, element, 2)},
          out);
      // A mirror turns the bitangent, cross(normal, tangent) * w, around.
      if (type.components == 4) {
        const double w = component(type, element, 3);
        push_component(to, mirrored_ ? -w : w, out);
      }
    } else {
      out.insert(out.end(), element, element + type.bytes());
    }
  }
}

void CornerCopier::mix(const std::array<std::uint32_t, 3>& vertices,
                       const std::array<double, 3>& weights,
                       std::vector<CornerStream>& streams) const {
  for (std::size_t i = 0; i < 3; ++i)
    if (weights[i] == 1) return copy(vertices[i], streams);
  for (std::size_t k = 0; k < plan_.source.size(); ++k) {
    const std::size_t s = plan_.source[k];
    const AttributeType& type = source_.types[s];
    const AttributeType& to = plan_.types[k];
    Bytes& out = streams[k].bytes;
    if (type.name == "POSITION") {
      Vec3d p;
      for (std::size_t i = 0; i < 3; ++i)
        p += to_double(source_.positions[vertices[i]]) * weights[i];
      const Vec3f placed = to_float(to_frame_.point(p));
      push_floats(out, &placed.x, 3);
      continue;
    }
    const auto mixed = [&](std::size_t c) {
      double value = 0;
      for (std::size_t i = 0; i < 3; ++i)
        value +=
            weights[i] * component(type, source_.data[s].data() + vertices[i] * type.bytes(), c);
      return value;
    };
    if (is_number_of_something(type)) {
      const auto nearest = std::max_element(weights.begin(), weights.end()) - weights.begin();
      const std::byte* element =
          source_.data[s].data() + vertices[static_cast<std::size_t>(nearest)] * type.bytes();
      out.insert(out.end(), element, element + type.bytes());
      continue;
    }
    if (is_direction(type)) {
      push_direction(type, to, {mixed(0), mixed(1), mixed(2)}, out);
      if (type.components == 4) {
        const double w = mixed(3) < 0 ? -1 : 1;
        push_component(to, mirrored_ ? -w : w, out);
      }
      continue;
    }
    for (std::size_t c = 0; c < static_cast<std::size_t>(type.components); ++c)
      push_component(type, mixed(c), out);
  }
}

}  // namespace lightbatch::scene_out
