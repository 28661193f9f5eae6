#include "core/gltf/draco_stream.h"

#include <draco/compression/decode.h>

#include <cstring>
#include <exception>
#include <memory>

#include "core/gltf/draco_header.h"
#include "core/gltf/draco_types.h"

namespace lightbatch::gltf {
namespace {

/// Faces a stream of n bytes may hold: kFreeFaces + n * kFacesPerByte. Scanned and modelled meshes
/// take 1 to 4 bytes a face; flat regular grids whose steps fall on the quantisation were measured
/// at up to 898 faces a byte (1023 x 1023 cells). Decoding takes 72 bytes of memory a face.
constexpr std::uint64_t kFreeFaces = 1 << 16;
constexpr std::uint64_t kFacesPerByte = 1024;

template <typename T>
bool convert(const draco::PointAttribute& from, const DracoAttribute& to) {
  const auto components = static_cast<std::int8_t>(to.layout.components);
  T values[16] = {};
  for (std::uint64_t i = 0; i < to.layout.count; ++i) {
    const auto value = from.mapped_index(draco::PointIndex(static_cast<std::uint32_t>(i)));
    if (!from.ConvertValue<T>(value, components, values)) return false;
    std::memcpy(to.out + i * to.stride, values, sizeof(T) * to.layout.components);
  }
  return true;
}

bool copy_attribute(const draco::PointAttribute& from, const DracoAttribute& to) {
  if (from.data_type() == draco_type_of(to.layout.component_type)) {
    const std::size_t bytes = to.layout.element_bytes;
    for (std::uint64_t i = 0; i < to.layout.count; ++i) {
      const auto value = from.mapped_index(draco::PointIndex(static_cast<std::uint32_t>(i)));
      if (value.value() >= from.size()) return false;
      std::memcpy(to.out + i * to.stride, from.GetAddress(value), bytes);
    }
    return true;
  }
  for (std::uint64_t i = 0; i < to.layout.count; ++i) {
    const auto value = from.mapped_index(draco::PointIndex(static_cast<std::uint32_t>(i)));
    if (value.value() >= from.size()) return false;
  }
  switch (to.layout.component_type) {
    case 5120:
      return convert<std::int8_t>(from, to);
    case 5121:
      return convert<std::uint8_t>(from, to);
    case 5122:
      return convert<std::int16_t>(from, to);
    case 5123:
      return convert<std::uint16_t>(from, to);
    case 5125:
      return convert<std::uint32_t>(from, to);
    default:
      return convert<float>(from, to);
  }
}

template <typename T>
bool copy_faces(const draco::Mesh& mesh, std::byte* out) {
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(f));
    T corners[3];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t point = face[i].value();
      if (point >= mesh.num_points() || point > std::numeric_limits<T>::max()) return false;
      corners[i] = static_cast<T>(point);
    }
    std::memcpy(out + std::size_t{f} * sizeof(corners), corners, sizeof(corners));
  }
  return true;
}

Status decode(std::span<const std::byte> stream, const std::string& place,
              std::span<const DracoAttribute> attributes, const DracoIndices& indices) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    return malformed(place, "broken Draco data: " + decoded.status().error_msg_string());
  }
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  if (mesh == nullptr) return malformed(place, "broken Draco data");
  if (std::uint64_t{mesh->num_faces()} * 3 != indices.count) {
    return malformed(place, "broken Draco data: the faces do not decode to the number promised");
  }
  for (const DracoAttribute& attribute : attributes) {
    const draco::PointAttribute* from = mesh->GetAttributeByUniqueId(attribute.unique_id);
    if (from == nullptr) {
      return malformed(place, "the Draco stream has no attribute " +
                                  std::to_string(attribute.unique_id) + " for " + attribute.name);
    }
    if (mesh->num_points() != attribute.layout.count) {
      return malformed(place, "the Draco stream holds " + std::to_string(mesh->num_points()) +
                                  " points, the accessor of " + attribute.name + " " +
                                  std::to_string(attribute.layout.count));
    }
    if (static_cast<std::uint32_t>(from->num_components()) != attribute.layout.components) {
      return malformed(place, "the Draco attribute for " + attribute.name +
                                  " has another number of components than its accessor");
    }
    if (!copy_attribute(*from, attribute)) {
      return malformed(place, "broken Draco data: " + attribute.name + " cannot be converted");
    }
  }
  const bool copied = indices.index_bytes == 1   ? copy_faces<std::uint8_t>(*mesh, indices.out)
                      : indices.index_bytes == 2 ? copy_faces<std::uint16_t>(*mesh, indices.out)
                                                 : copy_faces<std::uint32_t>(*mesh, indices.out);
  if (!copied) return malformed(place, "the Draco indices do not fit their accessor");
  return {};
}

}  // namespace

Status check_draco_counts(std::span<const std::byte> stream, const std::string& place,
                          std::uint64_t points, std::uint64_t index_count) {
  LB_ASSIGN_OR_RETURN(const DracoCounts counts, read_draco_counts(stream, place));
  if (std::uint64_t{counts.faces} * 3 != index_count) {
    return malformed(place, "the Draco stream holds " + std::to_string(counts.faces) +
                                " faces, the accessor of the indices " +
                                std::to_string(index_count) + " indices");
  }
  if (counts.faces > kFreeFaces + stream.size() * kFacesPerByte) {
    return malformed(place, std::to_string(stream.size()) + " bytes of Draco data cannot hold " +
                                std::to_string(counts.faces) + " faces");
  }
  // Without seams every vertex is one point; with seams each corner may be one.
  const bool agree = counts.edgebreaker ? counts.vertices <= points && points <= index_count
                                        : counts.vertices == points;
  if (!agree || points > kFreeFaces + stream.size() * kFacesPerByte) {
    return malformed(place, "the Draco stream holds " + std::to_string(counts.vertices) +
                                " vertices, its accessors " + std::to_string(points));
  }
  return {};
}

Status decode_draco_mesh(std::span<const std::byte> stream, const std::string& place,
                         std::span<const DracoAttribute> attributes, const DracoIndices& indices) {
  try {
    return decode(stream, place, attributes, indices);
  } catch (const std::bad_alloc&) {
    return over_budget(place, "decoding the Draco data takes too much memory");
  } catch (const std::exception& error) {
    return malformed(place, std::string("broken Draco data: ") + error.what());
  }
}

}  // namespace lightbatch::gltf
