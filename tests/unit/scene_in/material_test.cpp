#include <gtest/gtest.h>

#include <numbers>

#include "core/image/codecs.h"
#include "tests/unit/scene_in/scene_builder.h"

namespace lightbatch::scene_in {
namespace {

constexpr const char* kTransform = "KHR_texture_transform";

/// A square with texture coordinates and material 0; the test fills in the material.
SceneBuilder textured_square(const Json& material) {
  SceneBuilder builder;
  builder.square();
  const std::size_t uv = builder.accessor(std::vector<float>{0, 1, 1, 1, 1, 0, 0, 0}, "VEC2", 2);
  builder.primitive()["attributes"]["TEXCOORD_0"] = uv;
  builder.primitive()["attributes"]["TEXCOORD_1"] = uv;
  builder.primitive()["attributes"]["TEXCOORD_2"] = uv;
  builder.primitive()["material"] = 0;
  builder.json["materials"] = Json::array({material});
  return builder;
}

void add_image(SceneBuilder& builder, int width) {
  image::Image8 pixels;
  pixels.width = width;
  pixels.height = 1;
  pixels.rgba.assign(static_cast<std::size_t>(4 * width), 200);
  const std::size_t view = builder.view(image::encode_png(pixels, true));
  builder.json["images"].push_back({{"bufferView", view}, {"mimeType", "image/png"}});
}

void use(SceneBuilder& builder, const char* extension) {
  builder.json["extensionsUsed"].push_back(extension);
}

TEST(Material, VertexColoursAreReadWhereTheyAre) {
  SceneBuilder builder;
  builder.square();
  builder.primitive()["attributes"]["COLOR_0"] = builder.accessor(
      std::vector<float>{1, 0, 0, 0.5f, 0, 1, 0, 0.5f, 0, 0, 1, 1, 2, -1, 0.25f, 1}, "VEC4", 4);
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.colors.size(), scene.positions.size());
  EXPECT_EQ(scene.colors[0], (scene::VertexColor{{1, 0, 0}, 0.5f}));
  EXPECT_EQ(scene.colors[1], (scene::VertexColor{{0, 1, 0}, 0.5f}));
  // Out of range is brought back.
  EXPECT_EQ(scene.colors[3], (scene::VertexColor{{1, 0, 0.25f}, 1}));
  SceneBuilder plain;
  plain.square();
  EXPECT_TRUE(read(plain).colors.empty());
}

TEST(Material, DefaultsAreThoseOfTheSpecification) {
  const scene::Scene scene = read(textured_square(Json::object()));
  const scene::Material& material = scene.materials[0];
  EXPECT_EQ(material.gltf_index, 0u);
  EXPECT_EQ(material.base_color, (Rgb{1, 1, 1}));
  EXPECT_EQ(material.alpha, 1.0f);
  EXPECT_EQ(material.metallic, 1.0f);
  EXPECT_EQ(material.emission, (Rgb{0, 0, 0}));
  EXPECT_EQ(material.alpha_mode, scene::AlphaMode::kOpaque);
  EXPECT_EQ(material.alpha_cutoff, 0.5f);
  EXPECT_FALSE(material.double_sided);
  EXPECT_FALSE(material.base_color_texture.present());
  EXPECT_EQ(scene.counts.clamped_reflectance, 0u);  // a metal reflects nothing diffusely
}

TEST(Material, FactorsAndExtensions) {
  SceneBuilder builder = textured_square(
      {{"name", "lamp"},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}, {"metallicFactor", 0.25}}},
       {"emissiveFactor", {1, 0.5, 0}},
       {"alphaMode", "MASK"},
       {"alphaCutoff", 0.75},
       {"doubleSided", true},
       {"extensions",
        {{"KHR_materials_emissive_strength", {{"emissiveStrength", 200}}},
         {"KHR_materials_transmission", {{"transmissionFactor", 0.5}}},
         {"KHR_materials_diffuse_transmission",
          {{"diffuseTransmissionFactor", 0.125}, {"diffuseTransmissionColorFactor", {0.5, 1, 1}}}},
         {"KHR_materials_unlit", Json::object()}}}});
  for (const char* name : {"KHR_materials_emissive_strength", "KHR_materials_transmission",
                           "KHR_materials_diffuse_transmission", "KHR_materials_unlit"}) {
    use(builder, name);
  }
  const scene::Scene scene = read(builder);
  const scene::Material& material = scene.materials[0];
  EXPECT_EQ(material.name, "lamp");
  EXPECT_EQ(material.base_color, (Rgb{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(material.alpha, 0.4f);
  EXPECT_EQ(material.metallic, 0.25f);
  EXPECT_EQ(material.emission, (Rgb{200, 100, 0}));
  EXPECT_EQ(material.alpha_mode, scene::AlphaMode::kMask);
  EXPECT_EQ(material.alpha_cutoff, 0.75f);
  EXPECT_TRUE(material.double_sided);
  EXPECT_TRUE(material.unlit);
  EXPECT_EQ(material.transmission, 0.5f);
  EXPECT_EQ(material.diffuse_transmission, 0.125f);
  EXPECT_EQ(material.diffuse_transmission_color, (Rgb{0.5f, 1, 1}));
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(Material, ValuesOutOfRangeAreClampedAndSaid) {
  SceneBuilder builder = textured_square(
      {{"pbrMetallicRoughness", {{"baseColorFactor", {2, -1, 1, 5}}, {"metallicFactor", -3}}},
       {"emissiveFactor", {-1, 0, 1e300}},
       {"alphaMode", "ACME"}});
  const scene::Scene scene = read(builder);
  const scene::Material& material = scene.materials[0];
  EXPECT_EQ(material.base_color, (Rgb{1, 0, 1}));
  EXPECT_EQ(material.alpha, 1.0f);
  EXPECT_EQ(material.metallic, 0.0f);
  EXPECT_EQ(material.emission.r, 0.0f);
  EXPECT_TRUE(is_finite(material.emission));
  EXPECT_EQ(scene.warnings.size(), 2u);
  EXPECT_EQ(scene.counts.clamped_reflectance, 1u);
}

TEST(Material, SpecularGlossinessGivesItsDiffuseColour) {
  SceneBuilder builder = textured_square(
      {{"extensions",
        {{"KHR_materials_pbrSpecularGlossiness", {{"diffuseFactor", {0.5, 0.25, 0, 0.5}}}}}}});
  use(builder, "KHR_materials_pbrSpecularGlossiness");
  const scene::Material material = read(builder).materials[0];
  EXPECT_EQ(material.base_color, (Rgb{0.5f, 0.25f, 0}));
  EXPECT_EQ(material.alpha, 0.5f);
  EXPECT_EQ(material.metallic, 0.0f);
}

TEST(Texture, EachImageIsDecodedOnce) {
  const Json slot = {{"index", 0}};
  SceneBuilder builder = textured_square(
      {{"pbrMetallicRoughness", {{"baseColorTexture", slot}, {"metallicRoughnessTexture", slot}}},
       {"normalTexture", {{"index", 1}}},
       {"emissiveTexture", {{"index", 1}}}});  // emissive factor 0: nobody sees it
  add_image(builder, 3);
  add_image(builder, 5);
  builder.json["textures"] = {{{"source", 0}, {"sampler", 0}}, {{"source", 1}}};
  builder.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}}};
  const scene::Scene scene = read(builder);
  const scene::Material& material = scene.materials[0];
  ASSERT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.images[0]->width, 3);
  EXPECT_EQ(material.base_color_texture.image, 0u);
  EXPECT_EQ(material.metallic_texture.image, 0u);
  EXPECT_FALSE(material.emission_texture.present());
  EXPECT_TRUE(material.has_normal_map);
  EXPECT_EQ(material.base_color_texture.wrap_u, scene::Wrap::kClamp);
  EXPECT_EQ(material.base_color_texture.wrap_v, scene::Wrap::kMirror);
  ASSERT_EQ(scene.uv0.size(), 4u);
  EXPECT_TRUE(scene.uv1.empty());
  EXPECT_EQ(scene.uv0[2], (Vec2f{1, 0}));
}

