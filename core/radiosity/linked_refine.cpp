// Refinement of links (Hanrahan, Salzman, Aupperle 1991; Smits, Arvo, Greenberg 1994), judged by
// how much the radiosity that a link carries may vary over receiver and source.
#include "core/radiosity/linked_refine.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/math/sampling.h"
#include "core/optics/surface_frame.h"

namespace lightbatch::radiosity {
namespace {

using Node = LinkTree::Node;

/// Beyond this many links nothing is refined any more; 16 bytes each with their places.
constexpr std::size_t kMaxLinks = 24'000'000;
constexpr std::size_t kLinksPerRound = 8192;
constexpr int kSightLines = 2;
/// Flat pairs closer than this many radii take their factor from point pairs, not from centres.
constexpr float kCloseRadii = 4;
constexpr int kClosePairs = 8;
/// The faces of a cluster that are seen lie on its near side, and a wide source is not all at its
/// centre: each sight line is weighted by what it exchanges over what its faces would exchange
/// centre to centre. Left out, a solid box comes out a third too dark.
constexpr float kMostPairGain = 4;

/// Dark sources are judged as if they sent this share of the mean radiosity besides: their links
/// bring no light, but they count in the row sums that all links are scaled to.
constexpr double kAmbientShare = 0.25;

double grey(const Rgb& c) { return static_cast<double>(c.sum()) / 3; }

double box_distance2(const Aabb& a, const Aabb& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double gap = std::max({0.0, static_cast<double>(a.lower[i] - b.upper[i]),
                                 static_cast<double>(b.lower[i] - a.upper[i])});
    sum += gap * gap;
  }
  return sum;
}

}  // namespace

/// Nothing of `other` lies in front of the plane of a flat node.
bool Refiner::behind(Node flat, Node other) const {
  const auto& shape = tree_.shape(flat);
  if (!shape.flat()) return false;
  const Aabb& box = tree_.tree().box(other);
  const Vec3f n = shape.normal;
  const Vec3f farthest{n.x > 0 ? box.upper.x : box.lower.x, n.y > 0 ? box.upper.y : box.lower.y,
                       n.z > 0 ? box.upper.z : box.lower.z};
  return dot(n, farthest - shape.centre) <= 1e-5f * (shape.radius + tree_.shape(other).radius);
}

Refiner::Judgement Refiner::judge(Node r, Node s, double threshold) const {
  const auto& receiver = tree_.shape(r);
  const auto& source = tree_.shape(s);
  const auto& nodes = tree_.tree();
  Judgement j;
  const double b = grey(radiosity_->radiosity[s]) + ambient_;
  if (r == s) {
    j.drop = receiver.flat();
    j.near = true;
    j.keep = nodes.is_leaf(r) || b * static_cast<double>(source.area) <= threshold;
    return j;
  }
  if (behind(r, s) || behind(s, r)) {
    j.drop = true;
    return j;
  }
  const Vec3f apart = source.centre - receiver.centre;
  const float d = length(apart);
  const double area_r = static_cast<double>(receiver.area);
  const double area_s = static_cast<double>(source.area);
  j.near = !(d > receiver.radius + source.radius);
  double error_r = 0, error_s = 0;
  if (j.near) {
    const double d2 = box_distance2(nodes.box(r), nodes.box(s));
    const double share = d2 > 0 ? std::min(1.0, area_s / (kPiDouble * d2)) : 1.0;
    const double flux = b * std::min(area_s, area_r * share);
    j.keep = flux <= threshold;
    error_r = static_cast<double>(receiver.radius);
    error_s = static_cast<double>(source.radius);
  } else {
    const Vec3f w = apart / d;
    const float x_r = receiver.radius / d, x_s = source.radius / d;
    const double from =
        static_cast<double>(tree_.projected_area(s, -w, sh_basis(-w)) + 0.3f * source.area * x_s);
    const double to =
        static_cast<double>(tree_.projected_area(r, w, sh_basis(w)) + 0.3f * receiver.area * x_r);
    const double geometry = from * to / (kPiDouble * static_cast<double>(d * d));
    error_r = b * geometry * static_cast<double>(x_r);
    error_s = geometry * static_cast<double>(x_s) *
              (b * static_cast<double>(x_s) + static_cast<double>(deviation_[s]));
    j.keep = error_r + error_s <= threshold;
  }
  const bool leaf_r = nodes.is_leaf(r), leaf_s = nodes.is_leaf(s);
  if (leaf_r && leaf_s) j.keep = true;
  j.split_receiver = leaf_s || (!leaf_r && error_r >= error_s);
  return j;
}

