#include "core/scene_out/quantize.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/scene_out/corners.h"

namespace lightbatch::scene_out {
namespace {

constexpr int kShort = 5122, kUnsignedShort = 5123, kFloat = 5126;
constexpr double kLargest = std::numeric_limits<std::int16_t>::max();

/// The least power of two by which a short reaches so far; 0 for nothing.
double step_for(double reach) {
  return reach > 0 ? std::exp2(std::ceil(std::log2(reach / kLargest))) : 0;
}

double reach_of(const Vec3d& lower, const Vec3d& upper) {
  double reach = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    reach = std::max({reach, std::abs(lower[axis]), std::abs(upper[axis])});
  return reach;
}

/// World distance between positions that the file can hold next to each other; 0 for floats.
double step_of_source(const Json& root, const scene::Object& object) {
  const Json& primitive = root.at("meshes").at(object.mesh).at("primitives").at(object.primitive);
  for (const AttributeType& type : attribute_types(root, primitive)) {
    if (type.name != "POSITION" || type.component_type == kFloat) continue;
    const bool is_signed = type.component_type == 5120 || type.component_type == kShort;
    const double bits = 8 * static_cast<double>(type.component_bytes()) - (is_signed ? 1 : 0);
    const double unit = type.normalized ? 1 / (std::exp2(bits) - 1) : 1;
    const Affine& m = object.to_world;
    return unit * std::min({length(m.x), length(m.y), length(m.z)});
  }
  return 0;
}

/// Steps scale what is measured in the coordinates of the mesh.
bool draws_thick(const Writer& w, std::uint32_t object) {
  const scene::Object& o = w.scene.objects[object];
  const Json& root = w.document.json;
  return is_thick(root, root.at("meshes").at(o.mesh).at("primitives").at(o.primitive));
}

/// Rewrites one stream as integers; every row is `convert`ed from floats.
template <typename Convert>
void convert_stream(AttributeType& type, Bytes& data, int component_type, bool normalized,
                    const Convert& convert) {
  const auto components = static_cast<std::size_t>(type.components);
  AttributeType to = type;
  to.component_type = component_type;
  to.normalized = normalized;
  Bytes out;
  out.reserve(data.size() / type.bytes() * to.bytes());
  std::vector<float> row(components);
  for (std::size_t at = 0; at < data.size(); at += type.bytes()) {
    std::memcpy(row.data(), data.data() + at, type.bytes());
    convert(row);
    for (const float value : row) push_component(to, static_cast<double>(value), out);
  }
  type = std::move(to);
  data = std::move(out);
}

bool within_one(const Bytes& data) {
  for (std::size_t at = 0; at < data.size(); at += sizeof(float)) {
    float value = 0;
    std::memcpy(&value, data.data() + at, sizeof value);
    if (!(value >= 0 && value <= 1)) return false;
  }
  return true;
}

/// glTF wants directions as long as 1; those without any become x, as floats do.
void make_unit(std::vector<float>& row) {
  const Vec3d unit = normalized(to_double(Vec3f{row[0], row[1], row[2]}));
  const Vec3f v = unit == Vec3d{} ? Vec3f{1, 0, 0} : to_float(unit);
  row[0] = v.x;
  row[1] = v.y;
  row[2] = v.z;
}

double quantize_positions(AttributeType& type, Bytes& data, const Vec3d& origin, double step) {
  double farthest = 0;
  convert_stream(type, data, kShort, false, [&](std::vector<float>& row) {
    double squared = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double place = (static_cast<double>(row[c]) - origin[c]) / step;
      // Halves go up, whatever they are counted from.
      const double whole = std::clamp(std::floor(place + 0.5), -kLargest, kLargest);
      squared += (place - whole) * (place - whole);
      row[c] = static_cast<float>(whole);
    }
    farthest = std::max(farthest, squared);
  });
  return std::sqrt(farthest) * step;
}

}  // namespace

