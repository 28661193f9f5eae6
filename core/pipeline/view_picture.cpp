#include "core/pipeline/view_picture.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/batches/viewpoints.h"
#include "core/lightmap/look_up.h"
#include "core/math/sampling.h"
#include "core/optics/surface_frame.h"

namespace lightbatch::pipeline {
namespace {

struct Camera {
  Vec3d eye, forward, right, up;
  double half_height = 0.55;  // tangent of half the vertical field of view
};

Camera look(const Vec3d& eye, const Vec3d& forward, double half_height) {
  Camera c{eye, normalized(forward), {}, {}, half_height};
  const Vec3d pole = std::fabs(c.forward.y) > 0.999 ? Vec3d{0, 0, 1} : Vec3d{0, 1, 0};
  c.right = normalized(cross(c.forward, pole));
  c.up = cross(c.right, c.forward);
  return c;
}

float depth_along(const Prepared& p, const Vec3d& eye, const Vec3d& direction) {
  optics::ClosestFilter filter(*p.optics);
  const rays::Hit hit =
      p.caster->closest({to_float(eye), to_float(direction)}, rays::kNoTriangle, &filter);
  return hit.found() ? hit.t : std::numeric_limits<float>::infinity();
}

/// Looking out of the scene is no view of it.
double bounded(double diagonal, double depth) {
  return std::isfinite(depth) ? std::min(diagonal, depth) : 0.01 * diagonal;
}

/// A standing point and direction with an open but bounded view; false when the scene is no room.
bool find_inside(const Prepared& p, Camera& camera) {
  const auto eyes = batches::Viewpoints(*p.scene, {}).standing_eyes(24, 0);
  const double diagonal = static_cast<double>(p.scene->box.diagonal());
  double best = 0;
  std::size_t roofed = 0;
  for (const Vec3d& eye : eyes) {
    if (std::isfinite(depth_along(p, eye, {0.05, 1, 0.03}))) ++roofed;
    for (int k = 0; k < 12; ++k) {
      const double yaw = 2 * kPiDouble * k / 12;
      const Vec3d forward{std::sin(yaw), -0.12, std::cos(yaw)};
      const Camera trial = look(eye, forward, 0.6);
      double openness = 0;
      int near = 0;
      constexpr int kSide = 5;
      for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
          const double x = (2.0 * i / (kSide - 1) - 1) * 1.5 * trial.half_height;
          const double y = (2.0 * j / (kSide - 1) - 1) * trial.half_height;
          const double depth = bounded(
              diagonal, static_cast<double>(depth_along(
                            p, eye, normalized(trial.forward + trial.right * x + trial.up * y))));
          openness += std::log(depth / diagonal + 1e-3);
          near += depth < 0.03 * diagonal ? 1 : 0;
        }
      }
      const double score = std::exp(openness / (kSide * kSide)) / (1.0 + near);
      if (score > best) {
        best = score;
        camera = trial;
      }
    }
  }
  return best > 0 && 2 * roofed > eyes.size();
}

/// The first perspective camera of the default scene's nodes would need the node's transform; it is
/// looked for by walking the document's node tree.
bool find_authored(const Prepared& p, Camera& camera) {
  const gltf::Json& json = p.document.json;
  if (!json.contains("cameras") || !json.contains("nodes") || !json.contains("scenes"))
    return false;
  const std::size_t scene = json.value("scene", 0u);
  struct Entry {
    std::size_t node;
    Affine to_world;
  };
  std::vector<Entry> stack;
  for (const auto& root : json["scenes"][scene].value("nodes", gltf::Json::array())) {
    stack.push_back({root.get<std::size_t>(), Affine{}});
  }
  while (!stack.empty()) {
    Entry entry = stack.back();
    stack.pop_back();
    const gltf::Json& node = json["nodes"][entry.node];
    Affine local;
    if (node.contains("matrix")) {
      local = Affine::from_column_major(node["matrix"].get<std::array<double, 16>>());
    } else {
      const auto t = node.value("translation", std::array<double, 3>{0, 0, 0});
      const auto s = node.value("scale", std::array<double, 3>{1, 1, 1});
      local = Affine::from_trs({t[0], t[1], t[2]},
                               node.value("rotation", std::array<double, 4>{0, 0, 0, 1}),
                               {s[0], s[1], s[2]});
    }
    const Affine to_world = entry.to_world * local;
    if (node.contains("camera")) {
      const gltf::Json& c = json["cameras"][node["camera"].get<std::size_t>()];
      if (c.contains("perspective")) {
        const double yfov = c["perspective"].value("yfov", 0.9);
        camera = look(to_world.t - p.scene->origin, -to_world.z, std::tan(0.5 * yfov));
        return true;
      }
    }
    for (const auto& child : node.value("children", gltf::Json::array())) {
      stack.push_back({child.get<std::size_t>(), to_world});
    }
  }
  return false;
}