void Refiner::descend(const Link& link, double threshold, std::size_t room,
                      std::vector<Link>& out) const {
  const Judgement j = judge(link.receiver, link.source, threshold);
  if (j.drop) return;
  const auto& nodes = tree_.tree();
  const Node r = link.receiver, s = link.source;
  if (j.keep || out.size() >= room) {
    Link kept = link;
    if (j.near) kept.factor = Link::kNear;
    out.push_back(kept);
    return;
  }
  if (r == s) {
    const Node a = nodes.left(r), b = nodes.right(r);
    for (const Link& child : {Link{a, a}, Link{a, b}, Link{b, a}, Link{b, b}}) {
      descend(child, threshold, room, out);
    }
  } else if (j.split_receiver) {
    descend({nodes.left(r), s}, threshold, room, out);
    descend({nodes.right(r), s}, threshold, room, out);
  } else {
    descend({r, nodes.left(s)}, threshold, room, out);
    descend({r, nodes.right(s)}, threshold, room, out);
  }
}

struct Refiner::Point {
  optics::SurfaceFrame frame;
  std::uint32_t triangle = 0;
};

/// A point of the node, by projected area towards the other node and (sources) by radiosity.
Refiner::Point Refiner::pick(Node n, const Vec3f& towards, bool by_radiosity, double a, float b,
                             float c) const {
  const auto& nodes = tree_.tree();
  const Sh9 basis = tree_.shape(n).flat() ? Sh9{} : sh_basis(towards);
  while (!nodes.is_leaf(n)) {
    const auto weight = [&](Node child) {
      const double area = tree_.shape(n).flat()
                              ? static_cast<double>(tree_.shape(child).area)
                              : static_cast<double>(tree_.projected_area(child, towards, basis));
      return by_radiosity ? area * (grey(radiosity_->radiosity[child]) + ambient_) : area;
    };
    const Node left = nodes.left(n), right = nodes.right(n);
    const double first = weight(left), second = weight(right);
    const double share = first + second > 0 ? first / (first + second) : 0.5;
    if (a < share) {
      n = left;
      a /= share;
    } else {
      n = right;
      a = (a - share) / (1 - share);
    }
    a = std::clamp(a, 0.0, 0x1.fffffep-1);
  }
  const ElementId e = tree_.element(n);
  const ElementPoint p = input_.elements.point(e, b, c);
  return {optics::surface_frame(input_.scene, p.triangle, p.u, p.v, input_.elements.is_back(e),
                                input_.direct.lift()),
          p.triangle};
}