Vec3d frame_of(const scene::Scene& scene, const Aabb& box) {
  Vec3d centre = scene.origin + to_double(box.centre());
  constexpr double kSteps = 1024;  // along the scene, about
  const double unit =
      std::exp2(std::floor(std::log2(static_cast<double>(scene.box.diagonal()) / kSteps)));
  if (unit > 0)
    for (std::size_t axis = 0; axis < 3; ++axis)
      centre[axis] = std::round(centre[axis] / unit) * unit;
  return to_double(to_float(centre));
}

Quantizer::Quantizer(const Writer& writer, const batches::BatchPlan& plan) : w_(writer) {
  if (w_.options.quantization == Quantization::kOff) return;
  double reach = 0;
  for (const batches::Batch& batch : plan.batches) {
    const Vec3d shift = w_.scene.origin - frame_of(w_.scene, batch.box);
    reach = std::max(
        reach, reach_of(shift + to_double(batch.box.lower), shift + to_double(batch.box.upper)));
  }
  step_ = step_for(reach);
}

double Quantizer::step_of(const batches::Batch& batch) const {
  if (!(step_ > 0)) return 0;
  for (const batches::Group& group : batch.groups)
    for (const batches::Piece& piece : group.pieces) {
      if (draws_thick(w_, piece.object)) return 0;
      if (w_.options.quantization == Quantization::kAll) continue;
      // As the input was: no vertex moves by more than a step of the grid that it came on.
      if (step_of_source(w_.document.json, w_.scene.objects[piece.object]) < step_ / 2) return 0;
    }
  return step_;
}

Quantizer::PartGrid Quantizer::part_grid(const batches::InstancePart& part) const {
  if (w_.options.quantization != Quantization::kAll) return {};
  const Json& root = w_.document.json;
  // Of all primitives: parts of one mesh share a grid.
  Vec3d lower, upper;
  bool first = true;
  for (const Json& primitive : root.at("meshes").at(part.mesh).at("primitives")) {
    const Json& accessor =
        root.at("accessors").at(index_at(primitive.at("attributes"), "POSITION"));
    const Json *low = member(accessor, "min"), *high = member(accessor, "max");
    if (accessor.at("componentType") != kFloat || low == nullptr || high == nullptr) return {};
    for (std::size_t c = 0; c < 3; ++c) {
      const double l = low->at(c).get<double>(), h = high->at(c).get<double>();
      lower[c] = first ? l : std::min(lower[c], l);
      upper[c] = first ? h : std::max(upper[c], h);
    }
    first = false;
  }
  for (const batches::Piece& piece : part.pieces)
    if (draws_thick(w_, piece.object)) return {};
  const Vec3d centre = to_double(to_float((lower + upper) * 0.5));
  return {centre, step_for(reach_of(lower - centre, upper - centre))};
}

void quantize(Writer& w, MeshData& mesh, const Vec3d& origin, double step, double scale) {
  const bool all = w.options.quantization == Quantization::kAll;
  for (std::size_t s = 0; s < mesh.types.size(); ++s) {
    AttributeType& type = mesh.types[s];
    Bytes& data = mesh.data[s];
    if (type.component_type != kFloat) continue;
    if (type.name == "POSITION") {
      const double moved = scale * quantize_positions(type, data, origin, step);
      w.facts.position_error = std::max(w.facts.position_error, moved);
    } else if (!all && type.name != "TEXCOORD_1" && type.name != "COLOR_0") {
      continue;
    } else if (type.name == "NORMAL" || type.name == "TANGENT") {
      convert_stream(type, data, kShort, true, make_unit);
    } else if ((type.name.starts_with("TEXCOORD_") || type.name.starts_with("COLOR_")) &&
               within_one(data)) {
      convert_stream(type, data, kUnsignedShort, true, [](std::vector<float>&) {});
    }
  }
  ++w.facts.quantized;
  declare_extension(w.root, "extensionsUsed", "KHR_mesh_quantization");
  declare_extension(w.root, "extensionsRequired", "KHR_mesh_quantization");
}

}  // namespace lightbatch::scene_out
