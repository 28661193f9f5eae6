/// The object tables of the Khronos glTF 2.0 specification (appendix "Properties Reference"), in
/// its order.
#include "core/gltf/schema.h"
#include "core/gltf/schema_terms.h"

namespace lightbatch::gltf {
namespace {

using namespace schema_terms;  // the words the tables are written in

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
constexpr Property kBufferView[] = {
    required(index("buffer", "buffers")),   count("byteOffset"),
    required(loose_count("byteLength", 1)), loose_count("byteStride", 4, 252),
    choice("target", kTargets, false),      text("name")};

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

constexpr Property kPrimitive[] = {required(index_map("attributes", "accessors")),
                                   index("indices", "accessors"), index("material", "materials"),
                                   choice("mode", kModes), index_maps("targets", "accessors")};
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

}  // namespace

const ObjectSchema kRootSchema{"root", kRoot};
const ObjectSchema kNodeSchema{"node", kNode};
const ObjectSchema kMaterialSchema{"material", kMaterial};
const ObjectSchema kPrimitiveSchema{"primitive", kPrimitive};
const ObjectSchema kTextureSchema{"texture", kTexture};
const ObjectSchema kBufferSchema{"buffer", kBuffer};
const ObjectSchema kBufferViewSchema{"bufferView", kBufferView};
const ObjectSchema kChannelTargetSchema{"animation channel target", kChannelTarget};
const ObjectSchema kNormalTextureSchema{"textureInfo", kNormalTexture};
const ObjectSchema kTextureInfoSchema{"textureInfo", kTextureInfo};

}  // namespace lightbatch::gltf
