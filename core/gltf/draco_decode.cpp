#include "core/gltf/draco_decode.h"

#include <map>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "core/gltf/draco_stream.h"
#include "core/gltf/extensions.h"
#include "core/gltf/fields.h"
#include "core/gltf/layout.h"

namespace lightbatch::gltf {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr std::uint32_t kTriangles = 4;

/// What a decoded attribute or index list becomes: a range of the new buffer and the accessor that
/// was promised for it.
struct Output {
  std::uint32_t accessor = kAbsent;
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

/// One stream to decode; primitives that share stream and accessors share the task.
struct Task {
  std::string place;
  std::span<const std::byte> stream;
  std::vector<DracoAttribute> attributes;
  std::vector<Output> outputs;  // of attributes, in the same order
  DracoIndices indices;
  Output index_output;
  std::vector<Json*> primitives;
};

class Collector {
 public:
  Collector(Document& document, std::uint64_t max_triangles, ResourceLoader& loader)
      : document_(document), indices_left_(3 * max_triangles), loader_(loader) {}

  Status add(Json& primitive, const JsonPath& path) {
    const Json* extension = extension_of(primitive, kDraco);
    if (extension == nullptr) return {};
    const std::string place = path.text() + "/extensions/" + kDraco;
    const std::string key = extension->dump() + primitive["attributes"].dump() +
                            std::to_string(index_field(primitive, "indices"));
    const auto [known, added] = known_.try_emplace(key, tasks.size());
    if (!added) {
      tasks[known->second].primitives.push_back(&primitive);
      return {};
    }
    LB_ASSIGN_OR_RETURN(Task task, make_task(primitive, *extension, place));
    task.primitives.push_back(&primitive);
    tasks.push_back(std::move(task));
    return {};
  }

  std::vector<Task> tasks;
  std::uint64_t total = 0;

 private:
  Result<Task> make_task(const Json& primitive, const Json& extension, const std::string& place) {
    Task task;
    task.place = place;
    if (unsigned_field(primitive, "mode", kTriangles) != kTriangles) {
      return unsupported(place, "Draco data of a primitive that is not of mode TRIANGLES");
    }
    const Json& view = document_.json["bufferViews"][extension["bufferView"].get<std::size_t>()];
    const Bytes& buffer = document_.buffers[view["buffer"].get<std::size_t>()];
    const std::uint64_t offset = unsigned_field(view, "byteOffset");
    const std::uint64_t length = unsigned_field(view, "byteLength");
    if (offset > buffer.size() || length > buffer.size() - offset) {
      return malformed(place, "the Draco data lies in a buffer that has no data");
    }
    task.stream = std::span(buffer).subspan(offset, length);
    LB_RETURN_IF_ERROR(read_layouts(primitive, extension, task));
    LB_RETURN_IF_ERROR(check_draco_counts(task.stream, place, task.attributes.front().layout.count,
                                          task.indices.count));
    if (task.indices.count > indices_left_) {
      return over_budget(place, "the scene has too many triangles in Draco data");
    }
    indices_left_ -= task.indices.count;
    for (std::size_t i = 0; i < task.attributes.size(); ++i) {
      LB_RETURN_IF_ERROR(reserve(task.attributes[i].layout.count, task.attributes[i].stride, place,
                                 task.outputs[i]));
    }
    LB_RETURN_IF_ERROR(
        reserve(task.indices.count, task.indices.index_bytes, place, task.index_output));
    return task;
  }

  /// Counts here are those check_draco_counts() has accepted: the product is small.
  Status reserve(std::uint64_t count, std::uint64_t stride, const std::string& place,
                 Output& output) {
    output.offset = total;
    output.bytes = count * stride;
    LB_RETURN_IF_ERROR(loader_.spend(output.bytes, place));
    total = (total + output.bytes + 3) / 4 * 4;
    return {};
  }

