#include "core/batches/fates.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace lightbatch::batches {
namespace {

/// Copies are worth this many bytes for each draw that they save; with lightmaps more, since every
/// placement then has bytes of its own anyway and instances cannot share a draw.
constexpr double kBytesOfDraw = 16384, kBytesOfLitDraw = 65536;
/// Meshes so near in their bytes for each draw are copied together.
constexpr double kNear = 1.1;

/// All placements of one mesh: the objects of one node (and GPU instance) each. With lightmaps, of
/// one primitive of a mesh: nothing keeps its primitives together then.
struct Shared {
  std::uint32_t mesh = 0;
  std::vector<std::vector<std::uint32_t>> placements;  // objects, by primitive
  double bytes = 0;                                    // of one copy
};

/// Primitives correspond one to one; triangles too, but for those that lost their area to rounding.
bool same_kind(const scene::Scene& scene, const std::vector<std::uint32_t>& a,
               const std::vector<std::uint32_t>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](std::uint32_t x, std::uint32_t y) {
    return scene.objects[x].primitive == scene.objects[y].primitive &&
           scene.objects[x].material == scene.objects[y].material;
  });
}

/// Rotation, positive scale and translation say all: instances can be stored so.
bool is_plain_placement(const scene::Object& object) {
  const Affine& m = object.to_world;
  const double xx = dot(m.x, m.x), yy = dot(m.y, m.y), zz = dot(m.z, m.z);
  constexpr double kShear = 1e-5;  // cosine between axes
  return m.determinant() > 0 && std::abs(dot(m.x, m.y)) <= kShear * std::sqrt(xx * yy) &&
         std::abs(dot(m.y, m.z)) <= kShear * std::sqrt(yy * zz) &&
         std::abs(dot(m.z, m.x)) <= kShear * std::sqrt(zz * xx);
}

std::vector<Shared> shared_meshes(const scene::Scene& scene, const KeyMap& keys,
                                  const BatchOptions& options, double* geometry_bytes) {
  const bool lit = !options.page_of_triangle.empty();
  using Pair = std::pair<std::uint32_t, std::uint32_t>;
  std::map<Pair, std::map<Pair, std::vector<std::uint32_t>>> uses;
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    const scene::Object& object = scene.objects[o];
    if (object.triangle_count == 0) continue;
    // Without an instance: kNone + 1 = 0 sorts first.
    uses[{object.mesh, lit ? object.primitive : 0}][{object.node, object.instance + 1}].push_back(
        o);
  }
  std::vector<Shared> result;
  for (auto& [source, placements] : uses) {
    Shared shared;
    shared.mesh = source.first;
    for (auto& [where, objects] : placements) shared.placements.push_back(std::move(objects));
    for (const std::uint32_t o : shared.placements.front()) {
      const double triangles = scene.objects[o].triangle_count;
      const double vertex_bytes = options.traits.empty() ? 32 : options.traits[o].vertex_bytes;
      shared.bytes += triangles * (keys.vertices_of_object[o] * vertex_bytes + 3 * 2);
    }
    *geometry_bytes += shared.bytes;
    result.push_back(std::move(shared));
  }
  return result;
}

/// How many meshes have triangles of each key.
std::vector<std::uint32_t> meshes_of_keys(const KeyMap& keys, const scene::Scene& scene,
                                          const std::vector<Shared>& meshes) {
  std::vector<std::uint32_t> users(keys.keys.size(), 0), last(keys.keys.size(), scene::kNone);
  for (const Shared& mesh : meshes)
    for (const auto& objects : mesh.placements)
      for (const std::uint32_t o : objects) {
        const std::uint32_t key = keys.of_triangle[scene.objects[o].first_triangle];
        if (std::exchange(last[key], mesh.mesh) != mesh.mesh) ++users[key];
      }
  return users;
}

