// Key frames as glTF 2.0 defines them (3.11 and appendix C): STEP, LINEAR (rotations by slerp),
// CUBICSPLINE.

#include "core/scene_in/animation.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/gltf/accessor.h"
#include "core/gltf/fields.h"

namespace lightbatch::scene_in {
namespace {

using gltf::Json;

/// Moments of one animation, at most.
constexpr std::size_t kMostMoments = 257;
/// Moments from one key frame to the next: a quarter turn between them bulges by 2 % of its radius
/// at most.
constexpr std::size_t kSteps = 4;
/// Node transforms and boxes of one file, and values read for it (shared ones at every use).
constexpr std::uint64_t kMostTransforms = 20'000'000;
constexpr std::uint64_t kMostValues = 50'000'000;

enum class Interpolation : std::uint8_t { kStep, kLinear, kCubicSpline };

struct Track {
  ChannelTarget target;
  const std::vector<float>* times = nullptr;
  const gltf::Values* values = nullptr;
  Interpolation interpolation = Interpolation::kLinear;
};

using Value = std::array<double, 4>;

Value value_at(const gltf::Values& values, std::size_t i) {
  Value value{};
  const auto components = static_cast<std::size_t>(values.components);
  for (std::size_t c = 0; c < std::min<std::size_t>(4, components); ++c) {
    value[c] = static_cast<double>(values.data[components * i + c]);
  }
  return value;
}

Value mix(const Value& a, double wa, const Value& b, double wb) {
  Value value{};
  for (std::size_t c = 0; c < 4; ++c) value[c] = wa * a[c] + wb * b[c];
  return value;
}

Value slerp(const Value& a, Value b, double t) {
  double cosine = 0;
  for (std::size_t c = 0; c < 4; ++c) cosine += a[c] * b[c];
  if (cosine < 0) b = mix(b, -1, b, 0);
  const double angle = std::acos(std::min(1.0, std::fabs(cosine)));
  // Nearly the same rotation: the chord is the arc.
  if (!(angle > 1e-4)) return mix(a, 1 - t, b, t);
  return mix(a, std::sin((1 - t) * angle) / std::sin(angle), b,
             std::sin(t * angle) / std::sin(angle));
}

Value sample(const Track& track, double time) {
  const std::vector<float>& times = *track.times;
  const gltf::Values& values = *track.values;
  const bool cubic = track.interpolation == Interpolation::kCubicSpline;
  const auto key = [&](std::size_t i) { return value_at(values, cubic ? 3 * i + 1 : i); };
  const auto after = static_cast<std::size_t>(
      std::upper_bound(times.begin(), times.end(), static_cast<float>(time)) - times.begin());
  if (after == 0) return key(0);
  if (after == times.size()) return key(after - 1);
  const std::size_t k = after - 1;
  if (track.interpolation == Interpolation::kStep) return key(k);
  const double span = static_cast<double>(times[after]) - static_cast<double>(times[k]);
  const double t = std::clamp((time - static_cast<double>(times[k])) / span, 0.0, 1.0);
  if (!cubic) {
    return track.target.moves == Moves::kRotation ? slerp(key(k), key(after), t)
                                                  : mix(key(k), 1 - t, key(after), t);
  }
  const Value leaves = value_at(values, 3 * k + 2), arrives = value_at(values, 3 * after);
  const double t2 = t * t, t3 = t2 * t;
  const Value ends = mix(key(k), 2 * t3 - 3 * t2 + 1, key(after), 3 * t2 - 2 * t3);
  const Value tangents = mix(leaves, span * (t3 - 2 * t2 + t), arrives, span * (t3 - t2));
  return mix(ends, 1, tangents, 1);
}

/// Reads each accessor once, within a budget.
class KeyFrames {
 public:
  explicit KeyFrames(const gltf::Document& document) : document_(document) {}

  /// Null: beyond the budget.
  Result<const gltf::Values*> read(std::uint32_t accessor) {
    spent_ += document_.json["accessors"][accessor]["count"].get<std::uint64_t>();
    if (spent_ > kMostValues) return static_cast<const gltf::Values*>(nullptr);
    const auto known = read_.find(accessor);
    if (known != read_.end()) return &known->second;
    LB_ASSIGN_OR_RETURN(gltf::Values values, gltf::read_values(document_, accessor));
    return &(read_[accessor] = std::move(values));
  }

