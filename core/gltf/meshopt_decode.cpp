#include "core/gltf/meshopt_decode.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "core/base/parallel.h"
#include "core/gltf/extensions.h"
#include "core/gltf/fields.h"

namespace lightbatch::gltf {
namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";
/// The densest code: in the vertex codec, 2 bits say that 16 bytes repeat.
constexpr std::uint64_t kLargestExpansion = 64;

enum class Mode { kAttributes, kTriangles, kIndices };
enum class Filter { kNone, kOctahedral, kQuaternion, kExponential };

/// One view to decode: where from, where to, and how.
struct Task {
  std::size_t view = 0;
  std::span<const std::byte> source;
  std::uint64_t offset = 0;  // in the new buffer
  std::uint64_t count = 0;
  std::uint64_t stride = 0;
  Mode mode = Mode::kAttributes;
  Filter filter = Filter::kNone;

  std::uint64_t bytes() const { return count * stride; }
};

Status read_mode(const Json& extension, const std::string& place, Task& task) {
  const std::string mode = text_field(extension, "mode");
  const std::string filter = text_field(extension, "filter", "NONE");
  if (mode == "ATTRIBUTES") {
    task.mode = Mode::kAttributes;
  } else if (mode == "TRIANGLES") {
    task.mode = Mode::kTriangles;
  } else if (mode == "INDICES") {
    task.mode = Mode::kIndices;
  } else {
    return malformed(place, "unknown compression mode \"" + mode.substr(0, 80) + "\"");
  }
  if (filter == "NONE") {
    task.filter = Filter::kNone;
  } else if (filter == "OCTAHEDRAL") {
    task.filter = Filter::kOctahedral;
  } else if (filter == "QUATERNION") {
    task.filter = Filter::kQuaternion;
  } else if (filter == "EXPONENTIAL") {
    task.filter = Filter::kExponential;
  } else {
    return malformed(place, "unknown compression filter \"" + filter.substr(0, 80) + "\"");
  }
  return {};
}

/// What the extension's specification demands of each mode and filter, and what the decoders take
/// for granted.
Status check_shape(const Task& task, const std::string& place) {
  if (task.mode == Mode::kAttributes) {
    if (task.stride % 4 != 0 || task.stride > 256) {
      return malformed(place, "byteStride of attributes must be a multiple of 4, at most 256");
    }
  } else {
    if (task.stride != 2 && task.stride != 4) {
      return malformed(place, "byteStride of indices must be 2 or 4");
    }
    if (task.mode == Mode::kTriangles && task.count % 3 != 0) {
      return malformed(place, "the count of triangle indices must be a multiple of 3");
    }
    if (task.filter != Filter::kNone) return malformed(place, "indices have no filter");
  }
  if (task.filter == Filter::kOctahedral && task.stride != 4 && task.stride != 8) {
    return malformed(place, "the OCTAHEDRAL filter needs a byteStride of 4 or 8");
  }
  if (task.filter == Filter::kQuaternion && task.stride != 8) {
    return malformed(place, "the QUATERNION filter needs a byteStride of 8");
  }
  return {};
}

Result<Task> read_task(const Document& document, const Json& view, const Json& extension,
                       const std::string& place) {
  Task task;
  task.count = unsigned_field(extension, "count");
  task.stride = unsigned_field(extension, "byteStride");
  LB_RETURN_IF_ERROR(read_mode(extension, place, task));
  LB_RETURN_IF_ERROR(check_shape(task, place));

  const Bytes& buffer = document.buffers[extension["buffer"].get<std::size_t>()];
  const std::uint64_t offset = unsigned_field(extension, "byteOffset");
  const std::uint64_t length = unsigned_field(extension, "byteLength");
  if (offset > buffer.size() || length > buffer.size() - offset) {
    return malformed(place, "the compressed data runs past its buffer");
  }
  task.source = std::span(buffer).subspan(offset, length);

  const std::uint64_t decoded = unsigned_field(view, "byteLength");
  if (decoded / task.stride != task.count || decoded % task.stride != 0) {
    return malformed(place, "the bufferView's byteLength must be count times byteStride");
  }
  if (unsigned_field(view, "byteStride", task.stride) != task.stride) {
    return malformed(place, "the bufferView has another byteStride");
  }
  if (decoded > length * kLargestExpansion) {
    return malformed(
        place, std::to_string(length) + " compressed bytes cannot hold " + std::to_string(decoded));
  }
  return task;
}

bool decode(const Task& task, std::byte* out) {
  const auto* source = reinterpret_cast<const unsigned char*>(task.source.data());
  const std::size_t size = task.source.size();
  switch (task.mode) {
    case Mode::kAttributes:
      if (meshopt_decodeVertexBuffer(out, task.count, task.stride, source, size) != 0) return false;
      break;
    case Mode::kTriangles:
      return meshopt_decodeIndexBuffer(out, task.count, task.stride, source, size) == 0;
    case Mode::kIndices:
      return meshopt_decodeIndexSequence(out, task.count, task.stride, source, size) == 0;
  }
  switch (task.filter) {
    case Filter::kNone:
      break;
    case Filter::kOctahedral:
      meshopt_decodeFilterOct(out, task.count, task.stride);
      break;
    case Filter::kQuaternion:
      meshopt_decodeFilterQuat(out, task.count, task.stride);
      break;
    case Filter::kExponential:
      meshopt_decodeFilterExp(out, task.count, task.stride);
      break;
  }
  return true;
}

/// Removes the fallback buffers that nothing points into, and closes the gaps in the numbering.
void drop_fallback_buffers(Document& document) {
  Json& buffers = document.json["buffers"];
  std::vector<bool> keep(buffers.size());
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    keep[i] = extension_of(buffers[i], kMeshopt) == nullptr;
    erase_extension(buffers[i], kMeshopt);
  }
  const auto views = document.json.find("bufferViews");
  if (views != document.json.end()) {
    for (const Json& view : *views) keep[view["buffer"].get<std::size_t>()] = true;
  }
  std::vector<std::size_t> renumbered(buffers.size());
  Json kept = Json::array();
  std::vector<Bytes> kept_bytes;
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    renumbered[i] = kept.size();
    if (!keep[i]) continue;
    kept.push_back(std::move(buffers[i]));
    kept_bytes.push_back(std::move(document.buffers[i]));
  }
  if (views != document.json.end()) {
    for (Json& view : *views) view["buffer"] = renumbered[view["buffer"].get<std::size_t>()];
  }
  document.buffers = std::move(kept_bytes);
  if (kept.empty()) {
    document.json.erase("buffers");
  } else {
    buffers = std::move(kept);
  }
}

}  // namespace

