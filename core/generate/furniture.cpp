#include "core/generate/furniture.h"

#include <array>
#include <cmath>
#include <numbers>

#include "core/generate/materials.h"

namespace lightbatch::generate {
namespace {

constexpr double kGap = 0.001;  // between things that stand on or beside each other
constexpr std::array<int, kMostDetail + 1> kTurning = {6, 10, 18, 28};  // facets of a full turn

int facets(int detail) { return kTurning[static_cast<std::size_t>(detail)]; }

Vec3d on_ring(double radius, double height, int i, int count) {
  const double angle = 2 * std::numbers::pi * i / count;
  return {radius * std::cos(angle), height, radius * std::sin(angle)};
}

}  // namespace

std::uint64_t Model::triangles() const {
  std::uint64_t sum = 0;
  for (const Part& part : parts) sum += part.surface.triangles();
  return sum;
}

double board_height(int i) { return 0.10 + 0.37 * i; }

Model make_desk(int detail) {
  Surface wood, steel;
  add_rounded_box(wood, {-0.8, kDeskHeight - 0.03, -0.4}, {0.8, kDeskHeight, 0.4}, 0.008, detail);
  for (const double x : {-0.74, 0.74}) {
    for (const double z : {-0.34, 0.34}) {
      if (detail == 0) {
        add_box(steel, {x - 0.025, kGap, z - 0.025},
                {x + 0.025, kDeskHeight - 0.03 - kGap, z + 0.025});
      } else {
        add_cylinder(steel, {x, kGap, z}, 0.025, kDeskHeight - 0.03 - 2 * kGap, facets(detail));
      }
    }
  }
  if (detail > 0) {
    add_rounded_box(wood, {0.28, 0.06, -0.36}, {0.68, 0.62, 0.34}, 0.006, detail - 1);
    for (int drawer = 0; drawer < 3; ++drawer) {
      const double y = 0.08 + 0.18 * drawer;
      add_rounded_box(wood, {0.29, y, 0.34 + kGap}, {0.67, y + 0.165, 0.36}, 0.005, detail - 1);
      add_rounded_box(steel, {0.42, y + 0.12, 0.36 + kGap}, {0.54, y + 0.135, 0.38}, 0.005,
                      detail - 1);
    }
  }
  return {"desk", {{kWood, std::move(wood)}, {kSteel, std::move(steel)}}};
}

Model make_chair(int detail) {
  Surface fabric, plastic;
  add_rounded_box(fabric, {-0.24, 0.43, -0.24}, {0.24, 0.50, 0.24}, 0.03, detail);
  add_rounded_box(fabric, {-0.22, 0.58, 0.21}, {0.22, 1.02, 0.27}, 0.03, detail);
  add_box(plastic, {-0.04, 0.38, 0.28}, {0.04, 0.80, 0.30});
  if (detail == 0) {
    add_box(plastic, {-0.03, 0.06, -0.03}, {0.03, 0.42, 0.03});
    add_box(plastic, {-0.25, kGap, -0.25}, {0.25, 0.05, 0.25});
    return {"chair", {{kFabric, std::move(fabric)}, {kPlastic, std::move(plastic)}}};
  }
  add_cylinder(plastic, {0, 0.09, 0}, 0.028, 0.33, facets(detail));
  add_cylinder(plastic, {0, 0.075, 0}, 0.045, 0.05, facets(detail));
  for (const double x : {-0.29, 0.29}) {
    add_rounded_box(plastic, {x - 0.03, 0.66, -0.15}, {x + 0.03, 0.69, 0.18}, 0.01, detail);
    add_box(plastic, {x - 0.015, 0.45, 0.02}, {x + 0.015, 0.66 - kGap, 0.06});
  }
  // Foot of five arms out of the hub, a castor under each: a turned ball.
  for (int arm = 0; arm < 5; ++arm) {
    const Vec3d tip = on_ring(0.29, 0.085, arm, 5);
    const Vec3d side = normalized(Vec3d{-tip.z, 0, tip.x}) * 0.02;
    const Vec3d root = on_ring(0.04, 0.085, arm, 5), up{0, 0.03, 0};
    add_quad(plastic, root - side + up, root + side + up, tip + side + up, tip - side + up);
    add_quad(plastic, tip - side, tip + side, root + side, root - side);
    add_quad(plastic, root + side, tip + side, tip + side + up, root + side + up);
    add_quad(plastic, tip - side, root - side, root - side + up, tip - side + up);
    add_quad(plastic, tip + side, tip - side, tip - side + up, tip + side + up);
    std::vector<ProfilePoint> ball;
    const int rings = facets(detail) / 2;
    for (int ring = 0; ring <= rings; ++ring) {
      const double angle = std::numbers::pi * ring / rings;
      const bool pole = ring == 0 || ring == rings;
      ball.push_back({pole ? 0 : 0.034 * std::sin(angle), 0.04 - 0.038 * std::cos(angle)});
    }
    add_lathe(plastic, {tip.x * 0.92, kGap, tip.z * 0.92}, ball, facets(detail));
  }
  return {"chair", {{kFabric, std::move(fabric)}, {kPlastic, std::move(plastic)}}};
}

Model make_shelf(int detail) {
  Surface wood;
  const double half = kShelfWidth / 2, deep = kShelfDepth / 2;
  const double top = board_height(kShelfBoards);
  const int steps = detail > 0 ? detail - 1 : 0;
  for (const double x : {-half, half - 0.02}) {
    add_rounded_box(wood, {x, kGap, -deep}, {x + 0.02, top, deep}, 0.003, steps);
  }
  for (int board = 0; board <= kShelfBoards; ++board) {
    const double y = board_height(board);
    add_rounded_box(wood, {-half + 0.02 + kGap, y - 0.02, -deep + 0.008},
                    {half - 0.02 - kGap, y, deep - 0.002}, 0.003, steps);
  }
  add_box(wood, {-half + 0.021, 0.08, -deep}, {half - 0.021, top - 0.001, -deep + 0.006});
  return {"shelf", {{kWood, std::move(wood)}}};
}

Model make_monitor(int detail) {
  Surface plastic, screen;
  add_rounded_box(plastic, {-0.31, 0.10, -0.03}, {0.31, 0.47, 0.01}, 0.008, detail);
  add_quad(screen, {-0.29, 0.12, 0.011}, {0.29, 0.12, 0.011}, {0.29, 0.45, 0.011},
           {-0.29, 0.45, 0.011});
  add_rounded_box(plastic, {-0.03, 0.016, -0.06}, {0.03, 0.30, -0.031}, 0.008, detail);
  add_rounded_box(plastic, {-0.13, kGap, -0.12}, {0.13, 0.015, 0.08}, 0.005, detail);
  return {"monitor", {{kPlastic, std::move(plastic)}, {kScreen, std::move(screen)}}};
}

Model make_keyboard(int detail) {
  Surface plastic, keys;
  add_rounded_box(plastic, {-0.22, kGap, -0.07}, {0.22, 0.018, 0.07}, 0.004, detail);
  const int rows = detail == 0 ? 0 : 5, columns = 14;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double x = -0.212 + 0.0303 * column, z = -0.064 + 0.0257 * row;
      add_rounded_box(keys, {x, 0.018 + kGap, z}, {x + 0.027, 0.026, z + 0.022}, 0.002,
                      detail > 2 ? 1 : 0);
    }
  }
  Model model{"keyboard", {{kPlastic, std::move(plastic)}}};
  if (rows > 0) model.parts.push_back({kScreen, std::move(keys)});
  return model;
}

