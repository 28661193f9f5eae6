#include "core/optics/optics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>

#include "core/base/parallel.h"
#include "core/optics/duplicates.h"
#include "core/optics/texture.h"

namespace lightbatch::optics {
namespace {

using scene::AlphaMode;
using scene::Material;
using scene::Scene;
using scene::TextureSlot;

Vec2f uv_at(const Scene& scene, const TextureSlot& slot, std::uint32_t triangle, float u, float v) {
  const std::vector<Vec2f>& set = slot.uv_set == 0 ? scene.uv0 : scene.uv1;
  if (set.empty()) return {};
  const auto& corner = scene.triangles[triangle].vertex;
  return set[corner[0]] * (1 - u - v) + set[corner[1]] * u + set[corner[2]] * v;
}

std::array<float, 4> sample(const Scene& scene, const TextureSlot& slot, std::uint32_t triangle,
                            float u, float v, bool srgb) {
  return sample_texture(*scene.images[slot.image], slot, uv_at(scene, slot, triangle, u, v), srgb);
}

/// The images' ranges, made once for each image that some material's slot uses.
class Ranges {
 public:
  explicit Ranges(const Scene& scene) : scene_(scene) {
    for (const Material& m : scene.materials) {
      for (const TextureSlot* slot : m.texture_slots()) {
        if (slot->present() && !ranges_.contains(slot->image)) {
          ranges_.emplace(slot->image, TextureRange(*scene.images[slot->image]));
        }
      }
    }
  }

  TextureRange::Range of(const TextureSlot& slot, std::uint32_t triangle) const {
    Vec2d lower{}, upper{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2d uv = transform_uv(
          slot, uv_at(scene_, slot, triangle, i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f));
      if (i == 0) {
        lower = upper = uv;
      } else {
        lower = {std::min(lower.x, uv.x), std::min(lower.y, uv.y)};
        upper = {std::max(upper.x, uv.x), std::max(upper.y, uv.y)};
      }
    }
    return ranges_.at(slot.image).over(slot, lower, upper);
  }

  bool varies(const TextureSlot& slot, std::uint32_t triangle, std::size_t first,
              std::size_t last) const {
    if (!slot.present()) return false;
    const TextureRange::Range range = of(slot, triangle);
    for (std::size_t c = first; c <= last; ++c) {
      if (range.lowest[c] != range.highest[c]) return true;
    }
    return false;
  }

