#include "core/radiosity/linked_transport.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace lightbatch::radiosity {
namespace {

using Node = LinkTree::Node;

/// Far links are scaled up by this much at most; what is then missing comes by the rays.
constexpr float kMaxScale = 3;

}  // namespace

Transport::Transport(const LinkTree& tree, std::span<const Link> links, CosineRays& rays)
    : tree_(&tree), rays_(&rays) {
  const auto& nodes = tree.tree();
  leaf_node_.resize(nodes.primitive_count());
  for (Node n = 0; n < nodes.node_count(); ++n) {
    if (nodes.is_leaf(n)) leaf_node_[nodes.first(n)] = n;
  }
  std::fill(rays.near.begin(), rays.near.end(), std::uint8_t{0});
  for (const Link& link : links) {
    if (link.near()) {
      mark_near(link);
    } else if (link.factor > 0) {
      links_.push_back(link);
    }
  }
  std::stable_sort(links_.begin(), links_.end(),
                   [](const Link& a, const Link& b) { return a.receiver < b.receiver; });
  for (std::uint32_t i = 0; i < links_.size(); ++i) {
    if (i == 0 || links_[i].receiver != links_[i - 1].receiver) first_.push_back(i);
  }
  first_.push_back(static_cast<std::uint32_t>(links_.size()));

  // Rows: what unit radiosity brings, against what the rays say.
  const std::uint32_t count = nodes.primitive_count();
  far_scale_.assign(count, 1);
  ray_share_.assign(count, 0);
  LinkTree::Outgoing out;
  LinkTree::Incoming in;
  tree.pull(std::vector<Rgb>(count, Rgb{1, 1, 1}), out);
  gather(out, in);
  for (ElementId e = 0; e < count; ++e) {
    const float far = in.irradiance[leaf_node_[tree.place(e)]].g;
    const float wanted = std::max(0.0f, rays.met(e, false) - rays.met(e, true));
    far_scale_[e] = far > 0 ? std::min(kMaxScale, wanted / far) : 0;
    if (wanted > 0) ray_share_[e] = std::max(0.0f, 1 - far_scale_[e] * far / wanted);
    if (ray_share_[e] < 1e-5f) ray_share_[e] = 0;
  }
}

void Transport::mark_near(const Link& link) {
  const auto& nodes = tree_->tree();
  const std::uint32_t from = nodes.first(link.source), to = from + nodes.count(link.source);
  for (const std::uint32_t e : nodes.primitives(link.receiver)) {
    const auto begin = rays_->place.begin() + static_cast<std::ptrdiff_t>(rays_->start[e]);
    const auto end = rays_->place.begin() + static_cast<std::ptrdiff_t>(rays_->start[e + 1]);
    for (auto k = std::lower_bound(begin, end, from); k != end && *k < to; ++k) {
      rays_->near[static_cast<std::size_t>(k - rays_->place.begin())] = 1;
    }
  }
}

void Transport::receive(const Link& link, const LinkTree::Outgoing& out,
                        LinkTree::Incoming& in) const {
  const auto& receiver = tree_->shape(link.receiver);
  const auto& source = tree_->shape(link.source);
  if (receiver.flat() && source.flat()) {
    in.irradiance[link.receiver] += out.radiosity[link.source] * link.factor;
    return;
  }
  const Vec3f apart = source.centre - receiver.centre;
  const float d2 = dot(apart, apart);
  const Vec3f w = apart / std::sqrt(d2);
  const Sh9 basis = sh_basis(w);
  const float scale = link.factor / d2;
  Rgb flux;
  if (source.flat()) {
    flux = out.radiosity[link.source] *
           (scale * source.area * 0.318309886f * std::max(0.0f, -dot(source.normal, w)));
  } else {
    Sh9 back = basis;
    for (std::size_t i = 1; i < 4; ++i) back[i] = -back[i];
    const auto& h = out.harmonics[source.cluster];
    flux = {std::max(0.0f, sh_dot(h[0], back)) * scale, std::max(0.0f, sh_dot(h[1], back)) * scale,
            std::max(0.0f, sh_dot(h[2], back)) * scale};
  }
  if (receiver.flat()) {
    in.irradiance[link.receiver] += flux * std::max(0.0f, dot(receiver.normal, w));
    return;
  }
  auto& h = in.harmonics[receiver.cluster];
  for (std::size_t i = 0; i < 9; ++i) {
    h[0][i] += flux.r * basis[i];
    h[1][i] += flux.g * basis[i];
    h[2][i] += flux.b * basis[i];
  }
}

void Transport::gather(const LinkTree::Outgoing& out, LinkTree::Incoming& in) const {
  tree_->clear(in);
  parallel_for(first_.size() - 1, 256, [&](std::size_t begin, std::size_t end) {
    for (std::uint32_t i = first_[begin]; i < first_[end]; ++i) receive(links_[i], out, in);
  });
  tree_->push(in);
}

std::vector<Rgb> Transport::apply(const std::vector<Rgb>& radiosity) const {
  const auto& nodes = tree_->tree();
  LinkTree::Outgoing out;
  LinkTree::Incoming in;
  tree_->pull(radiosity, out);
  gather(out, in);
  std::vector<Rgb> irradiance(radiosity.size());
  parallel_for(radiosity.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto e = static_cast<ElementId>(i);
      Rgb sum;
      for (auto k = rays_->start[e]; k < rays_->start[e + 1]; ++k) {
        const float share = rays_->near[k] != 0 ? 1.0f : ray_share_[e];
        if (share == 0) continue;
        const Rgb& b = radiosity[nodes.primitive(rays_->place[k])];
        sum += rays_->weight.empty() ? b * share : b * rays_->weight[k] * share;
      }
      irradiance[e] =
          sum * rays_->scale[e] + in.irradiance[leaf_node_[tree_->place(e)]] * far_scale_[e];
    }
  });
  return irradiance;
}

std::size_t Transport::memory_bytes() const {
  return links_.capacity() * sizeof(Link) + first_.capacity() * 4 + leaf_node_.capacity() * 4 +
         far_scale_.capacity() * 8;
}

}  // namespace lightbatch::radiosity
