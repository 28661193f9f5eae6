/// The object tables of the Khronos glTF 2.0 specification (Appendix "Properties Reference") and of
/// the extensions we understand, in the same order.
#include <array>

#include "core/gltf/schema.h"

namespace lightbatch::gltf {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kLargest = std::numeric_limits<double>::max();
constexpr double kLargestInteger = 9007199254740991;  // 2^53 - 1: exact as a JSON number

constexpr Property index(const char* name, const char* list) {
  return {.name = name, .kind = Kind::kIndex, .list = list};
}
constexpr Property indices(const char* name, const char* list, std::size_t least = 1) {
  return {.name = name, .kind = Kind::kIndices, .list = list, .least = least};
}
constexpr Property index_map(const char* name, const char* list) {
  return {.name = name, .kind = Kind::kIndexMap, .list = list};
}
constexpr Property index_maps(const char* name, const char* list) {
  return {.name = name, .kind = Kind::kIndexMaps, .list = list};
}
constexpr Property count(const char* name, double low = 0, double high = kLargestInteger) {
  return {.name = name, .kind = Kind::kUnsigned, .low = low, .high = high, .range_is_error = true};
}
/// A count whose range is only worth a warning.
constexpr Property loose_count(const char* name, double low, double high = kLargestInteger) {
  return {.name = name, .kind = Kind::kUnsigned, .low = low, .high = high};
}
constexpr Property choice(const char* name, std::span<const std::uint32_t> choices,
                          bool range_is_error = true) {
  return {
      .name = name, .kind = Kind::kChoice, .choices = choices, .range_is_error = range_is_error};
}
constexpr Property number(const char* name, double low = -kLargest, double high = kLargest) {
  return {.name = name, .kind = Kind::kNumber, .low = low, .high = high};
}
constexpr Property numbers(const char* name, std::size_t length, double low = -kLargest,
                           double high = kLargest) {
  return {.name = name,
          .kind = Kind::kNumbers,
          .low = low,
          .high = high,
          .least = length,
          .most = length};
}
constexpr Property some_numbers(const char* name, std::size_t most) {
  return {.name = name, .kind = Kind::kNumbers, .most = most};
}
constexpr Property boolean(const char* name) { return {.name = name, .kind = Kind::kBoolean}; }
constexpr Property text(const char* name) { return {.name = name, .kind = Kind::kText}; }
constexpr Property texts(const char* name) { return {.name = name, .kind = Kind::kTexts}; }
constexpr Property object(const char* name, const ObjectSchema& schema) {
  return {.name = name, .kind = Kind::kObject, .schema = &schema};
}
constexpr Property objects(const char* name, const ObjectSchema& schema) {
  return {.name = name, .kind = Kind::kObjects, .schema = &schema};
}
constexpr Property required(Property property) {
  property.required = true;
  return property;
}

constexpr std::uint32_t kComponentTypes[] = {5120, 5121, 5122, 5123, 5125, 5126};
constexpr std::uint32_t kIndexTypes[] = {5121, 5123, 5125};
constexpr std::uint32_t kTargets[] = {34962, 34963};
constexpr std::uint32_t kModes[] = {0, 1, 2, 3, 4, 5, 6};
constexpr std::uint32_t kMagFilters[] = {9728, 9729};
constexpr std::uint32_t kMinFilters[] = {9728, 9729, 9984, 9985, 9986, 9987};
constexpr std::uint32_t kWraps[] = {33071, 33648, 10497};

constexpr Property kSparseIndices[] = {required(index("bufferView", "bufferViews")),
                                       count("byteOffset"),
                                       required(choice("componentType", kIndexTypes))};
constexpr ObjectSchema kSparseIndicesSchema{"sparse indices", kSparseIndices};
constexpr Property kSparseValues[] = {required(index("bufferView", "bufferViews")),
                                      count("byteOffset")};
constexpr ObjectSchema kSparseValuesSchema{"sparse values", kSparseValues};
constexpr Property kSparse[] = {required(count("count", 1)),
                                required(object("indices", kSparseIndicesSchema)),
                                required(object("values", kSparseValuesSchema))};
constexpr ObjectSchema kSparseSchema{"sparse", kSparse};
constexpr Property kAccessor[] = {index("bufferView", "bufferViews"),
                                  count("byteOffset"),
                                  required(choice("componentType", kComponentTypes)),
                                  boolean("normalized"),
                                  required(count("count", 1)),
                                  required(text("type")),
                                  some_numbers("max", 16),
                                  some_numbers("min", 16),
                                  object("sparse", kSparseSchema),
                                  text("name")};
constexpr ObjectSchema kAccessorSchema{"accessor", kAccessor};

constexpr Property kChannelTarget[] = {index("node", "nodes"), required(text("path"))};
constexpr ObjectSchema kChannelTargetSchema{"animation channel target", kChannelTarget};
constexpr Property kChannel[] = {required(count("sampler")),
                                 required(object("target", kChannelTargetSchema))};
constexpr ObjectSchema kChannelSchema{"animation channel", kChannel};
constexpr Property kAnimationSampler[] = {required(index("input", "accessors")),
                                          text("interpolation"),
                                          required(index("output", "accessors"))};
constexpr ObjectSchema kAnimationSamplerSchema{"animation sampler", kAnimationSampler};
constexpr Property kAnimation[] = {required(objects("channels", kChannelSchema)),
                                   required(objects("samplers", kAnimationSamplerSchema)),
                                   text("name")};
constexpr ObjectSchema kAnimationSchema{"animation", kAnimation};

constexpr Property kAsset[] = {required(text("version")), text("minVersion"), text("generator"),
                               text("copyright")};
constexpr ObjectSchema kAssetSchema{"asset", kAsset};

constexpr Property kBuffer[] = {text("uri"), required(loose_count("byteLength", 1)), text("name")};
constexpr ObjectSchema kBufferSchema{"buffer", kBuffer};
constexpr Property kBufferView[] = {
    required(index("buffer", "buffers")),   count("byteOffset"),
    required(loose_count("byteLength", 1)), loose_count("byteStride", 4, 252),
    choice("target", kTargets, false),      text("name")};
constexpr ObjectSchema kBufferViewSchema{"bufferView", kBufferView};

constexpr Property kPerspective[] = {number("aspectRatio", 0), required(number("yfov", 0)),
                                     number("zfar", 0), required(number("znear", 0))};
constexpr ObjectSchema kPerspectiveSchema{"perspective", kPerspective};
constexpr Property kOrthographic[] = {required(number("xmag", 0)), required(number("ymag", 0)),
                                      required(number("zfar", 0)), required(number("znear", 0))};
constexpr ObjectSchema kOrthographicSchema{"orthographic", kOrthographic};
constexpr Property kCamera[] = {required(text("type")), object("perspective", kPerspectiveSchema),
                                object("orthographic", kOrthographicSchema), text("name")};
constexpr ObjectSchema kCameraSchema{"camera", kCamera};

constexpr Property kImage[] = {text("uri"), text("mimeType"), index("bufferView", "bufferViews"),
                               text("name")};
constexpr ObjectSchema kImageSchema{"image", kImage};

constexpr Property kTextureInfo[] = {required(index("index", "textures")), count("texCoord")};
constexpr Property kNormalTexture[] = {required(index("index", "textures")), count("texCoord"),
                                       number("scale")};
constexpr Property kOcclusionTexture[] = {required(index("index", "textures")), count("texCoord"),
                                          number("strength", 0, 1)};
constexpr ObjectSchema kNormalTextureSchema{"textureInfo", kNormalTexture};
constexpr ObjectSchema kOcclusionTextureSchema{"textureInfo", kOcclusionTexture};
constexpr Property kPbr[] = {numbers("baseColorFactor", 4, 0, 1),
                             object("baseColorTexture", kTextureInfoSchema),
                             number("metallicFactor", 0, 1), number("roughnessFactor", 0, 1),
                             object("metallicRoughnessTexture", kTextureInfoSchema)};
constexpr ObjectSchema kPbrSchema{"pbrMetallicRoughness", kPbr};
constexpr Property kMaterial[] = {object("pbrMetallicRoughness", kPbrSchema),
                                  object("normalTexture", kNormalTextureSchema),
                                  object("occlusionTexture", kOcclusionTextureSchema),
                                  object("emissiveTexture", kTextureInfoSchema),
                                  numbers("emissiveFactor", 3, 0, 1),
                                  text("alphaMode"),
                                  number("alphaCutoff", 0),
                                  boolean("doubleSided"),
                                  text("name")};
constexpr ObjectSchema kMaterialSchema{"material", kMaterial};

constexpr Property kPrimitive[] = {required(index_map("attributes", "accessors")),
                                   index("indices", "accessors"), index("material", "materials"),
                                   choice("mode", kModes), index_maps("targets", "accessors")};
constexpr ObjectSchema kPrimitiveSchema{"primitive", kPrimitive};
constexpr Property kMesh[] = {required(objects("primitives", kPrimitiveSchema)),
                              some_numbers("weights", 1 << 20), text("name")};
constexpr ObjectSchema kMeshSchema{"mesh", kMesh};

constexpr Property kNode[] = {index("camera", "cameras"),
                              indices("children", "nodes", 0),
                              index("skin", "skins"),
                              numbers("matrix", 16),
                              index("mesh", "meshes"),
                              numbers("rotation", 4),
                              numbers("scale", 3),
                              numbers("translation", 3),
                              some_numbers("weights", 1 << 20),
                              text("name")};
constexpr ObjectSchema kNodeSchema{"node", kNode};

constexpr Property kSampler[] = {choice("magFilter", kMagFilters), choice("minFilter", kMinFilters),
                                 choice("wrapS", kWraps), choice("wrapT", kWraps), text("name")};
constexpr ObjectSchema kSamplerSchema{"sampler", kSampler};
constexpr Property kScene[] = {indices("nodes", "nodes"), text("name")};
constexpr ObjectSchema kSceneSchema{"scene", kScene};
constexpr Property kSkin[] = {index("inverseBindMatrices", "accessors"), index("skeleton", "nodes"),
                              required(indices("joints", "nodes")), text("name")};
constexpr ObjectSchema kSkinSchema{"skin", kSkin};
constexpr Property kTexture[] = {index("sampler", "samplers"), index("source", "images"),
                                 text("name")};
constexpr ObjectSchema kTextureSchema{"texture", kTexture};

constexpr Property kRoot[] = {objects("accessors", kAccessorSchema),
                              objects("animations", kAnimationSchema),
                              required(object("asset", kAssetSchema)),
                              objects("buffers", kBufferSchema),
                              objects("bufferViews", kBufferViewSchema),
                              objects("cameras", kCameraSchema),
                              texts("extensionsUsed"),
                              texts("extensionsRequired"),
                              objects("images", kImageSchema),
                              objects("materials", kMaterialSchema),
                              objects("meshes", kMeshSchema),
                              objects("nodes", kNodeSchema),
                              objects("samplers", kSamplerSchema),
                              index("scene", "scenes"),
                              objects("scenes", kSceneSchema),
                              objects("skins", kSkinSchema),
                              objects("textures", kTextureSchema)};

constexpr Property kSpot[] = {number("innerConeAngle", 0, kPi / 2),
                              number("outerConeAngle", 0, kPi / 2)};
constexpr ObjectSchema kSpotSchema{"spot", kSpot};
constexpr Property kLight[] = {numbers("color", 3, 0, 1),   number("intensity", 0),
                               required(text("type")),      number("range", 0),
                               object("spot", kSpotSchema), text("name")};
constexpr ObjectSchema kLightSchema{"light", kLight};
constexpr Property kLights[] = {required(objects("lights", kLightSchema))};
constexpr ObjectSchema kLightsSchema{"lights", kLights};
constexpr Property kNodeLight[] = {required(index("light", "lights"))};
constexpr ObjectSchema kNodeLightSchema{"node light", kNodeLight};

constexpr Property kTransform[] = {numbers("offset", 2), number("rotation"), numbers("scale", 2),
                                   count("texCoord")};
constexpr ObjectSchema kTransformSchema{"texture transform", kTransform};
constexpr Property kDraco[] = {required(index("bufferView", "bufferViews")),
                               required(index_map("attributes", nullptr))};
constexpr ObjectSchema kDracoSchema{"draco", kDraco};
constexpr Property kMeshopt[] = {required(index("buffer", "buffers")),
                                 count("byteOffset"),
                                 required(count("byteLength", 1)),
                                 required(count("byteStride", 1, 256)),
                                 required(count("count", 1)),
                                 required(text("mode")),
                                 text("filter")};
constexpr ObjectSchema kMeshoptSchema{"meshopt view", kMeshopt};
constexpr Property kFallback[] = {boolean("fallback")};
constexpr ObjectSchema kFallbackSchema{"meshopt buffer", kFallback};
constexpr Property kInstancing[] = {required(index_map("attributes", "accessors"))};
constexpr ObjectSchema kInstancingSchema{"instancing", kInstancing};
constexpr Property kStrength[] = {number("emissiveStrength", 0)};
constexpr ObjectSchema kStrengthSchema{"emissive strength", kStrength};
constexpr Property kTransmission[] = {number("transmissionFactor", 0, 1),
                                      object("transmissionTexture", kTextureInfoSchema)};
constexpr ObjectSchema kTransmissionSchema{"transmission", kTransmission};
constexpr Property kDiffuseTransmission[] = {
    number("diffuseTransmissionFactor", 0, 1),
    object("diffuseTransmissionTexture", kTextureInfoSchema),
    numbers("diffuseTransmissionColorFactor", 3, 0, 1),
    object("diffuseTransmissionColorTexture", kTextureInfoSchema)};
constexpr ObjectSchema kDiffuseTransmissionSchema{"diffuse transmission", kDiffuseTransmission};
constexpr Property kGlossiness[] = {
    numbers("diffuseFactor", 4, 0, 1), object("diffuseTexture", kTextureInfoSchema),
    numbers("specularFactor", 3, 0, 1), number("glossinessFactor", 0, 1),
    object("specularGlossinessTexture", kTextureInfoSchema)};
constexpr ObjectSchema kGlossinessSchema{"specular glossiness", kGlossiness};
constexpr Property kOtherSource[] = {index("source", "images")};
constexpr ObjectSchema kOtherSourceSchema{"texture source", kOtherSource};
constexpr Property kVariantName[] = {required(text("name"))};
constexpr ObjectSchema kVariantNameSchema{"variant", kVariantName};
constexpr Property kVariants[] = {required(objects("variants", kVariantNameSchema))};
constexpr ObjectSchema kVariantsSchema{"variants", kVariants};
constexpr Property kMapping[] = {required(index("material", "materials"))};
constexpr ObjectSchema kMappingSchema{"variant mapping", kMapping};
constexpr Property kMappings[] = {required(objects("mappings", kMappingSchema))};
constexpr ObjectSchema kMappingsSchema{"variant mappings", kMappings};

}  // namespace