 private:
  const Scene& scene_;
  std::map<std::uint32_t, TextureRange> ranges_;
};

bool all_zero(const TextureRange::Range& range) {
  return range.highest[0] == 0 && range.highest[1] == 0 && range.highest[2] == 0;
}

Rgb clamp_reflectance(const Rgb& c) {
  return {std::clamp(c.r, 0.0f, kMaxReflectance), std::clamp(c.g, 0.0f, kMaxReflectance),
          std::clamp(c.b, 0.0f, kMaxReflectance)};
}

/// COLOR_0 over a triangle.
struct ColorRange {
  bool white = true;
  bool varies = false;
  float lowest_alpha = 1, highest_alpha = 1;
  ColorRange(const Scene& scene, std::uint32_t triangle) {
    if (scene.colors.empty()) return;
    const auto& corner = scene.triangles[triangle].vertex;
    const scene::VertexColor& first = scene.colors[corner[0]];
    lowest_alpha = highest_alpha = first.alpha;
    for (const std::uint32_t v : corner) {
      const scene::VertexColor& color = scene.colors[v];
      white = white && color == scene::VertexColor{};
      varies = varies || !(color == first);
      lowest_alpha = std::min(lowest_alpha, color.alpha);
      highest_alpha = std::max(highest_alpha, color.alpha);
    }
  }
};

/// Reflectance needs more of a material than its constant factors.
bool textured(const Material& m) {
  return m.base_color_texture.present() || m.metallic_texture.present() ||
         m.transmission_texture.present() || m.diffuse_transmission_texture.present() ||
         m.diffuse_transmission_color_texture.present();
}

/// Alpha as coverage.
float covered(const Material& m, float alpha) {
  switch (m.alpha_mode) {
    case AlphaMode::kMask:
      return alpha >= m.alpha_cutoff ? 1.0f : 0.0f;
    case AlphaMode::kBlend:
      return std::clamp(alpha, 0.0f, 1.0f);
    case AlphaMode::kOpaque:
      break;
  }
  return 1;
}

struct Classes {
  std::uint8_t flags = 0;
  rays::Surface surface = rays::Surface::kOpaque;
};

}  // namespace

/// Everything about one point of a triangle that scattering and transmission need.
struct Optics::Point {
  Rgb base_color;
  float alpha;
  float dielectric;    // 1 - metallic
  float transmission;  // of what is there (alpha aside)
  float diffuse;       // of what is left: transmitted diffusely
  float coverage() const { return alpha * (1 - transmission); }
  Rgb transmittance() const {
    return Rgb::grey(1 - alpha) +
           base_color * (alpha * std::clamp(transmission, 0.0f, 1.0f) * dielectric);
  }
  Rgb reflectance() const { return clamp_reflectance(base_color * (dielectric * (1 - diffuse))); }
};

bool Optics::varying(const Material& m, std::uint32_t triangle) const {
  return textured(m) || (flags_[triangle] & kVertexColor) != 0;
}

Optics::Point Optics::factors(const Material& m) {
  return {m.base_color, m.alpha, 1.0f - m.metallic, m.transmission, m.diffuse_transmission};
}

Optics::Point Optics::point(const Material& m, std::uint32_t triangle, float u, float v) const {
  Point p = factors(m);
  if (flags_[triangle] & kVertexColor) {
    const auto& corner = scene_->triangles[triangle].vertex;
    const auto& colors = scene_->colors;
    const float w[3] = {1 - u - v, u, v};
    Rgb rgb;
    float alpha = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      rgb += colors[corner[i]].rgb * w[i];
      alpha += colors[corner[i]].alpha * w[i];
    }
    p.base_color *= rgb;
    p.alpha *= alpha;
  }
  if (m.base_color_texture.present()) {
    const auto texel = sample(*scene_, m.base_color_texture, triangle, u, v, true);
    p.base_color *= Rgb{texel[0], texel[1], texel[2]};
    p.alpha *= texel[3];
  }
  if (m.metallic_texture.present()) {
    p.dielectric =
        1.0f - m.metallic * sample(*scene_, m.metallic_texture, triangle, u, v, false)[2];
  }
  if (m.transmission_texture.present() && m.transmission > 0) {
    p.transmission *= sample(*scene_, m.transmission_texture, triangle, u, v, false)[0];
  }
  if (m.diffuse_transmission_texture.present() && m.diffuse_transmission > 0) {
    p.diffuse *= sample(*scene_, m.diffuse_transmission_texture, triangle, u, v, false)[3];
  }
  p.alpha = covered(m, p.alpha);
  return p;
}

