#pragma once

#include <fstream>  // tinygltf's writer needs it, file access or not

/// tinygltf compiled into this room and nowhere else: no image library, no file access, and a
/// namespace of its own, because libdraco carries strong symbols of an older tinygltf.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#define tinygltf lightbatch_tinygltf
#include <tiny_gltf.h>
#undef tinygltf

namespace lightbatch::scene_in {
namespace tinygltf = ::lightbatch_tinygltf;
}  // namespace lightbatch::scene_in
