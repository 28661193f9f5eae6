// Directional clusters for hierarchical radiosity (Smits, Arvo, Greenberg 1994; Sillion, Drettakis,
// Soler 1995). Deviation: order-2 harmonics of projected area and intensity, summed up the tree,
// instead of pushing every link to every leaf; a collection of faces on one plane stays exact.
#include "core/radiosity/linked_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/optics/surface_frame.h"

namespace lightbatch::radiosity {
namespace {

constexpr int kLeafSamples = 4;  // along each side of an element
/// Normals this close, and heights this small against the radius, count as one plane.
constexpr float kSameNormal = 0.9999f;
constexpr float kSameHeight = 0.01f;

struct LeafSamples {
  Aabb box;
  Vec3d centre;
  Vec3d normal;  // mean, not unit
};

LeafSamples sample_leaf(const SolverInput& input, ElementId e) {
  LeafSamples s;
  int count = 0;
  const auto add = [&](const ElementPoint& p, double weight) {
    const auto frame =
        optics::surface_frame(input.scene, p.triangle, p.u, p.v, input.elements.is_back(e), 0);
    s.box.add(frame.position);
    s.centre += to_double(frame.position) * weight;
    s.normal += to_double(frame.normal) * weight;
  };
  for (int i = 0; i < kLeafSamples; ++i) {
    for (int j = 0; j < kLeafSamples; ++j, ++count) {
      add(input.elements.point(e, (static_cast<float>(i) + 0.5f) / kLeafSamples,
                               (static_cast<float>(j) + 0.5f) / kLeafSamples),
          1.0 / (kLeafSamples * kLeafSamples));
    }
  }
  for (const std::uint32_t triangle : input.elements.group(e)) {
    for (const Vec3f& corner : input.scene.corners(triangle)) s.box.add(corner);
  }
  return s;
}

Sh9 scaled_lobe(const Vec3f& normal, float area) {
  Sh9 lobe = sh_cosine_lobe(normal);
  for (float& c : lobe) c *= area;
  return lobe;
}

void add_scaled(Sh9& to, const Sh9& from, float scale) {
  for (std::size_t i = 0; i < 9; ++i) to[i] += from[i] * scale;
}

}  // namespace

LinkTree::LinkTree(const SolverInput& input) : place_(input.elements.count()) {
  const std::uint32_t count = input.elements.count();
  std::vector<Aabb> boxes(count);
  std::vector<LeafSamples> samples(count);
  for (ElementId e = 0; e < count; ++e) {
    samples[e] = sample_leaf(input, e);
    boxes[e] = samples[e].box;
  }
  tree_ = hierarchy::build(boxes);
  shapes_.resize(tree_.node_count());
  for (std::uint32_t k = 0; k < count; ++k) place_[tree_.primitive(k)] = k;
  for (Node n = tree_.node_count(); n-- > 0;) {
    Shape& shape = shapes_[n];
    shape.radius = 0.5f * tree_.box(n).diagonal();
    if (tree_.is_leaf(n)) {
      const ElementId e = element(n);
      shape.area = input.elements.covered_area(e);
      shape.centre = to_float(samples[e].centre);
      shape.normal = to_float(normalized(samples[e].normal));
      const bool group = input.elements.group(e).size() > 1;
      if (group && length(samples[e].normal) < static_cast<double>(kSameNormal)) {
        Sh9 mono{};
        shape_leaf(input, n, mono);
        shape.cluster = static_cast<std::uint32_t>(mono_.size());
        mono_.push_back(mono);
      }
      continue;
    }
    const Shape& a = shapes_[tree_.left(n)];
    const Shape& b = shapes_[tree_.right(n)];
    shape.area = a.area + b.area;
    const float share = shape.area > 0 ? a.area / shape.area : 0.5f;
    shape.centre = a.centre * share + b.centre * (1 - share);
    const float height = std::fabs(dot(a.normal, b.centre - a.centre));
    if (a.flat() && b.flat() && dot(a.normal, b.normal) > kSameNormal &&
        height <= kSameHeight * shape.radius) {
      shape.normal = normalized(a.normal * share + b.normal * (1 - share));
      continue;
    }
    Sh9 mono{};
    for (const Shape* child : {&a, &b}) {
      add_scaled(
          mono, child->flat() ? scaled_lobe(child->normal, child->area) : mono_[child->cluster], 1);
    }
    shape.cluster = static_cast<std::uint32_t>(mono_.size());
    mono_.push_back(mono);
  }
}

void LinkTree::shape_leaf(const SolverInput& input, Node n, Sh9& mono) {
  const ElementId e = element(n);
  double whole = 0;
  Sh9 lobes{};
  for (const std::uint32_t triangle : input.elements.group(e)) {
    const auto frame = optics::surface_frame(input.scene, triangle, 1 / 3.0f, 1 / 3.0f,
                                             input.elements.is_back(e), 0);
    const auto c = input.scene.corners(triangle);
    const float area = 0.5f * length(cross(c[1] - c[0], c[2] - c[0]));
    add_scaled(lobes, sh_cosine_lobe(frame.normal), area);
    whole += static_cast<double>(area);
  }
  // Without its holes.
  if (whole > 0) {
    add_scaled(mono, lobes, input.elements.covered_area(e) / static_cast<float>(whole));
  }
}

float LinkTree::projected_area(Node n, const Vec3f& direction, const Sh9& basis) const {
  const Shape& s = shapes_[n];
  if (s.flat()) return s.area * std::max(0.0f, dot(s.normal, direction));
  return std::max(0.0f, sh_dot(mono_[s.cluster], basis));
}

void LinkTree::pull(const std::vector<Rgb>& element_radiosity, Outgoing& out) const {
  out.radiosity.resize(tree_.node_count());
  out.harmonics.resize(mono_.size());
  constexpr float kPerSteradian = 0.318309886f;
  for (Node n = tree_.node_count(); n-- > 0;) {
    const Shape& s = shapes_[n];
    if (tree_.is_leaf(n)) {
      const Rgb b = element_radiosity[element(n)];
      out.radiosity[n] = b;
      if (s.flat()) continue;
      auto& h = out.harmonics[s.cluster];
      h = {};
      add_scaled(h[0], mono_[s.cluster], b.r * kPerSteradian);
      add_scaled(h[1], mono_[s.cluster], b.g * kPerSteradian);
      add_scaled(h[2], mono_[s.cluster], b.b * kPerSteradian);
      continue;
    }
    const Node left = tree_.left(n), right = tree_.right(n);
    const float area = shapes_[left].area + shapes_[right].area;
    const float share = area > 0 ? shapes_[left].area / area : 0.5f;
    out.radiosity[n] = out.radiosity[left] * share + out.radiosity[right] * (1 - share);
    if (s.flat()) continue;
    auto& h = out.harmonics[s.cluster];
    h = {};
    for (const Node child : {left, right}) {
      const Shape& c = shapes_[child];
      if (c.flat()) {
        const Sh9 lobe = scaled_lobe(c.normal, c.area * kPerSteradian);
        add_scaled(h[0], lobe, out.radiosity[child].r);
        add_scaled(h[1], lobe, out.radiosity[child].g);
        add_scaled(h[2], lobe, out.radiosity[child].b);
      } else {
        for (std::size_t k = 0; k < 3; ++k) add_scaled(h[k], out.harmonics[c.cluster][k], 1);
      }
    }
  }
}

void LinkTree::clear(Incoming& in) const {
  in.irradiance.assign(tree_.node_count(), Rgb{});
  in.harmonics.assign(mono_.size(), {});
}

void LinkTree::push(Incoming& in) const {
  for (Node n = 0; n < tree_.node_count(); ++n) {
    const Shape& s = shapes_[n];
    if (tree_.is_leaf(n)) {
      if (s.flat() || !(s.area > 0)) continue;
      const auto& h = in.harmonics[s.cluster];
      const Sh9& mono = mono_[s.cluster];
      in.irradiance[n] +=
          Rgb{std::max(0.0f, sh_dot(h[0], mono)), std::max(0.0f, sh_dot(h[1], mono)),
              std::max(0.0f, sh_dot(h[2], mono))} /
          s.area;
      continue;
    }
    for (const Node child : {tree_.left(n), tree_.right(n)}) {
      const Shape& c = shapes_[child];
      in.irradiance[child] += in.irradiance[n];
      if (s.flat()) continue;
      const auto& h = in.harmonics[s.cluster];
      if (c.flat()) {
        const Sh9 lobe = sh_cosine_lobe(c.normal);
        in.irradiance[child] +=
            Rgb{std::max(0.0f, sh_dot(h[0], lobe)), std::max(0.0f, sh_dot(h[1], lobe)),
                std::max(0.0f, sh_dot(h[2], lobe))};
      } else {
        for (std::size_t k = 0; k < 3; ++k) add_scaled(in.harmonics[c.cluster][k], h[k], 1);
      }
    }
  }
}

std::size_t LinkTree::memory_bytes() const {
  return shapes_.capacity() * sizeof(Shape) + mono_.capacity() * sizeof(Sh9) * 7 +
         tree_.node_count() * 40ull;
}

}  // namespace lightbatch::radiosity