Optics::Optics(const Scene& scene, const Options& options) : scene_(&scene) {
  const Ranges ranges(scene);
  const std::size_t count = scene.triangles.size();
  flags_.resize(count);
  surfaces_.resize(count);
  for (const Material& m : scene.materials) {
    Point p = factors(m);
    p.alpha = covered(m, p.alpha);
    constant_.push_back(
        scattered_by(p, options.diffuse_transmission ? m.diffuse_transmission_color : Rgb{}));
  }
  parallel_for(count, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto triangle = static_cast<std::uint32_t>(i);
      const Material& m = scene.material_of(triangle);
      Classes c;
      if (m.double_sided && options.two_sided) c.flags |= kDoubleSided;
      if (options.diffuse_transmission && m.diffuse_transmission > 0 && m.metallic < 1 &&
          !m.diffuse_transmission_color.is_black()) {
        c.flags |= kDiffuse;
      }
      if (!m.emission.is_black() &&
          (!m.emission_texture.present() || !all_zero(ranges.of(m.emission_texture, triangle)))) {
        c.flags |= kEmits;
        if (options.textured_emission && ranges.varies(m.emission_texture, triangle, 0, 2)) {
          c.flags |= kTexturedEmission;
        }
      }
      const bool alpha_counts = m.alpha_mode != AlphaMode::kOpaque;
      const ColorRange color(scene, triangle);
      if (!color.white) c.flags |= kVertexColor;
      if (options.textured_reflectance &&
          (color.varies || ranges.varies(m.base_color_texture, triangle, 0, alpha_counts ? 3 : 2) ||
           ranges.varies(m.metallic_texture, triangle, 2, 2) ||
           ranges.varies(m.transmission_texture, triangle, 0, 0) ||
           ranges.varies(m.diffuse_transmission_texture, triangle, 3, 3) ||
           ranges.varies(m.diffuse_transmission_color_texture, triangle, 0, 2))) {
        c.flags |= kTexturedReflectance;
      }
      float low = m.alpha * color.lowest_alpha, high = m.alpha * color.highest_alpha;
      if (alpha_counts && m.base_color_texture.present()) {
        const auto range = ranges.of(m.base_color_texture, triangle);
        low *= static_cast<float>(range.lowest[3]) / 255.0f;
        high *= static_cast<float>(range.highest[3]) / 255.0f;
      }
      if (m.alpha_mode == AlphaMode::kMask && options.alpha_cutout) {
        if (high < m.alpha_cutoff) {
          c.surface = rays::Surface::kClear;
        } else if (low < m.alpha_cutoff) {
          c.surface = rays::Surface::kFiltered;
          c.flags |= kMask;
        }
      } else if (m.alpha_mode == AlphaMode::kBlend && options.alpha_blend && low < 1.0f) {
        if (high <= 0.0f) {
          c.surface = rays::Surface::kClear;
        } else {
          c.surface = rays::Surface::kFiltered;
          c.flags |= kSheet;
        }
      }
      if (m.transmission > 0 && options.transmission && c.surface != rays::Surface::kClear) {
        c.surface = rays::Surface::kFiltered;
        c.flags |= kSheet;
      }
      if (c.surface == rays::Surface::kClear) {
        c.flags = static_cast<std::uint8_t>(c.flags & ~(kEmits | kTexturedEmission));
      } else if ((c.flags & kEmits) && options.textured_emission &&
                 ((c.flags & kMask) || (alpha_counts && (c.flags & kSheet) && low != high))) {
        c.flags |= kTexturedEmission;  // its coverage varies
      }
      flags_[i] = c.flags;
      surfaces_[i] = c.surface;
    }
  });
  for (const std::uint8_t flags : flags_) diffuse_ = diffuse_ || (flags & kDiffuse) != 0;
  for (const rays::Surface surface : surfaces_) ++counts_[static_cast<std::size_t>(surface)];
  // A lamp modelled twice at one place shines once.
  std::vector<std::uint32_t> lamps;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (emits(i) && surfaces_[i] == rays::Surface::kOpaque) lamps.push_back(i);
  }
  for (const std::uint32_t i : hidden_duplicates(scene, lamps)) {
    flags_[i] = static_cast<std::uint8_t>(flags_[i] & ~(kEmits | kTexturedEmission));
  }
}

Optics::Scatterer Optics::scattered_by(const Point& p, const Rgb& transmission_color) {
  const Rgb rho = p.reflectance();
  const Rgb tau = transmission_color * (p.dielectric * p.diffuse);
  const auto left = [](float t, float r) { return std::clamp(t, 0.0f, kMaxReflectance - r); };
  return {p.coverage(),
          rho,
          {left(tau.r, rho.r), left(tau.g, rho.g), left(tau.b, rho.b)},
          p.transmittance()};
}

Optics::Scatterer Optics::scatterer(std::uint32_t triangle, float u, float v) const {
  const std::uint32_t material = scene_->objects[scene_->triangles[triangle].object].material;
  const Material& m = scene_->materials[material];
  Scatterer s = constant_[material];
  if (varying(m, triangle)) {
    Rgb color;
    if (transmits_diffusely(triangle)) {
      color = m.diffuse_transmission_color;
      if (m.diffuse_transmission_color_texture.present()) {
        const auto texel =
            sample(*scene_, m.diffuse_transmission_color_texture, triangle, u, v, true);
        color *= Rgb{texel[0], texel[1], texel[2]};
      }
    }
    s = scattered_by(point(m, triangle, u, v), color);
  }
  if (surfaces_[triangle] == rays::Surface::kOpaque) {
    s.coverage = 1;
    s.transmittance = {};
  }
  return s;
}

