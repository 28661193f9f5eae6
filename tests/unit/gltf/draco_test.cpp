#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/gltf/accessor.h"
#include "core/gltf/draco_header.h"
#include "tests/unit/gltf/scene_files.h"

namespace lightbatch::gltf {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";

/// A wavy grid of n x n cells, compressed. Draco decides the order of points and faces.
struct Compressed {
  Bytes stream;
  std::size_t points = 0;
  std::size_t faces = 0;
  int position_id = 0;
};

Compressed compress(int n, bool edgebreaker, float height = 0.1f) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2 * n * n);
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const auto at = [n, height](int x, int y) {
    const float u = static_cast<float>(x) / static_cast<float>(n);
    const float v = static_cast<float>(y) / static_cast<float>(n);
    return std::array<float, 3>{u, v, height * std::sin(7 * u) * std::cos(5 * v)};
  };
  std::uint32_t face = 0;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const auto a = at(x, y), b = at(x + 1, y), c = at(x + 1, y + 1), d = at(x, y + 1);
      builder.SetAttributeValuesForFace(position, draco::FaceIndex(face++), a.data(), b.data(),
                                        c.data());
      builder.SetAttributeValuesForFace(position, draco::FaceIndex(face++), a.data(), c.data(),
                                        d.data());
    }
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetEncodingMethod(edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING
                                        : draco::MESH_SEQUENTIAL_ENCODING);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  if (height == 0) encoder.SetSpeedOptions(0, 0);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  Compressed result;
  const auto* first = reinterpret_cast<const std::byte*>(buffer.data());
  result.stream.assign(first, first + buffer.size());
  result.points = encoder.num_encoded_points();
  result.faces = encoder.num_encoded_faces();
  if (result.points == 0) result.points = mesh->num_points();
  if (result.faces == 0) result.faces = mesh->num_faces();
  result.position_id = static_cast<int>(mesh->attribute(position)->unique_id());
  return result;
}

SceneBuilder scene_of(const Compressed& mesh) {
  SceneBuilder builder;
  const std::size_t view = builder.view(std::vector<std::byte>(mesh.stream));
  builder.json["accessors"] = {
      {{"componentType", 5126}, {"count", mesh.points}, {"type", "VEC3"}},
      {{"componentType", 5123}, {"count", 3 * mesh.faces}, {"type", "SCALAR"}}};
  Json primitive = {{"attributes", {{"POSITION", 0}}}, {"indices", 1}};
  primitive["extensions"][kDraco] = {{"bufferView", view},
                                     {"attributes", {{"POSITION", mesh.position_id}}}};
  builder.json["meshes"] = Json::array({{{"primitives", Json::array({primitive})}}});
  builder.json["extensionsUsed"] = {kDraco};
  builder.json["extensionsRequired"] = {kDraco};
  return builder;
}

TEST(Draco, DecodesToPlainGltf) {
  for (const bool edgebreaker : {true, false}) {
    const Compressed mesh = compress(12, edgebreaker);
    const auto document = scene_of(mesh).read();
    ASSERT_TRUE(document.ok()) << document.status().to_string();
    EXPECT_TRUE(document->had_draco);
    EXPECT_FALSE(document->json.contains("extensionsUsed"));
    EXPECT_FALSE(document->json.contains("extensionsRequired"));
    EXPECT_FALSE(document->json["meshes"][0]["primitives"][0].contains("extensions"));
    const auto positions = read_values(*document, 0);
    const auto indices = read_indices(*document, 1);
    ASSERT_TRUE(positions.ok() && indices.ok());
    double area = 0;
    for (std::size_t i = 0; i < indices->size(); i += 3) {
      double p[3][2];
      for (std::size_t k = 0; k < 3; ++k) {
        const float* v = positions->data.data() + 3 * (*indices)[i + k];
        p[k][0] = static_cast<double>(v[0]);
        p[k][1] = static_cast<double>(v[1]);
        // 14 bits over a range of 1: a step of 6e-5.
        EXPECT_NEAR(v[2], 0.1f * std::sin(7 * v[0]) * std::cos(5 * v[1]), 2e-4f);
      }
      area += 0.5 * ((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) -
                     (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]));
    }
    EXPECT_NEAR(area, 1.0, 1e-3);  // the grid's shadow is the unit square, winding kept
  }
}

TEST(Draco, FlatGridsMayTakeLessThanABytePerHundredFaces) {
  // 129 cells divide the 2^14 - 1 steps of the quantisation: every prediction is exact.
  const Compressed mesh = compress(129, true, 0.0f);
  EXPECT_GT(mesh.faces, 60 * mesh.stream.size());
  const auto document = scene_of(mesh).read();
  EXPECT_TRUE(document.ok()) << document.status().to_string();
}

TEST(Draco, CountsAreReadWithoutDecoding) {
  for (const bool edgebreaker : {true, false}) {
    const Compressed mesh = compress(9, edgebreaker);
    const auto counts = read_draco_counts(mesh.stream, "p");
    ASSERT_TRUE(counts.ok()) << counts.status().to_string();
    EXPECT_EQ(counts->faces, mesh.faces);
    EXPECT_EQ(counts->vertices, mesh.points);
    EXPECT_EQ(counts->edgebreaker, edgebreaker);
  }
}

