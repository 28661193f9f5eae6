// Light between texels that stand close to each other, as in corners and between furniture: every
// ray that lands near is a link to the texel there, and all texels are solved together. It is the
// stored-ray mode of the first stage (Keller 1996, Quasi-Monte Carlo Radiosity, with the hits kept)
// at the texels' own size: a texel there has the rays of all its neighbours behind it, where a
// further gather would follow one.

#include "core/lightmap/near_links.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"
#include "core/lightmap/neighbours.h"
#include "core/lightmap/texel_points.h"

namespace lightbatch::lightmap {
namespace {

/// Cosine between the normals of points on one plane.
constexpr float kOnePlane = 0.999f;
/// Of a curved surface, between two points of it.
constexpr int kMostMet = 8;

}  // namespace

NearTexels::NearTexels(const BakeInput& input, double nearest)
    : input_(input),
      nearest_(static_cast<float>(nearest)),
      whole_(input.texels.texels.size()),
      size_(input.texels.texels.size()),
      first_(size_.size()) {
  const auto& indirect = input.solution.indirect;
  if (indirect.empty()) return;
  parallel_for(first_.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      size_[t] = static_cast<float>(std::sqrt(input.texels.surface_of(input.texels.texels[t])));
      const TexelPoints::Point p = central_point(input.texels, input.texels.texels[t]);
      const atlas::SurfacePoint at = surface_point(input.layout, p);
      const radiosity::ElementId e = input.elements.at(at.triangle, at.u, at.v, p.back);
      if (e != radiosity::kNoElement) first_[t] = indirect[e];
    }
  });
}

std::uint32_t NearTexels::at(const rays::Hit& hit, float distance, float size) const {
  const std::uint32_t chart = input_.layout.chart_of[hit.triangle];
  if (chart == scene::kNone || hit.back != input_.texels.is_back(chart)) return scene::kNone;
  const auto& uv = input_.layout.uv[hit.triangle];
  const Vec2f at = uv[0] * (1 - hit.u - hit.v) + uv[1] * hit.u + uv[2] * hit.v;
  const atlas::Page& page = input_.layout.pages[input_.layout.charts[chart].page];
  const std::uint32_t t = texel_at(input_.texels, input_.layout, chart,
                                   std::clamp(static_cast<int>(at.x), 0, page.width - 1),
                                   std::clamp(static_cast<int>(at.y), 0, page.height - 1));
  const bool usable = t != scene::kNone && size_[t] < size && distance >= nearest_ * size_[t];
  if (!usable) return scene::kNone;
  std::uint8_t whole = whole_[t].load(std::memory_order_relaxed);
  if (whole == kNotAsked) {
    whole = is_whole(t) ? kYes : kNo;
    whole_[t].store(whole, std::memory_order_relaxed);
  }
  return whole == kYes ? t : scene::kNone;
}

bool NearTexels::is_whole(std::uint32_t texel) const {
  const TexelPoints points = texel_points(input_.texels, input_.texels.texels[texel]);
  const bool back = points.point[0].back;
  const auto place = [&](std::uint32_t i) {
    const auto& p = points.point[i];
    const atlas::SurfacePoint at = surface_point(input_.layout, p);
    return input_.lookup.place({at.triangle, at.u, at.v}, back);
  };
  Receivers receivers(input_.scene, input_.layout, input_.direct.lift());
  const auto receiver = [&](std::uint32_t i) { return receivers(points.point[i], {0.5f, 0.5f}); };
  const radiosity::ElementLookup::Place from = place(0);
  const radiosity::Receiver first = receiver(0);
  for (std::uint32_t i = 1; i < points.count; ++i) {
    const radiosity::Receiver other = receiver(i);
    const bool one_plane = dot(first.frame.normal, other.frame.normal) >= kOnePlane;
    const bool sees = one_plane ? input_.lookup.sees(from, place(i), back)
                                : is_connected(first, other, input_.texels.texels[texel].chart);
    if (!sees) return false;
  }
  return true;
}

