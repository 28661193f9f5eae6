#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/radiosity/linked_rays.h"
#include "core/radiosity/linked_refine.h"
#include "core/radiosity/linked_tree.h"

namespace lightbatch::radiosity {

/// The operator K of the linked mode: irradiance of every element from the radiosity of all, by far
/// links over the tree and by cosine rays in the near field. Each row is scaled so that it sums to
/// the share of the element's rays that meet elements: without that, reflectance near 1 diverges.
class Transport {
 public:
  /// Marks the near field in `rays`, sorts the links by receiver, measures the rows.
  Transport(const LinkTree& tree, std::span<const Link> links, CosineRays& rays);

  std::vector<Rgb> apply(const std::vector<Rgb>& radiosity) const;
  std::size_t memory_bytes() const;
  std::uint64_t far_links() const { return links_.size(); }

 private:
  void gather(const LinkTree::Outgoing& out, LinkTree::Incoming& in) const;
  void receive(const Link& link, const LinkTree::Outgoing& out, LinkTree::Incoming& in) const;
  void mark_near(const Link& link);

  const LinkTree* tree_;
  CosineRays* rays_;
  std::vector<Link> links_;               // far ones, by receiver
  std::vector<std::uint32_t> first_;      // of each run of one receiver, and one past
  std::vector<std::uint32_t> leaf_node_;  // by place in leaf order
  std::vector<float> far_scale_;          // per element: of what far links bring
  std::vector<float> ray_share_;          // per element: part of the far field left to its rays
};

}  // namespace lightbatch::radiosity
