#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/math/aabb.h"
#include "core/math/vec.h"

namespace lightbatch::bench {

struct Scene {
  std::string name;
  std::vector<Vec3f> positions;  // three a triangle
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Aabb> boxes;
  bool inside = false;  // the camera stands in it

  void add(const Vec3f& a, const Vec3f& b, const Vec3f& c);
  Aabb bounds() const;
};

/// A file of glb2soup.py: uint32 count, then nine floats a triangle. Empty when there is none.
Scene load_soup(const std::string& path, const std::string& name);

/// Furnished rooms in a row of floors, about n triangles: walls, tables, tessellated spheres.
Scene make_office(std::size_t n);
/// A closed wrinkled torus, like a scan.
Scene make_torus(std::size_t n);
/// Long thin triangles in all directions.
Scene make_needles(std::size_t n);
/// Small triangles of one size, evenly strewn in a cube: what regular grids are best at.
Scene make_swarm(std::size_t n);

}  // namespace lightbatch::bench