/// Whether copies of a mesh would share draws with other meshes: alone, they save nothing that
/// instances do not.
bool joins_others(const scene::Scene& scene, const KeyMap& keys, const Shared& mesh,
                  const std::vector<std::uint32_t>& users) {
  const auto& objects = mesh.placements.front();
  return std::any_of(objects.begin(), objects.end(), [&](std::uint32_t o) {
    return users[keys.of_triangle[scene.objects[o].first_triangle]] > 1;
  });
}

}  // namespace

Fates decide_fates(const scene::Scene& scene, const BatchOptions& options, const KeyMap& keys,
                   const CopyLimits& limits) {
  const bool lit = !options.page_of_triangle.empty();
  const double bytes_of_draw = std::max(limits.bytes_of_draw, lit ? kBytesOfLitDraw : kBytesOfDraw);
  Fates fates;
  fates.of_object.assign(scene.objects.size(), Fate::kMerged);
  fates.reason.resize(scene.objects.size());
  const auto leave = [&](std::uint32_t object, const std::string& reason) {
    fates.of_object[object] = Fate::kLeft;
    fates.reason[object] = reason;
  };
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    if (!options.traits.empty() && !options.traits[o].keep.empty())
      leave(o, options.traits[o].keep);
    else if (scene.objects[o].triangle_count == 0)
      leave(o, "no triangle with an area");
  }

  std::vector<Shared> meshes = shared_meshes(scene, keys, options, &fates.geometry_bytes);
  for (const Shared& mesh : meshes) {
    if (mesh.placements.size() < 2) continue;
    for (const auto& objects : mesh.placements)
      for (const std::uint32_t o : objects)
        if (is_blended(scene, o) && fates.of_object[o] == Fate::kMerged) leave(o, kBlendedReason);
  }
  const std::vector<std::uint32_t> users = meshes_of_keys(keys, scene, meshes);
  // The fewest bytes for each draw saved first.
  std::stable_sort(meshes.begin(), meshes.end(), [](const Shared& a, const Shared& b) {
    return a.bytes * static_cast<double>(b.placements.front().size()) <
           b.bytes * static_cast<double>(a.placements.front().size());
  });
  const double most = std::max(0.0, limits.growth - 1) * fates.geometry_bytes;
  const double little = std::min(most, kLittleGrowth * fates.geometry_bytes);
  for (const Shared& mesh : meshes) {
    if (mesh.placements.size() < 2) continue;
    const double copies = mesh.bytes * static_cast<double>(mesh.placements.size() - 1);
    const double bytes_a_draw = mesh.bytes / static_cast<double>(mesh.placements.front().size());
    const bool joins = lit || joins_others(scene, keys, mesh, users);
    const bool worth = joins && bytes_a_draw <= bytes_of_draw;
    if (fates.copied_bytes + copies <= (worth ? most : little)) {
      fates.copied_bytes += copies;
      continue;
    }
    if (joins && !worth && fates.next_bytes_of_draw == 0)
      fates.next_bytes_of_draw = kNear * bytes_a_draw;
    Placements fit;
    std::set<std::uint32_t> unfit;  // nodes; their GPU instances are drawn by one call or none
    for (const auto& objects : mesh.placements) {
      bool fits = options.gpu_instancing && !lit;
      for (const std::uint32_t o : objects)
        fits = fits && fates.of_object[o] == Fate::kMerged && is_plain_placement(scene.objects[o]);
      if (fits && !fit.empty()) fits = same_kind(scene, objects, fit.front());
      if (fits)
        fit.push_back(objects);
      else
        unfit.insert(scene.objects[objects.front()].node);
    }
    std::erase_if(fit, [&](const auto& objects) {
      return unfit.contains(scene.objects[objects.front()].node);
    });
    for (const auto& objects : mesh.placements)
      for (const std::uint32_t o : objects)
        if (fates.of_object[o] == Fate::kMerged) leave(o, kInstancedReason);
    if (fit.size() < 2) continue;
    for (const auto& objects : fit)
      for (const std::uint32_t o : objects) fates.of_object[o] = Fate::kInstanced;
    fates.shared.push_back(std::move(fit));
  }
  return fates;
}

}  // namespace lightbatch::batches