Model make_mug(int detail) {
  Surface porcelain;
  add_lathe(porcelain, {0, kGap, 0},
            {{0, 0},
             {0.036, 0},
             {0.04, 0.005},
             {0.042, 0.095},
             {0.038, 0.095},
             {0.035, 0.008},
             {0, 0.008}},
            facets(detail));
  return {"mug", {{kPorcelain, std::move(porcelain)}}};
}

Model make_bin(int detail) {
  Surface steel;
  add_lathe(steel, {0, kGap, 0},
            {{0, 0}, {0.11, 0}, {0.14, 0.32}, {0.135, 0.32}, {0.106, 0.006}, {0, 0.006}},
            facets(detail));
  return {"bin", {{kSteel, std::move(steel)}}};
}

Model make_plant(int detail, Random random) {
  Surface pot, soil, leaves;
  add_lathe(pot, {0, kGap, 0}, {{0, 0}, {0.12, 0}, {0.16, 0.30}, {0.15, 0.30}, {0.147, 0.26}},
            facets(detail));
  add_lathe(soil, {0, kGap, 0}, {{0.1465, 0.255}, {0, 0.262}}, facets(detail));
  // Leaves: strips that rise and bend outwards.
  const int count = 8 + 6 * detail, pieces = 2 + 2 * detail;
  for (int leaf = 0; leaf < count; ++leaf) {
    const double turn = 2 * std::numbers::pi * (leaf + 0.8 * random.next_double()) / count;
    const double reach = 0.16 + 0.12 * random.next_double();
    const double rise = 0.55 + 0.45 * random.next_double();
    const Vec3d out{std::cos(turn), 0, std::sin(turn)}, side{-out.z, 0, out.x};
    const auto spine = [&](double t) {
      return out * (0.03 + reach * t * t) + Vec3d{0, 0.27 + rise * (t - 0.35 * t * t), 0};
    };
    const auto width = [](double t) {
      return 0.045 * std::sin(std::numbers::pi * (0.1 + 0.85 * t));
    };
    for (int piece = 0; piece < pieces; ++piece) {
      const double t0 = static_cast<double>(piece) / pieces, t1 = (piece + 1.0) / pieces;
      add_quad(leaves, spine(t0) - side * width(t0), spine(t0) + side * width(t0),
               spine(t1) + side * width(t1), spine(t1) - side * width(t1));
    }
  }
  return {"plant",
          {{kPorcelain, std::move(pot)}, {kSoil, std::move(soil)}, {kLeaf, std::move(leaves)}}};
}

Model make_lamp(int detail, int material) {
  Surface frame, glow;
  add_rounded_box(frame, {-0.62, -0.09, -0.17}, {0.62, -0.03, 0.17}, 0.01, detail);
  add_quad(glow, {-0.6, -0.092, -0.15}, {0.6, -0.092, -0.15}, {0.6, -0.092, 0.15},
           {-0.6, -0.092, 0.15});
  return {"lamp", {{kPorcelain, std::move(frame)}, {material, std::move(glow)}}};
}

Model make_books(int count, Random random) {
  std::array<Surface, kVariants> covers;
  double x = -0.37;
  for (int book = 0; book < count; ++book) {
    const double thick = 0.02 + 0.018 * random.next_double();
    const double tall = 0.20 + 0.11 * random.next_double();
    const double deep = 0.14 + 0.07 * random.next_double();
    add_box(covers[random.below(kVariants)], {x, kGap, 0.13 - deep}, {x + thick, tall, 0.13});
    x += thick + kGap;
  }
  Model model{"books", {}};
  for (int i = 0; i < kVariants; ++i) {
    Surface& surface = covers[static_cast<std::size_t>(i)];
    if (surface.triangles() > 0) model.parts.push_back({kCover + i, std::move(surface)});
  }
  return model;
}

}  // namespace lightbatch::generate
