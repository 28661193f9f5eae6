#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/generate/mesh_builder.h"

namespace lightbatch::generate {

struct Part {
  int material = 0;  // Material; of the first variant where it comes in several
  Surface surface;
};

/// One piece of furniture, standing on y = 0 around the vertical axis (lamps hang below y = 0);
/// its user sits on the +z side. Parts of one piece do not share faces: they keep 1 mm apart or
/// pass through each other.
struct Model {
  std::string name;
  std::vector<Part> parts;

  std::uint64_t triangles() const;
};

inline constexpr int kMostDetail = 3;
inline constexpr double kDeskHeight = 0.73;
inline constexpr double kShelfWidth = 0.8;
inline constexpr double kShelfDepth = 0.3;
inline constexpr int kShelfBoards = 5;
inline constexpr int kBooksInRow = 18;
/// Height of the upper side of board `i` of a shelf.
double board_height(int i);

/// detail: 0 (boxes) to kMostDetail (rounded edges, fine turnings).
Model make_desk(int detail);
Model make_chair(int detail);
Model make_shelf(int detail);
Model make_monitor(int detail);
Model make_keyboard(int detail);
Model make_mug(int detail);
Model make_bin(int detail);
Model make_plant(int detail, Random random);
Model make_lamp(int detail, int material);
/// 1..kBooksInRow upright books side by side from x = -0.37; 12 triangles each.
Model make_books(int count, Random random);

}  // namespace lightbatch::generate
