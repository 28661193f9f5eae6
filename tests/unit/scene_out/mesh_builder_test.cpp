#include "core/scene_out/mesh_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "core/scene_out/corners.h"

namespace lightbatch::scene_out {
namespace {

/// n x n quads in the plane as unindexed corners.
CornerStream plane(int n) {
  CornerStream stream{{"POSITION", 5126, false, "VEC3", 3}, {}};
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}) {
        const float p[3] = {static_cast<float>(i + u), static_cast<float>(j + v), 0};
        push_floats(stream.bytes, p, 3);
      }
  return stream;
}

using Triangle = std::array<std::array<float, 3>, 3>;
std::multiset<Triangle> triangles_of(const std::vector<MeshData>& meshes) {
  std::multiset<Triangle> result;
  for (const MeshData& mesh : meshes)
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      Triangle t;
      for (std::size_t c = 0; c < 3; ++c)
        std::memcpy(t[c].data(), mesh.data[0].data() + mesh.indices[i + c] * 12, 12);
      std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
      result.insert(t);
    }
  return result;
}

TEST(MeshBuilder, SharesVerticesAndKeepsTriangles) {
  const auto meshes = build_meshes({plane(20)}, {{0, 0, 2400}}, 65535);
  ASSERT_EQ(meshes.size(), 1u);
  EXPECT_EQ(meshes[0].vertex_count, 441u);
  EXPECT_EQ(meshes[0].data[0].size(), 441u * 12);
  const auto triangles = triangles_of(meshes);
  EXPECT_EQ(triangles.size(), 800u);
  EXPECT_TRUE(triangles.contains(Triangle{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}}));
  // Vertices are numbered by first use.
  std::uint32_t next = 0;
  for (const std::uint32_t i : meshes[0].indices) {
    EXPECT_LE(i, next);
    next = std::max(next, i + 1);
  }
}

TEST(MeshBuilder, RangesKeepTheirTriangles) {
  const auto meshes = build_meshes({plane(8)}, {{5, 0, 96}, {9, 96, 288}}, 65535);
  ASSERT_EQ(meshes[0].ranges.size(), 2u);
  for (std::uint32_t i = 0; i < 384; ++i) {
    float p[3];
    std::memcpy(p, meshes[0].data[0].data() + meshes[0].indices[i] * 12, 12);
    EXPECT_EQ(i < 96, p[1] < 2 || (p[1] == 2 && i < 96));
  }
}

TEST(MeshBuilder, SplitsAtTheVertexLimit) {
  const auto whole = triangles_of(build_meshes({plane(20)}, {{0, 0, 600}, {1, 600, 1800}}, 65535));
  for (const std::uint32_t limit : {3u, 10u, 100u, 440u}) {
    const auto meshes = build_meshes({plane(20)}, {{0, 0, 600}, {1, 600, 1800}}, limit);
    EXPECT_GT(meshes.size(), 1u);
    for (const MeshData& mesh : meshes) {
      EXPECT_LE(mesh.vertex_count, limit);
      std::uint32_t at = 0;
      for (const IndexRange& r : mesh.ranges) {
        EXPECT_EQ(r.first, at);
        at += r.count;
      }
      EXPECT_EQ(at, mesh.indices.size());
    }
    EXPECT_EQ(triangles_of(meshes), whole);
  }
}

TEST(MeshBuilder, RefinedIdsAreEqualExactlyWhereAllBytesAre) {
  std::vector<std::uint32_t> ids(4, 0);
  const float first[4] = {1, 1, 2, 1};
  EXPECT_EQ(refine_ids(ids, std::as_bytes(std::span(first)), 4), 2u);
  const float second[4] = {5, 6, 5, 5};
  EXPECT_EQ(refine_ids(ids, std::as_bytes(std::span(second)), 4), 3u);
  EXPECT_EQ(ids[0], ids[3]);
  EXPECT_NE(ids[0], ids[1]);
  EXPECT_NE(ids[0], ids[2]);
}

}  // namespace
}  // namespace lightbatch::scene_out