void Refiner::measure(Link& link, RayCounts& counts) const {
  const auto& receiver = tree_.shape(link.receiver);
  const auto& source = tree_.shape(link.source);
  const Vec3f apart = source.centre - receiver.centre;
  const float d = length(apart);
  const Vec3f w = apart / d;
  const bool flat = receiver.flat() && source.flat();
  const bool near_by = d < kCloseRadii * (receiver.radius + source.radius);
  const bool close = flat && near_by;
  const int lines = near_by ? kClosePairs : kSightLines;
  const std::uint64_t name =
      (static_cast<std::uint64_t>(link.receiver) << 32) | static_cast<std::uint64_t>(link.source);
  Random random(item_seed(options_.seed, name, 6));
  double open = 0, all = 0, transport = 0;
  for (int i = 0; i < lines; ++i) {
    // Stratified over the lines in the first number of each end.
    const double a = (i + random.next_double()) / lines;
    const double b = std::fmod((i * 2 + 1) * 0.5 / lines + random.next_double(), 1.0);
    const Point from = pick(link.source, -w, true, a, random.next_float(), random.next_float());
    const Point to = pick(link.receiver, w, false, b, random.next_float(), random.next_float());
    const Vec3f sight = from.frame.origin - to.frame.origin;
    const float d2 = dot(sight, sight);
    const float cos_to = dot(to.frame.normal, sight), cos_from = -dot(from.frame.normal, sight);
    if (!(cos_to > 0 && cos_from > 0 && d2 > 0)) {
      all += 1;
      continue;
    }
    all += 1;
    const rays::Ray ray{to.frame.origin, sight, 0, 1};
    double share = 1;
    ++counts.hemisphere;
    if (input_.optics.filtered_count() == 0) {
      share = input_.caster.occluded(ray, to.triangle, from.triangle) ? 0 : 1;
    } else {
      optics::ShadowFilter filter(input_.optics);
      share = input_.caster.occluded(ray, to.triangle, from.triangle, &filter)
                  ? 0
                  : grey(filter.transmittance());
      counts.alpha_lookups += filter.asked();
    }
    // How much more this pair exchanges than its faces would at the distance and in the direction
    // of the centres.
    const float size = std::sqrt(d2);
    const float turned_to = cos_to / size / std::max(0.1f, dot(to.frame.normal, w));
    const float turned_from = cos_from / size / std::max(0.1f, -dot(from.frame.normal, w));
    open +=
        share * static_cast<double>(std::min(kMostPairGain, d * d / d2 * turned_to * turned_from));
    transport += share * static_cast<double>(cos_to * cos_from / (d2 * d2));
  }
  if (close) {
    const double factor = transport / lines * static_cast<double>(source.area) / kPiDouble;
    link.factor = static_cast<float>(std::min(1.0, factor));
    return;
  }
  link.factor = all > 0 ? static_cast<float>(open / all) : 0.0f;
  if (!flat) return;
  const float cosines =
      std::max(0.0f, dot(receiver.normal, w)) * std::max(0.0f, -dot(source.normal, w));
  link.factor *= std::min(1.0f, source.area * cosines / (kPi * d * d));
}

void Refiner::measure_deviation() {
  const auto& nodes = tree_.tree();
  std::vector<double> squares(nodes.node_count());
  deviation_.resize(nodes.node_count());
  for (Node n = nodes.node_count(); n-- > 0;) {
    const double b = grey(radiosity_->radiosity[n]);
    if (nodes.is_leaf(n)) {
      squares[n] = b * b;
    } else {
      const double left = static_cast<double>(tree_.shape(nodes.left(n)).area);
      const double right = static_cast<double>(tree_.shape(nodes.right(n)).area);
      const double share = left + right > 0 ? left / (left + right) : 0.5;
      squares[n] = squares[nodes.left(n)] * share + squares[nodes.right(n)] * (1 - share);
    }
    deviation_[n] = static_cast<float>(std::sqrt(std::max(0.0, squares[n] - b * b)));
  }
}

void Refiner::refine(const LinkTree::Outgoing& radiosity, double threshold,
                     std::vector<Link>& links, RayCounts& counts, const Progress& progress) {
  radiosity_ = &radiosity;
  measure_deviation();
  ambient_ = links.empty() ? 0 : kAmbientShare * grey(radiosity.radiosity[0]);
  std::vector<Link> refined;
  std::size_t done = 0;
  constexpr std::size_t kGrain = 64;
  while (done < links.size() && refined.size() < kMaxLinks && !progress.cancelled()) {
    const std::size_t round = std::min(kLinksPerRound, links.size() - done);
    std::vector<std::vector<Link>> blocks((round + kGrain - 1) / kGrain);
    const std::size_t room = kMaxLinks / blocks.size();
    parallel_for(round, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
        descend(links[done + i], threshold, room, blocks[begin / kGrain]);
      }
    });
    for (const auto& block : blocks) refined.insert(refined.end(), block.begin(), block.end());
    done += round;
  }
  refined.insert(refined.end(), links.begin() + static_cast<std::ptrdiff_t>(done), links.end());
  links.swap(refined);

  constexpr std::size_t kMeasured = 1024;
  std::vector<RayCounts> partial((links.size() + kMeasured - 1) / kMeasured);
  parallel_for(links.size(), kMeasured, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
      Link& link = links[i];
      if (!link.measured() && !link.near()) measure(link, partial[begin / kMeasured]);
    }
  });
  for (const RayCounts& c : partial) counts += c;
}

}  // namespace lightbatch::radiosity
