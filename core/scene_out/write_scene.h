#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/atlas/layout.h"
#include "core/base/bytes.h"
#include "core/base/status.h"
#include "core/batches/plan.h"
#include "core/gltf/document.h"
#include "core/math/rgb.h"
#include "core/scene/scene.h"

namespace lightbatch::scene_out {

/// Pages as they go into the file: 8-bit linear PNG; lux = value / 255 * intensity.
struct LightmapImages {
  std::vector<Bytes> png;
  std::vector<float> intensity;
};

/// Members of the scene's extras.lightbatch that relit_scene() finds its way by: the images of the
/// pages, in order; by number of each emitting material as read, its clones on pages.
constexpr const char* kPageImages = "page_images";
constexpr const char* kEmitters = "emitters";

/// How light travels in the file.
enum class Carrier {
  kLightmap,  // MOZ_lightmap on lit materials, TEXCOORD_1
  kPortable,  // KHR_materials_unlit and COLOR_0: any viewer
};

/// Irradiance (lux) or emitted luminance (nits) at barycentric (u, v) of a scene triangle.
using LightAt = std::function<Rgb(std::uint32_t triangle, float u, float v)>;

enum class Compression { kPlain, kMeshopt, kDraco };

/// What of batches and instance cells is written as 16-bit integers (KHR_mesh_quantization).
enum class Quantization {
  kAsInput,  // positions that were integers, where none moves by more than a step of its own
  kOff,
  kAll,  // positions, directions; texture coordinates and colours within [0, 1]
};

struct WriteOptions {
  Carrier carrier = Carrier::kLightmap;
  Compression compression = Compression::kPlain;
  /// Draco rounds by itself: with it, nothing is rounded before.
  Quantization quantization = Quantization::kAsInput;
  bool remove_lights = true;  // lights that the scene holds (all baked) go into extras
  gltf::Json extras;          // object: further members of the scene's extras.lightbatch; or null
  /// Portable: which triangles are lit (empty: all), their light, and the scale from luminance
  /// (nits) to colour; exposure 0: chosen so that 99 % of the lit surface stays below 1.
  std::vector<std::uint8_t> lit;
  LightAt irradiance;
  LightAt emission;  // times coverage; null: none
  double exposure = 0;
  /// Portable: an edge is split while the light in its middle differs from the mean of its ends by
  /// more than this share of full scale, at most `subdivisions` times.
  double colour_step = 0.03;
  int subdivisions = 4;
};

/// What came of the options.
struct WriteFacts {
  bool compressed = false;      // the asked compression found something that it can hold
  std::uint32_t quantized = 0;  // primitives whose positions were rounded to 16 bits
  double position_error = 0;    // metres, the farthest that this moved a vertex
};

/// What the file says of each object beyond the scene: which may share a primitive, and which must
/// stay in their nodes. Input of batches::plan. `layout`: the atlas when lightmaps are written.
std::vector<batches::ObjectTraits> describe_objects(const gltf::Document& document,
                                                    const scene::Scene& scene,
                                                    const atlas::Layout* layout);

/// Objects that a variant of their material shows what is behind.
std::vector<bool> opening_objects(const gltf::Document& document, const scene::Scene& scene);

/// The reorganised scene as one .glb. Portable: the plan was made with page 0 for lit triangles and
/// kNone for others; layout and images are null. plan: the batches, or null to keep every object in
/// its node. layout and images: lightmaps, or both null. Everything that is not understood is kept.
/// Deterministic bytes. INPUT_OVER_BUDGET beyond what a .glb can hold.
Result<Bytes> write_scene(const gltf::Document& document, const scene::Scene& scene,
                          const batches::BatchPlan* plan, const atlas::Layout* layout,
                          const LightmapImages* images, const WriteOptions& options,
                          WriteFacts* facts = nullptr);

}  // namespace lightbatch::scene_out