const ObjectSchema kRootSchema{"root", kRoot};
const ObjectSchema kTextureInfoSchema{"textureInfo", kTextureInfo};

std::span<const ExtensionSchema> extension_schemas() {
  static const ExtensionSchema kSchemas[] = {
      {"KHR_lights_punctual", &kRootSchema, &kLightsSchema},
      {"KHR_lights_punctual", &kNodeSchema, &kNodeLightSchema},
      {"KHR_texture_transform", &kTextureInfoSchema, &kTransformSchema},
      {"KHR_draco_mesh_compression", &kPrimitiveSchema, &kDracoSchema},
      {"EXT_meshopt_compression", &kBufferViewSchema, &kMeshoptSchema},
      {"EXT_meshopt_compression", &kBufferSchema, &kFallbackSchema},
      {"KHR_mesh_quantization", nullptr, nullptr},
      {"EXT_mesh_gpu_instancing", &kNodeSchema, &kInstancingSchema},
      {"KHR_materials_emissive_strength", &kMaterialSchema, &kStrengthSchema},
      {"KHR_materials_unlit", &kMaterialSchema, nullptr},
      {"KHR_materials_transmission", &kMaterialSchema, &kTransmissionSchema},
      {"KHR_materials_diffuse_transmission", &kMaterialSchema, &kDiffuseTransmissionSchema},
      {"KHR_materials_pbrSpecularGlossiness", &kMaterialSchema, &kGlossinessSchema},
      {"EXT_texture_webp", &kTextureSchema, &kOtherSourceSchema},
      {"KHR_texture_basisu", &kTextureSchema, &kOtherSourceSchema},
      {"MSFT_texture_dds", &kTextureSchema, &kOtherSourceSchema},
      {"KHR_materials_variants", &kRootSchema, &kVariantsSchema},
      {"KHR_materials_variants", &kPrimitiveSchema, &kMappingsSchema},
  };
  return kSchemas;
}

}  // namespace lightbatch::gltf
