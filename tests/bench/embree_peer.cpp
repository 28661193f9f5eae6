#include "tests/bench/embree_peer.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <iterator>
#include <new>
#include <vector>

namespace lightbatch::bench {
namespace {

struct BuildNode {
  bool leaf = false;
  std::size_t primitives = 0;
  RTCBounds bounds[2] = {};
  BuildNode* child[2] = {nullptr, nullptr};
};

double half_area(const RTCBounds& b) {
  const double x = static_cast<double>(b.upper_x) - static_cast<double>(b.lower_x);
  const double y = static_cast<double>(b.upper_y) - static_cast<double>(b.lower_y);
  const double z = static_cast<double>(b.upper_z) - static_cast<double>(b.lower_z);
  return x * y + y * z + z * x;
}

double cost_of(const BuildNode& node, double area) {
  if (node.leaf) return area * static_cast<double>(node.primitives);
  double sum = area;
  for (int i = 0; i < 2; ++i) sum += cost_of(*node.child[i], half_area(node.bounds[i]));
  return sum;
}

template <typename Packet>
void put(Packet& p, std::size_t k, const rays::Ray& ray) {
  p.org_x[k] = ray.origin.x, p.org_y[k] = ray.origin.y, p.org_z[k] = ray.origin.z;
  p.dir_x[k] = ray.direction.x, p.dir_y[k] = ray.direction.y, p.dir_z[k] = ray.direction.z;
  p.tnear[k] = ray.t_min, p.tfar[k] = ray.t_max, p.time[k] = 0;
  p.mask[k] = ~0u, p.id[k] = 0, p.flags[k] = 0;
}

void put(RTCRay& r, const rays::Ray& ray) {
  r.org_x = ray.origin.x, r.org_y = ray.origin.y, r.org_z = ray.origin.z;
  r.dir_x = ray.direction.x, r.dir_y = ray.direction.y, r.dir_z = ray.direction.z;
  r.tnear = ray.t_min, r.tfar = ray.t_max, r.time = 0, r.mask = ~0u, r.id = 0, r.flags = 0;
}

template <std::size_t W, typename Ray, typename RayHit, typename Occluded, typename Intersect>
std::size_t cast_packets(const RaySet& set, Occluded occluded, Intersect intersect) {
  alignas(64) int valid[W];
  std::fill(std::begin(valid), std::end(valid), -1);
  std::size_t hits = 0;
  if (set.any) {
    alignas(64) Ray packet;
    for (std::size_t i = 0; i + W <= set.rays.size(); i += W) {
      for (std::size_t k = 0; k < W; ++k) put(packet, k, set.rays[i + k]);
      occluded(valid, &packet);
      for (std::size_t k = 0; k < W; ++k) hits += packet.tfar[k] < 0 ? 1u : 0u;
    }
  } else {
    alignas(64) RayHit packet;
    for (std::size_t i = 0; i + W <= set.rays.size(); i += W) {
      for (std::size_t k = 0; k < W; ++k) {
        put(packet.ray, k, set.rays[i + k]);
        packet.hit.geomID[k] = packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
      }
      intersect(valid, &packet);
      for (std::size_t k = 0; k < W; ++k)
        hits += packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID ? 1u : 0u;
    }
  }
  return hits;
}

}  // namespace

struct EmbreePeer::State {
  const Scene& source;
  bool robust;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::atomic<long long> bytes{0};
};

EmbreePeer::EmbreePeer(const Scene& scene, int threads, bool robust)
    : state_(new State{scene, robust}) {
  const std::string config = "threads=" + std::to_string(threads) + ",set_affinity=0";
  state_->device = rtcNewDevice(config.c_str());
  rtcSetDeviceMemoryMonitorFunction(
      state_->device,
      [](void* user, ssize_t bytes, bool) {
        static_cast<State*>(user)->bytes += bytes;
        return true;
      },
      state_.get());
}

EmbreePeer::~EmbreePeer() {
  if (state_->scene != nullptr) rtcReleaseScene(state_->scene);
  rtcReleaseDevice(state_->device);
}

void EmbreePeer::build() {
  if (state_->scene != nullptr) rtcReleaseScene(state_->scene);
  const Scene& s = state_->source;
  state_->scene = rtcNewScene(state_->device);
  rtcSetSceneBuildQuality(state_->scene, RTC_BUILD_QUALITY_MEDIUM);
  rtcSetSceneFlags(state_->scene, state_->robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  RTCGeometry geometry = rtcNewGeometry(state_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             s.positions.data(), 0, 12, s.positions.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             s.triangles.data(), 0, 12, s.triangles.size());
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(state_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(state_->scene);
}

double EmbreePeer::bytes_per_triangle() const {
  return static_cast<double>(state_->bytes.load()) /
         static_cast<double>(state_->source.triangles.size());
}

double EmbreePeer::sah_cost() const {
  std::vector<RTCBuildPrimitive> primitives;
  for (const Aabb& b : state_->source.boxes) {
    primitives.push_back({b.lower.x, b.lower.y, b.lower.z, 0, b.upper.x, b.upper.y, b.upper.z,
                          static_cast<unsigned>(primitives.size())});
  }
  RTCBVH tree = rtcNewBVH(state_->device);
  RTCBuildArguments a = rtcDefaultBuildArguments();
  a.byteSize = sizeof a;
  a.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  a.maxBranchingFactor = 2, a.maxDepth = 64, a.sahBlockSize = 1, a.minLeafSize = 1,
  a.maxLeafSize = 8, a.traversalCost = 1, a.intersectionCost = 1, a.bvh = tree;
  a.primitives = primitives.data();
  a.primitiveCount = a.primitiveArrayCapacity = primitives.size();
  a.createNode = [](RTCThreadLocalAllocator arena, unsigned, void*) -> void* {
    return new (rtcThreadLocalAlloc(arena, sizeof(BuildNode), 16)) BuildNode;
  };
  a.setNodeChildren = [](void* node, void** children, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) {
      static_cast<BuildNode*>(node)->child[i] = static_cast<BuildNode*>(children[i]);
    }
  };
  a.setNodeBounds = [](void* node, const RTCBounds** bounds, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) static_cast<BuildNode*>(node)->bounds[i] = *bounds[i];
  };
  a.createLeaf = [](RTCThreadLocalAllocator arena, const RTCBuildPrimitive*, std::size_t count,
                    void*) -> void* {
    auto* node = new (rtcThreadLocalAlloc(arena, sizeof(BuildNode), 16)) BuildNode;
    node->leaf = true;
    node->primitives = count;
    return node;
  };
  const auto* root = static_cast<const BuildNode*>(rtcBuildBVH(&a));
  const Aabb box = state_->source.bounds();
  const double area = half_area(
      {box.lower.x, box.lower.y, box.lower.z, 0, box.upper.x, box.upper.y, box.upper.z, 0});
  const double cost = cost_of(*root, area) / area;
  rtcReleaseBVH(tree);
  return cost;
}

std::uint32_t EmbreePeer::closest(const rays::Ray& ray, float& t) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit h;
  put(h.ray, ray);
  h.hit.geomID = h.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(state_->scene, &context, &h);
  t = h.ray.tfar;
  return h.hit.geomID == RTC_INVALID_GEOMETRY_ID ? rays::kNoTriangle : h.hit.primID;
}

