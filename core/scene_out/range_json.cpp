#include "core/scene_out/range_json.h"

namespace lightbatch::scene_out {

Json range_json(const Writer& w, std::size_t primitive, const IndexRange& range, bool coloured) {
  const scene::Object& object = w.scene.objects[range.object];
  Json json{{"primitive", primitive},
            {"first", range.first},
            {"count", range.count},
            {"source_primitive", object.primitive}};
  if (coloured) json["material"] = w.gltf_material(object.material);
  const Json& source = w.document.json.at("meshes").at(object.mesh).at("primitives");
  if (const Json* extras = member(source.at(object.primitive), "extras"))
    json["primitive_extras"] = *extras;
  return json;
}

}  // namespace lightbatch::scene_out
