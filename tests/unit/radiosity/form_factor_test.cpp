#include "core/radiosity/form_factor.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/math/sampling.h"
#include "core/math/sobol.h"
#include "core/radiosity/polygon_form_factor.h"

namespace lightbatch::radiosity {
namespace {

using Polygon = std::vector<Vec3d>;

Polygon reversed(Polygon p) { return {p.rbegin(), p.rend()}; }

/// Unit square in y = 0..1, hinged on x = 0 at `degrees` from the floor's square.
Polygon hinged(double degrees) {
  const double c = std::cos(degrees * kPiDouble / 180), s = std::sin(degrees * kPiDouble / 180);
  return {{0, 0, 0}, {0, 1, 0}, {c, 1, s}, {c, 0, s}};
}

const Polygon kSquare = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

Polygon above(double height) {
  return {{0, 1, height}, {1, 1, height}, {1, 0, height}, {0, 0, height}};
}

/// Parallel rectangles x by y, z apart (Hottel; Howell's catalogue C-11).
double parallel_rectangles(double width, double depth, double z) {
  const double x = width / z, y = depth / z;
  const double x1 = 1 + x * x, y1 = 1 + y * y;
  return 2 / (kPiDouble * x * y) *
         (std::log(std::sqrt(x1 * y1 / (1 + x * x + y * y))) +
          x * std::sqrt(y1) * std::atan(x / std::sqrt(y1)) +
          y * std::sqrt(x1) * std::atan(y / std::sqrt(x1)) - x * std::atan(x) - y * std::atan(y));
}

/// From a width (x) by length (l) floor to a height (z) by length wall on a common edge (C-14).
double perpendicular_rectangles(double width, double height, double length) {
  const double w = width / length, h = height / length;
  const double a = h * h + w * w;
  const double product = (1 + w * w) * (1 + h * h) / (1 + a) *
                         std::pow(w * w * (1 + a) / ((1 + w * w) * a), w * w) *
                         std::pow(h * h * (1 + a) / ((1 + h * h) * a), h * h);
  return 1 / (kPiDouble * w) *
         (w * std::atan(1 / w) + h * std::atan(1 / h) - std::sqrt(a) * std::atan(1 / std::sqrt(a)) +
          0.25 * std::log(product));
}

struct Case {
  std::string name;
  Polygon a, b;
  double factor;
};

// Closed forms, or the point formula integrated to 1e-8 elsewhere; 1000 apart by its series
// (1 - 2 / (3 z^2)) / (pi z^2), where the closed form loses its digits.
std::vector<Case> known_pairs() {
  const Polygon tiny = {{0.5, 0.501, 0.7}, {0.501, 0.501, 0.7}, {0.501, 0.5, 0.7}, {0.5, 0.5, 0.7}};
  const Polygon rotated = {{0.3, 1.4, 0.7}, {1.7, 0.9, 1.1}, {1.2, -0.4, 1.6}, {-0.2, 0.1, 1.2}};
  const Polygon sliver = {{0.0, 0.5, 0.7}, {0.0, 0.5000001, 0.7}, {1.0, 0.5, 0.7}};
  return {{"squares 0.01 apart", kSquare, above(0.01), 0.9804166029259733},
          {"squares 0.1 apart", kSquare, above(0.1), 0.8269945223972565},
          {"squares 1 apart", kSquare, above(1), 0.19982489569838746},
          {"squares 10 apart", kSquare, above(10), 0.0031620568387546884},
          {"squares 1000 apart", kSquare, above(1000), 3.183096740e-07},
          {"edge at 90", kSquare, hinged(90), 0.2000437760754054},
          {"edge at 45", kSquare, hinged(45), 0.48334769547888445},
          {"edge at 135", kSquare, hinged(135), 0.04830944780182153},
          {"edge at 10", kSquare, hinged(10), 0.8496061249438625},
          {"edge at 170", kSquare, hinged(170), 0.0023620566772969273},
          {"disjoint, rotated", kSquare, rotated, 0.29868963229081025},
          {"large to tiny", kSquare, tiny, 3.896460661416999e-07},
          {"tiny to large", tiny, kSquare, 0.38964606614171465},
          {"sliver over a square", sliver, kSquare, 0.3440740062471898}};
}

// 1e-4 is the promise; 1e-6 is the tolerance asked for by default.
TEST(FormFactor, KnownPairs) {
  for (const Case& c : known_pairs()) {
    EXPECT_NEAR(form_factor(c.a, c.b) / c.factor, 1, 1e-6) << c.name;
  }
}

TEST(FormFactor, RectanglesInClosedForm) {
  Random random(4);
  for (int i = 0; i < 20; ++i) {
    const double w = 0.2 + 3 * random.next_double(), d = 0.2 + 3 * random.next_double(),
                 h = 0.05 + 3 * random.next_double();
    const Polygon floor = {{0, 0, 0}, {w, 0, 0}, {w, d, 0}, {0, d, 0}};
    const Polygon roof = {{0, 0, h}, {0, d, h}, {w, d, h}, {w, 0, h}};
    const Polygon wall = {{0, 0, 0}, {0, d, 0}, {0, d, h}, {0, 0, h}};
    EXPECT_NEAR(form_factor(floor, roof) / parallel_rectangles(w, d, h), 1, 1e-6);
    EXPECT_NEAR(form_factor(floor, wall) / perpendicular_rectangles(w, h, d), 1, 1e-6);
  }
}

// Coaxial equal discs, C-40, as 256-gons: their area is 1e-4 short.
TEST(FormFactor, DiscsInClosedForm) {
  for (double h : {0.2, 1.0, 5.0}) {
    Polygon low, high;
    for (int i = 0; i < 256; ++i) {
      const double angle = 2 * kPiDouble * i / 256;
      low.push_back({std::cos(angle), std::sin(angle), 0});
      high.push_back({std::cos(angle), std::sin(angle), h});
    }
    high = reversed(high);
    const double x = 2 + h * h;
    const double exact = 0.5 * (x - std::sqrt(x * x - 4));
    EXPECT_NEAR(form_factor(low, high, 1e-4) / exact, 1, 3e-4) << h;
  }
}

TEST(FormFactor, Reciprocity) {
  for (const Case& c : known_pairs()) {
    const double area_a = length(doubled_area(c.a)), area_b = length(doubled_area(c.b));
    const double ab = area_a * form_factor(c.a, c.b), ba = area_b * form_factor(c.b, c.a);
    EXPECT_NEAR(ab / ba, 1, 2e-6) << c.name;
  }
}

TEST(FormFactor, BacksAndDegeneratePolygonsSeeNothing) {
  EXPECT_EQ(form_factor(kSquare, reversed(above(1))), 0);
  EXPECT_EQ(form_factor(reversed(kSquare), above(1)), 0);
  EXPECT_EQ(form_factor(kSquare, kSquare), 0);
  const Polygon beside = {{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}};
  EXPECT_EQ(form_factor(kSquare, beside), 0);
  const Polygon line = {{0, 0, 1}, {1, 0, 1}, {2, 0, 1}};
  EXPECT_EQ(form_factor(kSquare, line), 0);
  EXPECT_EQ(form_factor(kSquare, Polygon{{0, 0, 1}, {1, 0, 1}}), 0);
  EXPECT_EQ(form_factor(Polygon{}, kSquare), 0);
}

/// Faces of a box, or of the tetrahedron, fronts inwards.
std::vector<Polygon> closed_box(double x, double y, double z) {
  const std::array<Vec3d, 8> v = {Vec3d{0, 0, 0}, {x, 0, 0}, {x, y, 0}, {0, y, 0},
                                  {0, 0, z},      {x, 0, z}, {x, y, z}, {0, y, z}};
  return {{v[0], v[1], v[2], v[3]}, {v[7], v[6], v[5], v[4]}, {v[4], v[5], v[1], v[0]},
          {v[3], v[2], v[6], v[7]}, {v[0], v[3], v[7], v[4]}, {v[5], v[6], v[2], v[1]}};
}

TEST(FormFactor, RowsOfClosedRoomsSumToOne) {
  std::vector<std::vector<Polygon>> rooms = {closed_box(1, 1, 1), closed_box(5, 2, 0.1),
                                             closed_box(1e-3, 1, 1000)};
  const Vec3d a{0, 0, 0}, b{1, 0.1, 0}, c{0.2, 1.3, 0.1}, d{0.3, 0.2, 0.8};
  rooms.push_back({{a, b, c}, {a, d, b}, {b, d, c}, {a, c, d}});
  for (const auto& room : rooms) {
    for (const Polygon& from : room) {
      double sum = 0;
      for (const Polygon& to : room) sum += form_factor(from, to);
      EXPECT_NEAR(sum, 1, 3e-6);
    }
  }
}

// --- point to polygon ---

double point_factor(const Vec3d& p, const Vec3d& n, const Polygon& polygon, double slack = 0) {
  return point_to_polygon(p, n, polygon, slack);
}

/// The same by arccosines in long double, unclipped: the polygon must be above the horizon.
double by_arccosines(const Vec3d& p, const Vec3d& n, const Polygon& polygon) {
  using L = long double;
  L sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto wide = [](const Vec3d& v) { return Vec3<L>{v.x, v.y, v.z}; };
    const Vec3<L> a = wide(polygon[i]) - wide(p);
    const Vec3<L> b = wide(polygon[(i + 1) % polygon.size()]) - wide(p);
    const Vec3<L> c = cross(b, a);
    sum += dot(wide(n), c) / length(c) * std::atan2(length(c), dot(a, b));
  }
  return static_cast<double>(sum / (2 * static_cast<L>(kPiDouble)));
}

TEST(PointToPolygon, EqualsTheArctangentForm) {
  Random random(8);
  for (int i = 0; i < 5000; ++i) {
    const double size = std::pow(10, 4 * random.next_double() - 2);
    Polygon t;
    for (int k = 0; k < 3; ++k) {
      t.push_back({size * (random.next_double() - 0.5), size * (random.next_double() - 0.5),
                   0.001 + size * random.next_double()});
    }
    const double exact = by_arccosines({0, 0, 0}, {0, 0, 1}, t);
    const double value = point_factor({0, 0, 0}, {0, 0, 1}, exact > 0 ? t : reversed(t));
    EXPECT_NEAR(value, std::abs(exact), 1e-11);
    EXPECT_EQ(point_factor({0, 0, 0}, {0, 0, 1}, exact > 0 ? reversed(t) : t), 0);
  }
}

// Small and far: A cos cos / (pi d^2) is right to (size / d)^2.
TEST(PointToPolygon, KeepsDigitsOfDistantPolygons) {
  for (double size : {1e-3, 1e-5, 1e-7}) {
    const Polygon t = {{0.3, 0.4 + size, 1}, {0.3 + size, 0.4, 1}, {0.3, 0.4, 1}};
    const double d2 = 1 + 0.25;
    EXPECT_NEAR(point_factor({0, 0, 0}, {0, 0, 1}, t) / (size * size / 2 / (kPiDouble * d2 * d2)),
                1, 2 * size + 1e-7);
  }
}

TEST(PointToPolygon, LampOneMillimetreAway) {
  const Polygon lamp = above(0.001);
  // Unbounded lamp: 1; the rest is what the edges let by.
  EXPECT_GT(point_factor({0.5, 0.5, 0}, {0, 0, 1}, lamp), 0.99999);
  EXPECT_LT(point_factor({0.5, 0.5, 0}, {0, 0, 1}, lamp), 1);
  EXPECT_NEAR(point_factor({0, 0.5, 0}, {0, 0, 1}, lamp), 0.5, 1e-5);
  EXPECT_NEAR(point_factor({1.1, 0.5, 0}, {0, 0, 1}, lamp) * 1000 / 3141.59, 7.568e-5, 1e-3);
  // In the lamp's plane, or behind it, nothing; within the slack of the plane nothing.
  EXPECT_EQ(point_factor({0.5, 0.5, 0.001}, {0, 0, 1}, lamp), 0);
  EXPECT_EQ(point_factor({0.5, 0.5, 0.002}, {0, 0, 1}, lamp), 0);
  EXPECT_EQ(point_factor({0.5, 0.5, 0.001 - 1e-7}, {0, 0, 1}, lamp, 4e-7), 0);
}

// Half below the horizon: a wall through the receiver's plane counts as the half above it.
TEST(PointToPolygon, IsClippedToTheHorizon) {
  const Polygon upper = {{1, -1, 0}, {1, -1, 1}, {1, 1, 1}, {1, 1, 0}};
  const Polygon whole = {{1, -1, -3}, {1, -1, 1}, {1, 1, 1}, {1, 1, -3}};
  const double half = point_factor({0, 0, 0}, {0, 0, 1}, upper);
  EXPECT_GT(half, 0.05);
  EXPECT_NEAR(point_factor({0, 0, 0}, {0, 0, 1}, whole), half, 1e-13);
  // Any first vertex.
  for (std::size_t shift = 0; shift < 4; ++shift) {
    Polygon turned;
    for (std::size_t i = 0; i < 4; ++i) turned.push_back(whole[(i + shift) % 4]);
    EXPECT_NEAR(point_factor({0, 0, 0}, {0, 0, 1}, turned), half, 1e-13);
  }
  // A concave polygon (a comb whose teeth reach above the horizon) is the sum of its teeth.
  const Polygon comb = {{1, -2, -1},  {1, -2, 1}, {1, -1, 1}, {1, -1, -0.5},
                        {1, 1, -0.5}, {1, 1, 1},  {1, 2, 1},  {1, 2, -1}};
  const Polygon left = {{1, -2, 0}, {1, -2, 1}, {1, -1, 1}, {1, -1, 0}};
  const Polygon right = {{1, 1, 0}, {1, 1, 1}, {1, 2, 1}, {1, 2, 0}};
  EXPECT_NEAR(point_factor({0, 0, 0}, {0, 0, 1}, comb),
              point_factor({0, 0, 0}, {0, 0, 1}, left) + point_factor({0, 0, 0}, {0, 0, 1}, right),
              1e-12);
}

TEST(PointToPolygon, TouchingWallTendsToAHalf) {
  const Polygon wall = {{0, -1, 0}, {0, 1, 0}, {0, 1, 2}, {0, -1, 2}};
  for (double d : {1e-3, 1e-6, 1e-9}) {
    EXPECT_NEAR(point_factor({d, 0, 0}, {0, 0, 1}, wall), 0.5, d + 1e-9) << d;
  }
  EXPECT_EQ(point_factor({0, 0, 0}, {0, 0, 1}, wall), 0);
  // On the wall's own corner, edge, and inside: finite and 0.
  EXPECT_EQ(point_factor({0, 1, 2}, {0, 0, 1}, wall), 0);
  EXPECT_EQ(point_factor({0, 0.5, 1}, {1, 0, 0}, wall), 0);
}

// Any closed room seen from inside fills the hemisphere, whichever way the point looks.
TEST(PointToPolygon, ClosedRoomFillsTheHemisphere) {
  Random random(3);
  for (const auto& size : {Vec3d{1, 1, 1}, Vec3d{10, 3, 0.01}, Vec3d{1e-3, 1e3, 1}}) {
    const auto room = closed_box(size.x, size.y, size.z);
    for (int i = 0; i < 500; ++i) {
      const Vec3d p{size.x * random.next_double(), size.y * random.next_double(),
                    size.z * random.next_double()};
      const Vec3d n = to_double(cosine_hemisphere({random.next_float(), random.next_float()})) *
                      (i % 2 == 0 ? 1 : -1);
      double sum = 0;
      for (const Polygon& face : room) sum += point_factor(p, normalized(n), face);
      EXPECT_NEAR(sum, 1, 1e-9);
    }
  }
}

TEST(PointToPolygon, HostileInputsStayFinite) {
  Random random(12);
  const std::array<double, 9> values = {0, 1, -1, 1e-300, 1e150, -1e-160, 1e-8, 3, -0.0};
  for (int i = 0; i < 200000; ++i) {
    Polygon t;
    const auto pick = [&] { return values[random.below(values.size())]; };
    for (int k = 0; k < 4; ++k) t.push_back({pick(), pick(), pick()});
    const double value = point_factor({pick(), pick(), pick()}, {0, 0, 1}, t);
    ASSERT_TRUE(value >= 0 && value <= 1) << value;
  }
}

}  // namespace
}  // namespace lightbatch::radiosity