  Status read_layouts(const Json& primitive, const Json& extension, Task& task) const {
    const Json& accessors = list_field(document_.json, "accessors");
    for (const auto& [name, id] : extension["attributes"].items()) {
      const auto index = primitive["attributes"].find(name);
      if (index == primitive["attributes"].end()) {
        return malformed(task.place, "the primitive has no attribute " + name.substr(0, 80));
      }
      const std::size_t accessor = index->get<std::size_t>();
      const std::optional<Layout> layout = layout_of(accessors[accessor]);
      if (!layout) return malformed(task.place, "the accessor of " + name + " has an unknown type");
      if (!task.attributes.empty() && task.attributes.front().layout.count != layout->count) {
        return malformed(task.place, "the accessors of the attributes differ in count");
      }
      const std::uint64_t stride = (layout->element_bytes + 3) / 4 * 4;
      task.attributes.push_back({id.get<std::uint32_t>(), name, *layout, stride, nullptr});
      task.outputs.push_back({.accessor = static_cast<std::uint32_t>(accessor)});
    }
    task.index_output.accessor = index_field(primitive, "indices");
    if (task.index_output.accessor == kAbsent) {
      return malformed(task.place, "a Draco primitive needs an accessor for its indices");
    }
    const std::optional<Layout> layout = layout_of(accessors[task.index_output.accessor]);
    if (!layout || !is_index_layout(*layout)) {
      return malformed(task.place, "the accessor of the indices is not of unsigned scalars");
    }
    task.indices.count = layout->count;
    task.indices.index_bytes = layout->component_bytes;
    return {};
  }

  Document& document_;
  std::uint64_t indices_left_;
  ResourceLoader& loader_;
  std::map<std::string, std::size_t> known_;
};

/// Gives the promised accessor its data. An accessor that already has some (a fallback for readers
/// without Draco, or another primitive's stream) is left to its other users and copied.
class Placer {
 public:
  Placer(Document& document, std::size_t buffer) : json_(document.json), buffer_(buffer) {}

  std::size_t place(const Output& output, std::uint64_t stride, std::uint64_t element_bytes) {
    const std::size_t view = json_["bufferViews"].size();
    Json added = {{"buffer", buffer_}, {"byteOffset", output.offset}, {"byteLength", output.bytes}};
    if (stride != element_bytes) added["byteStride"] = stride;
    json_["bufferViews"].push_back(std::move(added));

    Json& accessors = json_["accessors"];
    std::size_t index = output.accessor;
    if (accessors[index].contains("bufferView")) {
      accessors.push_back(Json(accessors[index]));
      index = accessors.size() - 1;
    }
    accessors[index]["bufferView"] = view;
    accessors[index].erase("byteOffset");
    accessors[index].erase("sparse");
    return index;
  }

 private:
  Json& json_;
  std::size_t buffer_;
};

}  // namespace

Status decode_draco(Document& document, const JsonPath& root, std::uint64_t max_triangles,
                    ResourceLoader& loader, std::vector<std::uint32_t>& decoded_accessors) {
  const auto meshes = document.json.find("meshes");
  if (meshes == document.json.end()) return {};
  Collector collector(document, max_triangles, loader);
  const JsonPath list(root, "meshes");
  for (std::size_t m = 0; m < meshes->size(); ++m) {
    const JsonPath mesh(list, m);
    const JsonPath primitives(mesh, "primitives");
    Json& items = (*meshes)[m]["primitives"];
    for (std::size_t p = 0; p < items.size(); ++p) {
      LB_RETURN_IF_ERROR(collector.add(items[p], JsonPath(primitives, p)));
    }
  }
  std::vector<Task>& tasks = collector.tasks;
  if (tasks.empty()) return {};
  document.had_draco = true;

  Bytes decoded(collector.total);
  for (Task& task : tasks) {
    for (std::size_t i = 0; i < task.attributes.size(); ++i) {
      task.attributes[i].out = decoded.data() + task.outputs[i].offset;
    }
    task.indices.out = decoded.data() + task.index_output.offset;
  }
  std::vector<Status> statuses(tasks.size());
  parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      statuses[i] =
          decode_draco_mesh(tasks[i].stream, tasks[i].place, tasks[i].attributes, tasks[i].indices);
    }
  });
  for (const Status& status : statuses) LB_RETURN_IF_ERROR(status);

  Placer placer(document, document.buffers.size());
  for (const Task& task : tasks) {
    Json attributes = (*task.primitives.front())["attributes"];
    for (std::size_t i = 0; i < task.attributes.size(); ++i) {
      const DracoAttribute& attribute = task.attributes[i];
      const std::size_t accessor =
          placer.place(task.outputs[i], attribute.stride, attribute.layout.element_bytes);
      attributes[attribute.name] = accessor;
      decoded_accessors.push_back(static_cast<std::uint32_t>(accessor));
    }
    const std::size_t indices = placer.place(task.index_output, 0, 0);
    decoded_accessors.push_back(static_cast<std::uint32_t>(indices));
    for (Json* primitive : task.primitives) {
      (*primitive)["attributes"] = attributes;
      (*primitive)["indices"] = indices;
      erase_extension(*primitive, kDraco);
    }
  }
  document.json["buffers"].push_back({{"byteLength", decoded.size()}});
  document.buffers.push_back(std::move(decoded));
  return {};
}

}  // namespace lightbatch::gltf
