#include "core/accuracy/leaks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/lightmap/look_up.h"
#include "core/lightmap/texel_points.h"
#include "core/math/sampling.h"

namespace lightbatch::accuracy {
namespace {

/// Light below this share of the mean is darkness.
constexpr double kDark = 1e-4;
/// A texel this dark may be one that no light reaches.
constexpr double kDarkTexel = 1e-3;
constexpr int kNear = 2;  // texels
/// Paths that find most lit points lit, and those that make darkness sure.
constexpr std::uint32_t kFirstPaths = 16;
constexpr std::uint32_t kSurePaths = 128;
/// Where light comes by rare bright paths, as from a small patch in the sun, these find none: so
/// many of a stratum's leaks stand for the others, and are traced until light is found, or by so
/// many paths.
constexpr std::size_t kConfirmed = 16;
constexpr std::uint32_t kSurestPaths = 8192;
constexpr std::uint32_t kHiddenRays = 16;
constexpr std::uint32_t kMostOpen = 2;  // of them, in a crack or inside a solid

enum class Verdict : std::uint8_t { kFine, kHidden, kLeak };

struct Judged {
  Verdict verdict = Verdict::kFine;
  double shown = 0;  // lux, mean over channels
  SurfacePoint point;
};

double brightness(const Rgb& c) { return static_cast<double>(c.sum()) / 3; }

/// Texels to look at, and the surface they hold.
struct Stratum {
  std::vector<std::uint32_t> texels;
  std::vector<double> up_to;  // m2, running sum
  double area() const { return up_to.empty() ? 0.0 : up_to.back(); }
};

class LeakSearch {
 public:
  LeakSearch(const PathTracer& tracer, const rays::Caster& caster, const scene::Scene& scene,
             const atlas::Layout& layout, const atlas::TexelMap& texels,
             const std::vector<lightmap::PageImage>& pages, const LeakOptions& options)
      : tracer_(tracer),
        caster_(caster),
        scene_(scene),
        layout_(layout),
        texels_(texels),
        pages_(pages),
        options_(options) {}

  Result<Leaks> run(const Progress& progress) const {
    Leaks leaks;
    const std::array<Stratum, 2> strata = choose_texels();
    const double whole = strata[0].area() + strata[1].area();
    if (!(whole > 0) || !(options_.mean_irradiance > 0)) return leaks;
    const std::size_t each = options_.points / 2;
    for (std::size_t s = 0; s < strata.size(); ++s) {
      if (strata[s].texels.empty()) continue;
      std::vector<Judged> judged(each);
      parallel_for(each, 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
          judged[i] = judge(strata[s], i, each, item_seed(options_.seed, i, 40 + s));
        }
      });
      if (progress.cancelled()) return cancelled();
      std::vector<const Judged*> found;
      for (const Judged& j : judged) {
        if (j.verdict == Verdict::kHidden) ++leaks.hidden;
        if (j.verdict == Verdict::kLeak) found.push_back(&j);
      }
      const double share = confirm(found, item_seed(options_.seed, s, 42), leaks);
      if (progress.cancelled()) return cancelled();
      const double confirmed = std::round(share * static_cast<double>(found.size()));
      leaks.points += each;
      leaks.leaks += static_cast<std::uint64_t>(confirmed);
      leaks.area_share += strata[s].area() / whole * confirmed / static_cast<double>(each);
    }
    return leaks;
  }

