#include "core/gltf/attribute_formats.h"

#include <array>

namespace lightbatch::gltf {
namespace {

/// Component types as bits.
enum Types : unsigned {
  kFloat = 1,
  kUnsignedNormalized = 2,  // 8 or 16 bits
  kSignedNormalized = 4,
  kUnsignedPlain = 8,
  kSignedPlain = 16,
  kAnySmall = kUnsignedNormalized | kSignedNormalized | kUnsignedPlain | kSignedPlain,
};

unsigned type_of(const Layout& layout) {
  switch (layout.component_type) {
    case 5120:
    case 5122:
      return layout.normalized ? kSignedNormalized : kSignedPlain;
    case 5121:
    case 5123:
      return layout.normalized ? kUnsignedNormalized : kUnsignedPlain;
    case 5126:
      return kFloat;
    default:
      return 0;  // 32-bit integers are for indices alone
  }
}

struct Semantic {
  std::string_view name;  // without its set number
  bool numbered;
  std::uint32_t least_components;
  std::uint32_t most_components;
  unsigned core;
  unsigned quantized;  // further ones with KHR_mesh_quantization
};
constexpr std::array<Semantic, 7> kSemantics = {{
    {"POSITION", false, 3, 3, kFloat, kAnySmall},
    {"NORMAL", false, 3, 3, kFloat, kSignedNormalized},
    {"TANGENT", false, 4, 4, kFloat, kSignedNormalized},
    {"TEXCOORD", true, 2, 2, kFloat | kUnsignedNormalized, kAnySmall},
    {"COLOR", true, 3, 4, kFloat | kUnsignedNormalized, 0},
    {"JOINTS", true, 4, 4, kUnsignedPlain, 0},
    {"WEIGHTS", true, 4, 4, kFloat | kUnsignedNormalized, 0},
}};
/// Differences of normalised colours and coordinates have signs.
constexpr unsigned kTargetExtra = kSignedNormalized;

bool is_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

const Semantic* semantic_of(std::string_view name) {
  for (const Semantic& semantic : kSemantics) {
    if (!semantic.numbered) {
      if (name == semantic.name) return &semantic;
      continue;
    }
    if (name.size() > semantic.name.size() && name.starts_with(semantic.name) &&
        name[semantic.name.size()] == '_' && is_number(name.substr(semantic.name.size() + 1))) {
      return &semantic;
    }
  }
  return nullptr;
}

}  // namespace

AttributeFault check_attribute_format(std::string_view name, const Layout& layout, bool target,
                                      bool quantized) {
  const Semantic* semantic = semantic_of(name);
  if (semantic == nullptr) {
    // A leading underscore marks attributes of an application.
    return name.starts_with('_') ? AttributeFault::kNone : AttributeFault::kUnknownName;
  }
  const bool target_tangent = target && name == "TANGENT";
  const std::uint32_t least = target_tangent ? 3 : semantic->least_components;
  const std::uint32_t most = target_tangent ? 3 : semantic->most_components;
  if (layout.rows != layout.components || layout.components < least || layout.components > most) {
    return AttributeFault::kWrongType;
  }
  unsigned allowed = semantic->core;
  if (target && semantic->numbered) allowed |= kTargetExtra;
  const unsigned type = type_of(layout);
  if ((type & allowed) != 0) return AttributeFault::kNone;
  if ((type & semantic->quantized) == 0) return AttributeFault::kWrongComponents;
  return quantized ? AttributeFault::kNone : AttributeFault::kNeedsQuantization;
}

}  // namespace lightbatch::gltf
