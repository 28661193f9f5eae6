#include "core/scene_out/corners.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace lightbatch::scene_out {
namespace {

/// Component i of an element, normalised integers as glTF 3.6.2.2 maps them.
double component(const AttributeType& type, const std::byte* element, std::size_t i) {
  const std::byte* at = element + i * type.component_bytes();
  switch (type.component_type) {
    case 5120: {
      std::int8_t v;
      std::memcpy(&v, at, 1);
      return std::max(v / 127.0, -1.0);
    }
    case 5122: {
      std::int16_t v;
      std::memcpy(&v, at, 2);
      return std::max(v / 32767.0, -1.0);
    }
    default: {
      float v;
      std::memcpy(&v, at, 4);
      return static_cast<double>(v);
    }
  }
}

void push_component(const AttributeType& type, double value, Bytes& bytes) {
  if (type.component_type == 5120) {
    const auto v = static_cast<std::int8_t>(std::lround(std::clamp(value, -1.0, 1.0) * 127));
    bytes.push_back(static_cast<std::byte>(v));
  } else if (type.component_type == 5122) {
    const auto v = static_cast<std::int16_t>(std::lround(std::clamp(value, -1.0, 1.0) * 32767));
    std::byte raw[2];
    std::memcpy(raw, &v, 2);
    bytes.insert(bytes.end(), raw, raw + 2);
  } else {
    const auto v = static_cast<float>(value);
    push_floats(bytes, &v, 1);
  }
}

bool is_direction(const AttributeType& type) {
  return (type.name == "NORMAL" || type.name == "TANGENT") && type.components >= 3 &&
         (type.component_type == 5126 || type.component_type == 5120 ||
          type.component_type == 5122);
}

}  // namespace

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

CornerCopier::CornerCopier(const CornerPlan& plan, const SourcePrimitive& source,
                           const scene::Object& object, const Vec3d& frame)
    : plan_(plan), source_(source), to_frame_(object.to_world), mirrored_(object.mirrored) {
  to_frame_.t = object.to_world.t - frame;
}

void CornerCopier::copy(std::uint32_t vertex, std::vector<CornerStream>& streams) const {
  for (std::size_t k = 0; k < plan_.source.size(); ++k) {
    const std::size_t s = plan_.source[k];
    const AttributeType& type = source_.types[s];
    const std::byte* element = source_.data[s].data() + vertex * type.bytes();
    Bytes& out = streams[k].bytes;
    if (type.name == "POSITION") {
      const Vec3f p = to_float(to_frame_.point(to_double(source_.positions[vertex])));
      push_floats(out, &p.x, 3);
    } else if (is_direction(type)) {
      const Vec3d in{component(type, element, 0), component(type, element, 1),
                     component(type, element, 2)};
      const bool normal = type.name == "NORMAL";
      const Vec3d turned = normalized(normal ? to_frame_.normal(in) : to_frame_.vector(in));
      for (std::size_t c = 0; c < 3; ++c) push_component(type, turned[c], out);
      // A mirror turns the bitangent, cross(normal, tangent) * w, around.
      if (type.components == 4) {
        const double w = component(type, element, 3);
        push_component(type, mirrored_ ? -w : w, out);
      }
    } else {
      out.insert(out.end(), element, element + type.bytes());
    }
  }
}

}  // namespace lightbatch::scene_out