 private:
  /// The share of leaks that more paths find dark too; the brightest of these is noted.
  double confirm(std::span<const Judged* const> found, std::uint64_t seed, Leaks& leaks) const {
    const std::size_t asked = std::min(found.size(), kConfirmed);
    if (asked == 0) return 0;
    std::vector<std::uint8_t> dark(asked);
    const auto nth = [&](std::size_t i) { return found[i * found.size() / asked]; };
    parallel_for(asked, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Random random(item_seed(seed, i));
        dark[i] = 1;
        for (std::uint32_t paths = 2 * kSurePaths; paths <= kSurestPaths && dark[i] != 0;
             paths *= 2) {
          dark[i] = is_dark(nth(i)->point, paths, random) ? 1 : 0;
        }
      }
    });
    std::size_t confirmed = 0;
    for (std::size_t i = 0; i < asked; ++i) {
      if (dark[i] == 0) continue;
      ++confirmed;
      if (nth(i)->shown <= leaks.largest * options_.mean_irradiance) continue;
      leaks.largest = nth(i)->shown / options_.mean_irradiance;
      leaks.triangle = nth(i)->point.triangle;
    }
    return static_cast<double>(confirmed) / static_cast<double>(asked);
  }

  bool is_dark(const SurfacePoint& point, std::uint32_t paths, Random& random) const {
    const std::array<SurfacePoint, 1> points{{point}};
    const Rgbd truth = tracer_.irradiance(points, paths, random.next_u64()).irradiance;
    return truth.sum() / 3 < kDark * options_.mean_irradiance;
  }

  double texel_brightness(const atlas::Texel& t) const {
    return brightness(pages_[t.page].irradiance.at(t.x, t.y));
  }

  /// A texel of the same chart within kNear is dark.
  bool beside_darkness(const atlas::Texel& t) const {
    const atlas::Page& page = layout_.pages[t.page];
    for (int y = std::max(0, t.y - kNear); y <= std::min(page.height - 1, t.y + kNear); ++y) {
      for (int x = std::max(0, t.x - kNear); x <= std::min(page.width - 1, t.x + kNear); ++x) {
        const std::uint32_t n = texels_.index[t.page][static_cast<std::size_t>(y * page.width + x)];
        if (n == scene::kNone || texels_.texels[n].chart != t.chart) continue;
        if (texel_brightness(texels_.texels[n]) < kDarkTexel * options_.mean_irradiance)
          return true;
      }
    }
    return false;
  }

  /// All other texels, and the bright ones beside darkness.
  std::array<Stratum, 2> choose_texels() const {
    std::vector<std::uint8_t> edge(texels_.texels.size());
    const double bright = options_.bright * options_.mean_irradiance;
    parallel_for(edge.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const atlas::Texel& texel = texels_.texels[t];
        edge[t] = texel_brightness(texel) > bright && beside_darkness(texel) ? 1 : 0;
      }
    });
    std::array<Stratum, 2> strata;
    for (std::uint32_t t = 0; t < edge.size(); ++t) {
      Stratum& s = strata[edge[t]];
      s.up_to.push_back(s.area() + texels_.surface_of(texels_.texels[t]));
      s.texels.push_back(t);
    }
    return strata;
  }

  Judged judge(const Stratum& stratum, std::size_t i, std::size_t count, std::uint64_t seed) const {
    Random random(seed);
    const double at = stratum.area() * (static_cast<double>(i) + random.next_double()) /
                      static_cast<double>(count);
    const auto place = std::min<std::size_t>(
        stratum.texels.size() - 1,
        static_cast<std::size_t>(std::upper_bound(stratum.up_to.begin(), stratum.up_to.end(), at) -
                                 stratum.up_to.begin()));
    const atlas::Texel& texel = texels_.texels[stratum.texels[place]];
    const auto points = lightmap::texel_points(texels_, texel);
    const Vec2f within{random.next_float(), random.next_float()};
    const lightmap::TexelPoints::Point& chosen = points.point[random.below(points.count)];
    const auto moved = lightmap::moved_within(layout_, chosen, within);
    Judged judged;
    judged.shown = brightness(lightmap::look_up(pages_[texel.page], moved.at));
    if (judged.shown <= options_.bright * options_.mean_irradiance) return judged;
    const atlas::SurfacePoint p = lightmap::surface_point(layout_, chosen, within);
    judged.point = {p.triangle, p.u, p.v, moved.back};
    if (!is_dark(judged.point, kFirstPaths, random)) return judged;
    if (is_hidden(judged.point, random)) {
      judged.verdict = Verdict::kHidden;
    } else if (is_dark(judged.point, kSurePaths, random)) {
      judged.verdict = Verdict::kLeak;
    }
    return judged;
  }

  /// Nearly all that is seen from the point is closer than a texel, or the back of a surface: it
  /// lies in a crack or inside a solid, where no viewer stands.
  bool is_hidden(const SurfacePoint& p, Random& random) const {
    const auto at =
        optics::surface_frame(scene_, p.triangle, p.u, p.v, p.back, optics::lift_of(scene_));
    const Frame frame = Frame::about(at.normal);
    const auto texel = static_cast<float>(1 / layout_.texels_per_metre);
    std::uint32_t open = 0;
    for (std::uint32_t k = 0; k < kHiddenRays; ++k) {
      const Vec2f square{random.next_float(), random.next_float()};
      const rays::Hit hit =
          caster_.closest({at.origin, frame.to_world(cosine_hemisphere(square))}, p.triangle);
      if (!hit.found() || (hit.t > texel && !hit.back)) ++open;
    }
    return open <= kMostOpen;
  }

  const PathTracer& tracer_;
  const rays::Caster& caster_;
  const scene::Scene& scene_;
  const atlas::Layout& layout_;
  const atlas::TexelMap& texels_;
  const std::vector<lightmap::PageImage>& pages_;
  const LeakOptions& options_;
};

}  // namespace

Result<Leaks> find_leaks(const PathTracer& tracer, const rays::Caster& caster,
                         const scene::Scene& scene, const atlas::Layout& layout,
                         const atlas::TexelMap& texels,
                         const std::vector<lightmap::PageImage>& pages, const LeakOptions& options,
                         const Progress& progress) {
  return LeakSearch(tracer, caster, scene, layout, texels, pages, options).run(progress);
}

}  // namespace lightbatch::accuracy