Rgb Optics::reflectance(std::uint32_t triangle, float u, float v) const {
  const Scatterer s = scatterer(triangle, u, v);
  return s.reflectance * s.coverage;
}

Rgb Optics::diffuse_transmittance(std::uint32_t triangle, float u, float v) const {
  if (!transmits_diffusely(triangle)) return {};
  const Scatterer s = scatterer(triangle, u, v);
  return s.diffuse_transmittance * s.coverage;
}

Rgb Optics::emission(std::uint32_t triangle, float u, float v) const {
  if (!emits(triangle)) return {};
  const Material& m = scene_->material_of(triangle);
  Rgb value = m.emission;
  if (m.emission_texture.present()) {
    const auto texel = sample(*scene_, m.emission_texture, triangle, u, v, true);
    value *= Rgb{texel[0], texel[1], texel[2]};
  }
  // What is cut away or fades shines as much less.
  return covered_in_part(triangle) ? value * point(m, triangle, u, v).alpha : value;
}

bool Optics::covered_in_part(std::uint32_t triangle) const {
  return surfaces_[triangle] == rays::Surface::kFiltered &&
         scene_->material_of(triangle).alpha_mode != AlphaMode::kOpaque;
}

double Optics::emission_texels(std::uint32_t triangle) const {
  const Material& m = scene_->material_of(triangle);
  double most = covered_in_part(triangle) && (flags_[triangle] & kVertexColor) ? 1 : 0;
  const auto count = [&](const TextureSlot& slot) {
    if (!slot.present()) return;
    const auto at = [&](float u, float v) {
      return transform_uv(slot, uv_at(*scene_, slot, triangle, u, v));
    };
    const image::Image8& image = *scene_->images[slot.image];
    const auto texels = [&](const Vec2d& from, const Vec2d& to) {
      return Vec2d{(to.x - from.x) * image.width, (to.y - from.y) * image.height};
    };
    const Vec2d a = at(0, 0), b = at(1, 0), c = at(0, 1);
    const Vec2d ab = texels(a, b), ac = texels(a, c), bc = texels(b, c);
    // Coordinates may run along a line.
    const double along = std::max({std::fabs(ab.x), std::fabs(ab.y), std::fabs(ac.x),
                                   std::fabs(ac.y), std::fabs(bc.x), std::fabs(bc.y)});
    most = std::max({most, std::fabs(cross(ab, ac)) / 2, along});
  };
  count(m.emission_texture);
  if (covered_in_part(triangle)) count(m.base_color_texture);
  return most;
}

Rgb Optics::transmittance(std::uint32_t triangle, float u, float v) const {
  if (surfaces_[triangle] == rays::Surface::kOpaque) return {};
  if (surfaces_[triangle] == rays::Surface::kClear) return {1, 1, 1};
  return point(scene_->material_of(triangle), triangle, u, v).transmittance();
}

bool ClosestFilter::stops(const rays::Hit& hit) {
  ++asked_;
  if (optics_.sheet(hit.triangle)) return true;
  return optics_.transmittance(hit.triangle, hit.u, hit.v).is_black();
}

bool ShadowFilter::stops(const rays::Hit& hit) {
  ++asked_;
  // Watertight tests report an edge to both of its triangles.
  constexpr float kOnEdge = 1e-5f;
  if (std::min({hit.u, hit.v, 1.0f - hit.u - hit.v}) < kOnEdge) {
    const std::uint32_t object = optics_.scene().triangles[hit.triangle].object;
    for (std::size_t i = 0; i < edge_count_; ++i) {
      if (edges_[i].object == object && std::fabs(edges_[i].t - hit.t) <= 4e-6f * hit.t) {
        return false;
      }
    }
    edges_[edge_count_ < kRemembered ? edge_count_++ : kRemembered - 1] = {object, hit.t};
  }
  transmittance_ *= optics_.transmittance(hit.triangle, hit.u, hit.v);
  return transmittance_.is_black();
}

}  // namespace lightbatch::optics