bool NearTexels::is_connected(const radiosity::Receiver& a, const radiosity::Receiver& b,
                              std::uint32_t chart) const {
  rays::Ray ray{a.frame.origin, b.frame.origin - a.frame.origin, 0.0f, 1.0f};
  std::uint32_t exclude = a.triangle;
  for (int met = 0; met < kMostMet; ++met) {
    const rays::Hit hit = input_.caster.closest(ray, exclude);
    if (!hit.found()) return true;
    if (input_.layout.chart_of[hit.triangle] != chart) return false;
    exclude = hit.triangle;
    ray.t_min = hit.t;
  }
  return true;
}

void NearLinks::merge(std::vector<NearLink>& links) {
  std::sort(links.begin(), links.end(),
            [](const NearLink& a, const NearLink& b) { return a.texel < b.texel; });
  std::size_t count = 0;
  for (const NearLink& link : links) {
    if (count > 0 && links[count - 1].texel == link.texel) {
      links[count - 1].weight += link.weight;
    } else {
      links[count++] = link;
    }
  }
  links.resize(count);
}

void NearLinks::add(std::span<const std::uint32_t> texels, std::span<const std::uint32_t> counts,
                    std::vector<NearLink> links) {
  if (links.empty()) return;
  links.shrink_to_fit();
  links_.push_back(std::move(links));
  const std::span<const NearLink> kept(links_.back());
  for (std::size_t i = 0, begin = 0; i < texels.size(); begin += counts[i++]) {
    row_[texels[i]] = kept.subspan(begin, counts[i]);
  }
}

Rgb NearLinks::linked(std::size_t t, const std::vector<Rgb>& first,
                      const std::vector<std::uint8_t>& known, const Start& start,
                      const std::vector<GatheredTexel>& texels) const {
  Rgbd light = to_double(start.irradiance[t]);
  for (const NearLink& link : row_[t]) {
    if (known[link.texel] == 0) continue;
    light += to_double(link.weight * (texels[link.texel].irradiance - first[link.texel]));
  }
  // Rounding may leave less than nothing of what stood for the link.
  const auto positive = [](double v) { return static_cast<float>(std::max(0.0, v)); };
  return {positive(light.r), positive(light.g), positive(light.b)};
}

double NearLinks::iterate(const std::vector<Rgb>& first, const std::vector<std::uint8_t>& known,
                          const Start& start, std::vector<GatheredTexel>& texels,
                          radiosity::GroupedLight& by_group) const {
  std::vector<Rgb> next(texels.size());
  radiosity::GroupedLight next_by_group = start.by_group;
  struct Change {
    double of = 0, all = 0;
  };
  const Change change = deterministic_reduce(
      row_.size(), 1024, Change{},
      [&](std::size_t begin, std::size_t end) {
        Change sum;
        for (std::size_t t = begin; t < end; ++t) {
          if (row_[t].empty()) continue;
          next[t] = linked(t, first, known, start, texels);
          for (const NearLink& link : row_[t]) {
            if (known[link.texel] == 0) continue;
            for (std::size_t g = 0; g < by_group.groups(); ++g) {
              next_by_group.of(t)[g] += link.weight * by_group.of(link.texel)[g];
            }
          }
          const auto square = [](float v) {
            return static_cast<double>(v) * static_cast<double>(v);
          };
          sum.of += square((next[t] - texels[t].irradiance).sum());
          sum.all += square(next[t].sum());
          for (std::size_t g = 0; g < by_group.groups(); ++g) {
            sum.of += square((next_by_group.of(t)[g] - by_group.of(t)[g]).sum());
          }
        }
        return sum;
      },
      [](const Change& a, const Change& b) {
        return Change{a.of + b.of, a.all + b.all};
      });
  for (std::size_t t = 0; t < row_.size(); ++t) {
    if (row_[t].empty()) continue;
    texels[t].irradiance = next[t];
    for (std::size_t g = 0; g < by_group.groups(); ++g) {
      by_group.of(t)[g] = next_by_group.of(t)[g];
    }
  }
  return change.all > 0 ? std::sqrt(change.of / change.all) : 0;
}

}  // namespace lightbatch::lightmap
