/// The objects of the extensions we know, as their specifications in the Khronos registry give
/// them.
#include "core/gltf/schema.h"
#include "core/gltf/schema_terms.h"

namespace lightbatch::gltf {
namespace {

using namespace schema_terms;  // the words the tables are written in

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
constexpr Property kMapping[] = {required(index("material", "materials")),
                                 required(indices("variants", "variants")), text("name")};
constexpr ObjectSchema kMappingSchema{"variant mapping", kMapping};
constexpr Property kMappings[] = {required(objects("mappings", kMappingSchema))};
constexpr ObjectSchema kMappingsSchema{"variant mappings", kMappings};

constexpr Property kClearcoat[] = {number("clearcoatFactor", 0, 1),
                                   object("clearcoatTexture", kTextureInfoSchema),
                                   number("clearcoatRoughnessFactor", 0, 1),
                                   object("clearcoatRoughnessTexture", kTextureInfoSchema),
                                   object("clearcoatNormalTexture", kNormalTextureSchema)};
constexpr ObjectSchema kClearcoatSchema{"clearcoat", kClearcoat};
constexpr Property kIor[] = {number("ior", 0)};
constexpr ObjectSchema kIorSchema{"ior", kIor};
constexpr Property kSheen[] = {
    numbers("sheenColorFactor", 3, 0, 1), object("sheenColorTexture", kTextureInfoSchema),
    number("sheenRoughnessFactor", 0, 1), object("sheenRoughnessTexture", kTextureInfoSchema)};
constexpr ObjectSchema kSheenSchema{"sheen", kSheen};
constexpr Property kSpecular[] = {
    number("specularFactor", 0, 1), object("specularTexture", kTextureInfoSchema),
    numbers("specularColorFactor", 3, 0), object("specularColorTexture", kTextureInfoSchema)};
constexpr ObjectSchema kSpecularSchema{"specular", kSpecular};
constexpr Property kVolume[] = {
    number("thicknessFactor", 0), object("thicknessTexture", kTextureInfoSchema),
    number("attenuationDistance", 0), numbers("attenuationColor", 3, 0, 1)};
constexpr ObjectSchema kVolumeSchema{"volume", kVolume};
constexpr Property kIridescence[] = {number("iridescenceFactor", 0, 1),
                                     object("iridescenceTexture", kTextureInfoSchema),
                                     number("iridescenceIor", 1),
                                     number("iridescenceThicknessMinimum", 0),
                                     number("iridescenceThicknessMaximum", 0),
                                     object("iridescenceThicknessTexture", kTextureInfoSchema)};
constexpr ObjectSchema kIridescenceSchema{"iridescence", kIridescence};
constexpr Property kAnisotropy[] = {number("anisotropyStrength", 0, 1),
                                    number("anisotropyRotation"),
                                    object("anisotropyTexture", kTextureInfoSchema)};
constexpr ObjectSchema kAnisotropySchema{"anisotropy", kAnisotropy};
constexpr Property kDispersion[] = {number("dispersion", 0)};
constexpr ObjectSchema kDispersionSchema{"dispersion", kDispersion};
constexpr Property kPointer[] = {required(text("pointer"))};
constexpr ObjectSchema kPointerSchema{"animation pointer", kPointer};

}  // namespace

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
      {"KHR_materials_clearcoat", &kMaterialSchema, &kClearcoatSchema},
      {"KHR_materials_ior", &kMaterialSchema, &kIorSchema},
      {"KHR_materials_sheen", &kMaterialSchema, &kSheenSchema},
      {"KHR_materials_specular", &kMaterialSchema, &kSpecularSchema},
      {"KHR_materials_volume", &kMaterialSchema, &kVolumeSchema},
      {"KHR_materials_iridescence", &kMaterialSchema, &kIridescenceSchema},
      {"KHR_materials_anisotropy", &kMaterialSchema, &kAnisotropySchema},
      {"KHR_materials_dispersion", &kMaterialSchema, &kDispersionSchema},
      {"KHR_animation_pointer", &kChannelTargetSchema, &kPointerSchema},
      {"EXT_texture_webp", &kTextureSchema, &kOtherSourceSchema},
      {"KHR_texture_basisu", &kTextureSchema, &kOtherSourceSchema},
      {"MSFT_texture_dds", &kTextureSchema, &kOtherSourceSchema},
      {"KHR_materials_variants", &kRootSchema, &kVariantsSchema},
      {"KHR_materials_variants", &kPrimitiveSchema, &kMappingsSchema},
  };
  return kSchemas;
}

}  // namespace lightbatch::gltf