// An image that no other material slot reads, behind one that is not decoded at all.
TEST(Texture, DiffuseTransmissionIsReadLikeTheOthers) {
  SceneBuilder builder = textured_square(
      {{"normalTexture", {{"index", 0}}},
       {"extensions",
        {{"KHR_materials_diffuse_transmission",
          {{"diffuseTransmissionFactor", 0.5},
           {"diffuseTransmissionTexture", {{"index", 1}}},
           {"diffuseTransmissionColorTexture", {{"index", 1}, {"texCoord", 1}}}}}}}});
  use(builder, "KHR_materials_diffuse_transmission");
  add_image(builder, 3);
  add_image(builder, 5);
  builder.json["textures"] = {{{"source", 0}}, {{"source", 1}}};
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.images[0]->width, 5);
  EXPECT_EQ(scene.materials[0].diffuse_transmission_texture.image, 0u);
  EXPECT_EQ(scene.materials[0].diffuse_transmission_color_texture.image, 0u);
  EXPECT_EQ(scene.uv0.size(), 4u);
  EXPECT_EQ(scene.uv1.size(), 4u);
}

TEST(Texture, FilterIsTheSamplers) {
  for (const auto& [filter, expected] :
       {std::pair{9728, scene::Filter::kNearest}, {9729, scene::Filter::kLinear}}) {
    SceneBuilder builder =
        textured_square({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    add_image(builder, 3);
    builder.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
    builder.json["samplers"] = {{{"magFilter", filter}}};
    EXPECT_EQ(read(builder).materials[0].base_color_texture.filter, expected);
  }
}

TEST(Texture, TransformIsFoldedIn) {
  // The extension's own example: offset (0, 1), a quarter turn, half size: the lower left quadrant.
  SceneBuilder builder = textured_square({{"pbrMetallicRoughness",
                                           {{"baseColorTexture",
                                             {{"index", 0},
                                              {"extensions",
                                               {{kTransform,
                                                 {{"offset", {0, 1}},
                                                  {"rotation", std::numbers::pi / 2},
                                                  {"scale", {0.5, 0.5}},
                                                  {"texCoord", 1}}}}}}}}}});
  use(builder, kTransform);
  add_image(builder, 2);
  builder.json["textures"] = {{{"source", 0}}};
  const scene::Scene scene = read(builder);
  const scene::TextureSlot& slot = scene.materials[0].base_color_texture;
  EXPECT_EQ(slot.uv_set, 1);
  EXPECT_TRUE(scene.uv0.empty());
  EXPECT_EQ(scene.uv1.size(), 4u);
  for (const auto& [u, v] : {std::pair{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}, {1.0f, 1.0f}}) {
    const float x = slot.m00 * u + slot.m01 * v + slot.tu;
    const float y = slot.m10 * u + slot.m11 * v + slot.tv;
    EXPECT_NEAR(x, 0.5f * v, 1e-6f);
    EXPECT_NEAR(y, 1 - 0.5f * u, 1e-6f);
  }
}

TEST(Texture, WhatCannotBeDecodedGivesWayToTheFactor) {
  SceneBuilder builder = textured_square(
      {{"pbrMetallicRoughness",
        {{"baseColorFactor", {0.5, 0.5, 0.5, 1}}, {"baseColorTexture", {{"index", 0}}}}}});
  const std::string ktx = std::string("\xabKTX 20\xbb\r\n\x1a\n", 12) + std::string(68, '\0');
  const std::size_t view = builder.view(std::vector<char>(ktx.begin(), ktx.end()));
  builder.json["images"] = {{{"bufferView", view}, {"mimeType", "image/ktx2"}}};
  builder.json["textures"] = {{{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}}};
  use(builder, "KHR_texture_basisu");
  const scene::Scene scene = read(builder);
  EXPECT_FALSE(scene.materials[0].base_color_texture.present());
  EXPECT_EQ(scene.materials[0].base_color.r, 0.5f);
  EXPECT_EQ(scene.counts.textures_not_decoded, 1u);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("/images/0"), std::string::npos);
  EXPECT_TRUE(scene.uv0.empty());
}

TEST(Texture, ThirdCoordinateSetCountsAsAbsent) {
  SceneBuilder builder = textured_square(
      {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}, {"texCoord", 2}}}}}});
  add_image(builder, 2);
  builder.json["textures"] = {{{"source", 0}}};
  const scene::Scene scene = read(builder);
  EXPECT_FALSE(scene.materials[0].base_color_texture.present());
  EXPECT_EQ(scene.counts.textures_not_decoded, 1u);
}