Status decode_meshopt(Document& document, const JsonPath& root, ResourceLoader& loader) {
  if (!document.json.contains("buffers")) return {};
  const JsonPath list(root, "bufferViews");
  const Json& views = list_field(document.json, "bufferViews");
  std::vector<Task> tasks;
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Json* extension = extension_of(views[i], kMeshopt);
    if (extension == nullptr) continue;
    const std::string place = JsonPath(list, i).text() + "/extensions/" + kMeshopt;
    LB_ASSIGN_OR_RETURN(Task task, read_task(document, views[i], *extension, place));
    LB_RETURN_IF_ERROR(loader.spend(task.bytes(), place));
    task.view = i;
    task.offset = total;
    total = (total + task.bytes() + 15) / 16 * 16;
    tasks.push_back(task);
  }

  if (!tasks.empty()) {
    document.had_meshopt = true;
    Bytes decoded(total);
    std::vector<char> done(tasks.size(), 0);
    parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        done[i] = decode(tasks[i], decoded.data() + tasks[i].offset) ? 1 : 0;
      }
    });
    const std::size_t buffer = document.buffers.size();
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      if (done[i] == 0) {
        return malformed(JsonPath(list, tasks[i].view).text(), "broken meshopt data");
      }
      Json& view = document.json["bufferViews"][tasks[i].view];
      view["buffer"] = buffer;
      view["byteOffset"] = tasks[i].offset;
      erase_extension(view, kMeshopt);
    }
    document.json["buffers"].push_back({{"byteLength", total}});
    document.buffers.push_back(std::move(decoded));
  }
  drop_fallback_buffers(document);
  return {};
}

}  // namespace lightbatch::gltf