 private:
  const gltf::Document& document_;
  std::map<std::uint32_t, gltf::Values> read_;
  std::uint64_t spent_ = 0;
};

/// The channels of an animation that move nodes; false: beyond the budget.
Result<bool> read_tracks(const gltf::Document& document, const Json& animation, KeyFrames& frames,
                         std::vector<Track>& tracks) {
  const std::size_t node_count = gltf::list_field(document.json, "nodes").size();
  for (const Json& channel : animation["channels"]) {
    const auto target = target_of(channel, node_count);
    if (!target || target->moves == Moves::kOther) continue;
    const Json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
    LB_ASSIGN_OR_RETURN(const gltf::Values* times,
                        frames.read(gltf::index_field(sampler, "input")));
    LB_ASSIGN_OR_RETURN(const gltf::Values* values,
                        frames.read(gltf::index_field(sampler, "output")));
    if (times == nullptr || values == nullptr) return false;
    const std::string name = gltf::text_field(sampler, "interpolation", "LINEAR");
    Track track{*target, &times->data, values,
                name == "STEP"          ? Interpolation::kStep
                : name == "CUBICSPLINE" ? Interpolation::kCubicSpline
                                        : Interpolation::kLinear};
    // Pointers are not checked with the rest of the animation.
    const int components = target->moves == Moves::kRotation ? 4 : 3;
    const std::size_t keys =
        times->count() * (track.interpolation == Interpolation::kCubicSpline ? 3 : 1);
    if (times->components != 1 || values->components != components || keys == 0 ||
        values->count() < keys || !std::is_sorted(times->data.begin(), times->data.end())) {
      continue;
    }
    tracks.push_back(track);
  }
  return true;
}

/// Key frames of all tracks and moments between them.
std::vector<double> moments_of(const std::vector<Track>& tracks, std::size_t most) {
  std::vector<float> keys;
  for (const Track& track : tracks) {
    keys.insert(keys.end(), track.times->begin(), track.times->end());
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  }
  std::vector<double> moments;
  const std::size_t wanted = std::min(most, kSteps * (keys.size() - 1) + 1);
  for (std::size_t i = 0; i < wanted; ++i) {
    const double at = wanted == 1 ? 0
                                  : static_cast<double>(i) * static_cast<double>(keys.size() - 1) /
                                        static_cast<double>(wanted - 1);
    const auto k = std::min(keys.size() - 1, static_cast<std::size_t>(at));
    const auto next = std::min(keys.size() - 1, k + 1);
    const double part = at - static_cast<double>(k);
    moments.push_back(static_cast<double>(keys[k]) * (1 - part) +
                      static_cast<double>(keys[next]) * part);
  }
  return moments;
}

void pose(const Json& nodes, const NodeTree& tree, const std::vector<Track>& tracks, double time,
          std::vector<Affine>& world) {
  std::map<std::uint32_t, Trs> moved;
  for (const Track& track : tracks) {
    const auto [entry, added] = moved.try_emplace(track.target.node);
    if (added) entry->second = trs_of(nodes[track.target.node]);
    const Value v = sample(track, time);
    if (track.target.moves == Moves::kTranslation) entry->second.translation = {v[0], v[1], v[2]};
    if (track.target.moves == Moves::kScale) entry->second.scale = {v[0], v[1], v[2]};
    if (track.target.moves == Moves::kRotation) entry->second.rotation = v;
  }
  for (const std::uint32_t node : tree.order) {
    const auto entry = moved.find(node);
    const Affine own = entry == moved.end() ? tree.local[node] : entry->second.matrix();
    const std::uint32_t parent = tree.parents[node];
    world[node] = parent == gltf::kAbsent ? own : world[parent] * own;
  }
}

}  // namespace

Status for_each_pose(const gltf::Document& document, const NodeTree& tree, std::size_t visit_cost,
                     const std::function<void(const std::vector<Affine>& world)>& visit,
                     std::vector<std::string>& warnings) {
  const Json& animations = gltf::list_field(document.json, "animations");
  const Json& nodes = gltf::list_field(document.json, "nodes");
  KeyFrames frames(document);
  std::vector<Affine> world(nodes.size());
  std::uint64_t transforms = 0;
  for (std::size_t a = 0; a < animations.size(); ++a) {
    std::vector<Track> tracks;
    LB_ASSIGN_OR_RETURN(bool followed, read_tracks(document, animations[a], frames, tracks));
    const std::uint64_t each = nodes.size() + tracks.size() + visit_cost;
    followed = followed && transforms + 2 * each <= kMostTransforms;
    if (!followed) {
      warnings.push_back(document.name + "#/animations/" + std::to_string(a) +
                         ": too long to follow; light probes may not reach all of its way");
      return {};
    }
    if (tracks.empty()) continue;
    const auto left = static_cast<std::size_t>((kMostTransforms - transforms) / each);
    const std::vector<double> moments = moments_of(tracks, std::min(kMostMoments, left));
    transforms += each * moments.size();
    for (const double time : moments) {
      pose(nodes, tree, tracks, time, world);
      visit(world);
    }
  }
  return {};
}

}  // namespace lightbatch::scene_in