Camera choose(const Prepared& p) {
  Camera camera;
  if (find_authored(p, camera) || find_inside(p, camera)) return camera;
  const Vec3d centre = to_double(p.scene->box.centre());
  const double reach = 0.62 * static_cast<double>(p.scene->box.diagonal());
  const Vec3d away = normalized(Vec3d{0.6, 0.55, 0.75});
  return look(centre + away * (reach / 0.55), -away, 0.5);
}

/// surface: whether the ray met any.
Rgb shade(const Prepared& p, const atlas::Layout& layout,
          const std::vector<lightmap::PageImage>& pages, const Vec3d& eye, const Vec3d& direction,
          bool& surface) {
  Rgb colour{}, weight{1, 1, 1};
  rays::Ray ray{to_float(eye), to_float(direction)};
  std::uint32_t exclude = rays::kNoTriangle;
  for (int sheets = 0; sheets < 16; ++sheets) {
    optics::ClosestFilter filter(*p.optics);
    const rays::Hit hit = p.caster->closest(ray, exclude, &filter);
    if (!hit.found()) return colour + weight * p.whole_sky.radiance(to_float(direction));
    surface = true;
    if (!hit.back || p.optics->double_sided(hit.triangle)) {
      const scene::Material& m = p.scene->material_of(hit.triangle);
      const Rgb rho = p.optics->reflectance(hit.triangle, hit.u, hit.v);
      const Rgb light = m.unlit
                            ? Rgb::grey(kPi)
                            : lightmap::irradiance_at(layout, pages, hit.triangle, hit.u, hit.v);
      colour += weight * (rho * light / kPi + p.optics->emission(hit.triangle, hit.u, hit.v));
    }
    if (!p.optics->sheet(hit.triangle)) return colour;
    weight *= p.optics->transmittance(hit.triangle, hit.u, hit.v);
    exclude = hit.triangle;
    ray.t_min = hit.t;
  }
  return colour;
}

/// Filmic curve (Narkowicz 2015, ACES approximation) after exposure.
float tone(float v) {
  v = std::max(0.0f, v);
  return std::clamp(v * (2.51f * v + 0.03f) / (v * (2.43f * v + 0.59f) + 0.14f), 0.0f, 1.0f);
}

}  // namespace

image::Image8 view_picture(const Prepared& p, const atlas::Layout& layout,
                           const std::vector<lightmap::PageImage>& pages, int width, int height) {
  const Camera camera = choose(p);
  const double aspect = static_cast<double>(width) / height;
  image::ImageRgb picture(width, height);
  std::vector<std::uint8_t> surface(picture.pixels.size(), 0);
  constexpr int kSamples = 4;
  parallel_for(static_cast<std::size_t>(height), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y) {
      for (int x = 0; x < width; ++x) {
        Rgbd sum;
        bool met = false;
        for (int s = 0; s < kSamples; ++s) {
          const double dx = x + (s & 1 ? 0.625 : 0.125) + (s & 2 ? 0.25 : 0.0);
          const double dy = static_cast<double>(y) + (s & 2 ? 0.625 : 0.125) + (s & 1 ? 0.25 : 0.0);
          const double u = (2 * dx / width - 1) * aspect * camera.half_height;
          const double v = (1 - 2 * dy / height) * camera.half_height;
          sum +=
              to_double(shade(p, layout, pages, camera.eye,
                              normalized(camera.forward + camera.right * u + camera.up * v), met));
        }
        picture.at(x, static_cast<int>(y)) = to_float(sum / static_cast<double>(kSamples));
        surface[y * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = met ? 1 : 0;
      }
    }
  });
  // Exposure: half way (on a log scale) between the median and the bright tenth of the surfaces
  // maps to a light grey.
  std::vector<float> values;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const float l = luminance(picture.pixels[i]);
    if (surface[i] != 0 && l > 0) values.push_back(l);
  }
  float exposure = 1;
  if (!values.empty()) {
    std::sort(values.begin(), values.end());
    const float middle = values[values.size() / 2];
    const float bright = values[values.size() * 9 / 10];
    exposure = 0.4f / std::sqrt(middle * bright);
  }
  image::Image8 out{width, height, {}};
  out.rgba.resize(4 * picture.pixels.size());
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const Rgb c = picture.pixels[i] * exposure;
    const auto byte = [](float v) {
      return static_cast<std::uint8_t>(std::lround(255.0f * linear_to_srgb(tone(v))));
    };
    out.rgba[4 * i] = byte(c.r);
    out.rgba[4 * i + 1] = byte(c.g);
    out.rgba[4 * i + 2] = byte(c.b);
    out.rgba[4 * i + 3] = 255;
  }
  return out;
}

}  // namespace lightbatch::pipeline