TEST(Draco, LiesOfTheAccessorsAreRefused) {
  const Compressed mesh = compress(6, true);
  const auto refused = [&mesh](const char* pointer, const Json& value) {
    SceneBuilder builder = scene_of(mesh);
    builder.json[Json::json_pointer(pointer)] = value;
    const auto document = builder.read();
    if (document.ok()) return std::string("accepted");
    EXPECT_NE(document.status().place().find("/meshes/0/primitives/0"), std::string::npos)
        << document.status().to_string();
    return document.status().reason();
  };
  const std::string extension = std::string("/meshes/0/primitives/0/extensions/") + kDraco;
  EXPECT_EQ(refused("/accessors/0/count", mesh.points + 1), "INPUT_MALFORMED");
  EXPECT_EQ(refused("/accessors/0/count", 1), "INPUT_MALFORMED");
  EXPECT_EQ(refused("/accessors/0/count", 2'000'000'000), "INPUT_MALFORMED");
  EXPECT_EQ(refused("/accessors/1/count", 3), "INPUT_MALFORMED");
  EXPECT_EQ(refused("/accessors/1/count", 2'000'000'001), "INPUT_MALFORMED");
  EXPECT_EQ(refused("/accessors/1/componentType", 5126), "INPUT_MALFORMED");
  EXPECT_EQ(refused("/accessors/0/type", "VEC4"), "INPUT_MALFORMED");
  EXPECT_EQ(refused("/meshes/0/primitives/0/mode", 5), "INPUT_UNSUPPORTED");
  EXPECT_EQ(refused((extension + "/bufferView").c_str(), 9), "INPUT_MALFORMED");
  EXPECT_EQ(refused((extension + "/attributes/POSITION").c_str(), 99), "INPUT_MALFORMED");
  EXPECT_EQ(refused((extension + "/attributes/NORMAL").c_str(), 0), "INPUT_MALFORMED");
}

TEST(Draco, EveryTruncationIsRefusedAndDamageNeverCrashes) {
  for (const bool edgebreaker : {true, false}) {
    const Compressed mesh = compress(4, edgebreaker);
    for (std::size_t size = 1; size < mesh.stream.size(); ++size) {
      Compressed cut = mesh;
      cut.stream.resize(size);
      EXPECT_FALSE(scene_of(cut).read().ok()) << size;
    }
    for (std::size_t i = 0; i < mesh.stream.size(); ++i) {
      for (const auto flip : {std::byte{1}, std::byte{0x10}, std::byte{0x80}, std::byte{0xff}}) {
        Compressed damaged = mesh;
        damaged.stream[i] ^= flip;
        const auto document = scene_of(damaged).read();
        if (document.ok()) {
          EXPECT_EQ(read_indices(*document, 1)->size(), 3 * mesh.faces);
        }
      }
    }
  }
}

TEST(Draco, GiantCountsInAShortStreamAreRefused) {
  // Header of an edgebreaker mesh that claims 2^30 faces and as many vertices.
  std::string stream = std::string("DRACO\2\2\1\1\0\0\0", 12);
  const std::string huge = "\x80\x80\x80\x80\x04";
  stream += huge + huge + std::string(1, '\0') + huge + std::string(8, '\0');
  Compressed mesh;
  const auto bytes = as_bytes(stream);
  mesh.stream.assign(bytes.begin(), bytes.end());
  mesh.points = std::size_t{1} << 30;
  mesh.faces = std::size_t{1} << 30;
  const auto document = scene_of(mesh).read();
  ASSERT_FALSE(document.ok());
  EXPECT_NE(document.status().message().find("cannot hold"), std::string::npos)
      << document.status().to_string();
}

TEST(Draco, HeadersOfOtherKindsAreNamed) {
  EXPECT_EQ(read_draco_counts(as_bytes("DRAC"), "p").status().reason(), "INPUT_MALFORMED");
  EXPECT_EQ(
      read_draco_counts(as_bytes(std::string("DRACO\1\1\1\1\0\0xxxx", 15)), "p").status().reason(),
      "INPUT_UNSUPPORTED");
  EXPECT_EQ(
      read_draco_counts(as_bytes(std::string("DRACO\2\2\0\1\0\0xxxx", 15)), "p").status().reason(),
      "INPUT_UNSUPPORTED");
  // Metadata that claims 4 GiB, and metadata nested without end.
  std::string metadata =
      std::string("DRACO\2\2\1\1\0\x80", 11) + std::string("\0\1\1x", 4) + "\xff\xff\xff\xff\x0f";
  EXPECT_FALSE(read_draco_counts(as_bytes(metadata), "p").ok());
  std::string nested = std::string("DRACO\2\2\1\1\0\x80\0", 12);
  for (int i = 0; i < 100'000; ++i) nested += std::string("\0\1\0", 3);
  EXPECT_FALSE(read_draco_counts(as_bytes(nested), "p").ok());
}

TEST(Draco, AccessorsWithAFallbackAreKept) {
  const Compressed mesh = compress(3, true);
  SceneBuilder builder = scene_of(mesh);
  const std::vector<float> fallback(3 * mesh.points, 0.5f);
  builder.json["accessors"][0]["bufferView"] = builder.view(fallback);
  // A second primitive without Draco uses the fallback's accessor.
  Json plain = {{"attributes", {{"POSITION", 0}}}};
  builder.json["meshes"][0]["primitives"].push_back(plain);
  const auto document = builder.read();
  ASSERT_TRUE(document.ok()) << document.status().to_string();
  const Json& primitives = document->json["meshes"][0]["primitives"];
  EXPECT_EQ(primitives[1]["attributes"]["POSITION"], 0);
  EXPECT_NE(primitives[0]["attributes"]["POSITION"], 0);
  EXPECT_EQ(read_values(*document, 0)->data, fallback);
}

}  // namespace
}  // namespace lightbatch::gltf