std::size_t EmbreePeer::cast(const RaySet& set, Way way) const {
  RTCScene scene = state_->scene;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (way != Way::kSingle && (set.name == "primary" || set.name == "ff16")) {
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  }
  std::size_t hits = 0;
  switch (way) {
    case Way::kSingle:
      for (const rays::Ray& ray : set.rays) {
        if (set.any) {
          RTCRay r;
          put(r, ray);
          rtcOccluded1(scene, &context, &r);
          hits += r.tfar < 0;
        } else {
          float t = 0;
          hits += closest(ray, t) != rays::kNoTriangle;
        }
      }
      return hits;
    case Way::kPacket8:
      return cast_packets<8, RTCRay8, RTCRayHit8>(
          set, [&](const int* v, RTCRay8* r) { rtcOccluded8(v, scene, &context, r); },
          [&](const int* v, RTCRayHit8* r) { rtcIntersect8(v, scene, &context, r); });
    case Way::kPacket16:
      return cast_packets<16, RTCRay16, RTCRayHit16>(
          set, [&](const int* v, RTCRay16* r) { rtcOccluded16(v, scene, &context, r); },
          [&](const int* v, RTCRayHit16* r) { rtcIntersect16(v, scene, &context, r); });
    case Way::kStream:
      break;
  }
  constexpr std::size_t kBatch = 128;
  alignas(64) RTCRayHit batch[kBatch];
  alignas(64) RTCRay shadow[kBatch];
  for (std::size_t i = 0; i < set.rays.size(); i += kBatch) {
    const std::size_t count = std::min(kBatch, set.rays.size() - i);
    for (std::size_t k = 0; k < count; ++k) {
      put(set.any ? shadow[k] : batch[k].ray, set.rays[i + k]);
      batch[k].hit.geomID = batch[k].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
    const auto n = static_cast<unsigned>(count);
    if (set.any) {
      rtcOccluded1M(scene, &context, shadow, n, sizeof(RTCRay));
    } else {
      rtcIntersect1M(scene, &context, batch, n, sizeof(RTCRayHit));
    }
    for (std::size_t k = 0; k < count; ++k) {
      const bool hit =
          set.any ? shadow[k].tfar < 0 : batch[k].hit.geomID != RTC_INVALID_GEOMETRY_ID;
      hits += hit ? 1u : 0u;
    }
  }
  return hits;
}

}  // namespace lightbatch::bench
