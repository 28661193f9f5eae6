#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/gltf/document.h"

namespace lightbatch::scene_out {

/// Calls visit(slot) for every place of core glTF, and of KHR_draco_mesh_compression, that holds
/// the number of a buffer view.
void for_each_view(gltf::Json& root, const std::function<void(gltf::Json& slot)>& visit);

/// Which bytes of which buffer views are read by accessors, images or (whole) by pins.
class ViewUses {
 public:
  ViewUses(gltf::Json& root, const std::set<std::uint32_t>& pinned);
  bool is_used(std::uint32_t view) const { return whole_[view] || !ranges_[view].empty(); }
  /// One binary with the used bytes of all used views, which are pointed there; accessors' offsets
  /// follow. Bytes of an interleaved view that only dropped accessors read go where they can.
  Bytes copy_ranges(gltf::Json& root, std::span<const Bytes* const> buffers);

 private:
  struct Range {
    std::uint64_t begin = 0, end = 0, moved_to = 0;
  };
  void add(gltf::Json& json, std::uint64_t bytes);

  std::vector<bool> whole_;
  std::vector<std::vector<Range>> ranges_;
  std::vector<std::uint64_t> length_, stride_;
};

}  // namespace lightbatch::scene_out
