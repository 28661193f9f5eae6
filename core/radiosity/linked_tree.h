#pragma once

#include <cstdint>
#include <vector>

#include "core/hierarchy/hierarchy.h"
#include "core/math/rgb.h"
#include "core/math/sh.h"
#include "core/radiosity/elements.h"
#include "core/radiosity/solver.h"

namespace lightbatch::radiosity {

/// Clusters of the linked mode: a hierarchy over the elements (the product's own builder), with
/// what a link needs to know of each node. Leaves are elements in leaf order.
///
/// A node is flat when its elements lie on the same side of one plane: it sends and receives by a
/// cosine. Other nodes send and receive by spherical harmonics of order 2 (Sillion 1995; the same
/// coefficients on both sides, so a link and its reverse carry the same power).
class LinkTree {
 public:
  using Node = hierarchy::Hierarchy::NodeId;

  struct Shape {
    Vec3f centre;  // by area
    float radius = 0;
    float area = 0;
    Vec3f normal;                   // flat nodes
    std::uint32_t cluster = kFlat;  // index of its harmonics, or kFlat
    bool flat() const { return cluster == kFlat; }
  };
  static constexpr std::uint32_t kFlat = 0xffffffffu;

  explicit LinkTree(const SolverInput& input);

  const hierarchy::Hierarchy& tree() const { return tree_; }
  const Shape& shape(Node n) const { return shapes_[n]; }
  /// Projected area towards a unit direction, occlusion inside left out.
  float projected_area(Node n, const Vec3f& direction, const Sh9& basis) const;
  /// The element of a leaf.
  ElementId element(Node leaf) const { return tree_.primitive(tree_.first(leaf)); }
  /// Place of an element in leaf order.
  std::uint32_t place(ElementId e) const { return place_[e]; }
  std::size_t cluster_count() const { return mono_.size(); }
  std::size_t memory_bytes() const;

  /// What nodes send out: mean radiosity of flat nodes, harmonics of intensity of the others.
  struct Outgoing {
    std::vector<Rgb> radiosity;                 // per node: mean over its area
    std::vector<std::array<Sh9, 3>> harmonics;  // per cluster: cd per direction, by channel
  };
  /// From the radiosity of the elements.
  void pull(const std::vector<Rgb>& element_radiosity, Outgoing& out) const;

  /// What nodes receive: irradiance of flat nodes, harmonics of incoming flux of the others.
  struct Incoming {
    std::vector<Rgb> irradiance;
    std::vector<std::array<Sh9, 3>> harmonics;
  };
  void clear(Incoming& in) const;
  /// Hands everything down to the leaves; `irradiance` of leaves is then the sum of all levels.
  void push(Incoming& in) const;

 private:
  void shape_leaf(const SolverInput& input, Node n, Sh9& mono);

  hierarchy::Hierarchy tree_;
  std::vector<std::uint32_t> place_;
  std::vector<Shape> shapes_;
  std::vector<Sh9> mono_;  // per cluster: projected area by direction
};

}  // namespace lightbatch::radiosity