TEST(Texture, ATransformTooLargeIsNamedAsSuch) {
  SceneBuilder builder = textured_square(
      {{"pbrMetallicRoughness",
        {{"baseColorTexture",
          {{"index", 0}, {"extensions", {{kTransform, {{"offset", {1e300, 0}}}}}}}}}}});
  use(builder, kTransform);
  add_image(builder, 2);
  builder.json["textures"] = {{{"source", 0}}};
  const scene::Scene scene = read(builder);
  EXPECT_FALSE(scene.materials[0].base_color_texture.present());
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find(kTransform), std::string::npos) << scene.warnings[0];
}

TEST(Texture, QuantisedCoordinates) {
  SceneBuilder builder =
      textured_square({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  const std::size_t uv = builder.accessor(
      std::vector<std::uint16_t>{0, 65535, 65535, 0, 0, 0, 65535, 65535}, "VEC2", 2);
  builder.json["accessors"][uv]["normalized"] = true;
  builder.primitive()["attributes"]["TEXCOORD_0"] = uv;
  add_image(builder, 2);
  builder.json["textures"] = {{{"source", 0}}};
  const scene::Scene scene = read(builder);
  EXPECT_EQ(scene.uv0, (std::vector<Vec2f>{{0, 1}, {1, 0}, {0, 0}, {1, 1}}));
}

}  // namespace
}  // namespace lightbatch::scene_in
