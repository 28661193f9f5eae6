#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <numeric>
#include <string>
#include <vector>

#include "core/hierarchy/isometric.h"
#include "core/hierarchy/level_boxes.h"

namespace lightbatch::hierarchy {

std::string level_svg(std::span<const Aabb> boxes, int width, int height, std::size_t most) {
  width = std::clamp(width, 16, 8192);
  height = std::clamp(height, 16, 8192);
  std::vector<std::size_t> order(boxes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (order.size() > most) {
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return boxes[a].area() > boxes[b].area();
    });
    order.resize(most);
  }
  const auto nearness = [&](std::size_t i) {
    return to_double(boxes[i].lower) + to_double(boxes[i].upper);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const Vec3d p = nearness(a), q = nearness(b);
    return p.x + p.y + p.z < q.x + q.y + q.z;
  });
  const Isometric view(boxes, width, height);
  char text[256];
  std::snprintf(
      text, sizeof text,
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"0 0 "
      "%d %d\">\n<style>path{stroke:#234;stroke-width:.4;fill-opacity:.5}.x{fill:#8ab}"
      ".y{fill:#cde}.z{fill:#579}</style>\n",
      width, height, width, height);
  std::string svg = text;
  static constexpr const char* kNames[Isometric::kFaces] = {"x", "y", "z"};
  for (const std::size_t i : order) {
    for (int axis = 0; axis < Isometric::kFaces; ++axis) {
      const Isometric::Face f = view.face(boxes[i], axis);
      std::snprintf(text, sizeof text,
                    "<path class=\"%s\" d=\"M%.1f %.1fL%.1f %.1fL%.1f %.1fL%.1f %.1fZ\"/>\n",
                    kNames[axis], f[0].x, f[0].y, f[1].x, f[1].y, f[2].x, f[2].y, f[3].x, f[3].y);
      svg += text;
    }
  }
  if (boxes.size() > order.size()) {
    std::snprintf(text, sizeof text,
                  "<text x=\"8\" y=\"%d\" font-size=\"12\">%zu smaller boxes left out</text>\n",
                  height - 8, boxes.size() - order.size());
    svg += text;
  }
  return svg + "</svg>\n";
}

}  // namespace lightbatch::hierarchy
