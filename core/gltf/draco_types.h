#pragma once

#include <draco/core/draco_types.h>

#include <cstdint>

namespace lightbatch::gltf {

/// Draco's name of a glTF componentType.
inline draco::DataType draco_type_of(std::uint32_t component_type) {
  switch (component_type) {
    case 5120:
      return draco::DT_INT8;
    case 5121:
      return draco::DT_UINT8;
    case 5122:
      return draco::DT_INT16;
    case 5123:
      return draco::DT_UINT16;
    case 5125:
      return draco::DT_UINT32;
    default:
      return draco::DT_FLOAT32;
  }
}

}  // namespace lightbatch::gltf
