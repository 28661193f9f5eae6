#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// A point of a scene triangle, and the light there.
struct LightPoint {
  std::uint32_t triangle = 0;
  float u = 0, v = 0;  // barycentric
};

/// One object's triangles, subdivided where the light changes: corners as points of the triangle
/// they came from, three for each new triangle.
struct LitTriangles {
  std::vector<LightPoint> corners;
  std::vector<Rgb> irradiance;  // one for each corner, lux
  std::vector<Rgb> emission;    // one for each corner, nits; black where colours cannot hold it
};

/// Without a base colour texture the vertices can hold the product, and emission on top of it.
inline bool colour_holds_all(const scene::Material& material) {
  return !material.base_color_texture.present();
}

/// Splits edges while the light, or the emission, in their middle is not the mean of their ends.
/// Whether an edge is split is decided for the edge, not for a triangle, so neighbours of one
/// object stay joined without gaps; a triangle with one, two or three split edges becomes two,
/// three or four.
LitTriangles subdivide(const Writer& writer, const std::vector<std::uint32_t>& triangles,
                       double exposure);

/// Scale from luminance (nits) to colours such that 99 % of the lit area stays below 1.
double choose_exposure(const scene::Scene& scene, const WriteOptions& options);

}  // namespace lightbatch::scene_out
