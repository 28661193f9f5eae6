#include "core/gltf/layout.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "core/gltf/fields.h"

namespace lightbatch::gltf {
namespace {

struct Shape {
  std::string_view name;
  std::uint32_t columns;
  std::uint32_t rows;
};
constexpr std::array<Shape, 7> kShapes = {{{"SCALAR", 1, 1},
                                           {"VEC2", 1, 2},
                                           {"VEC3", 1, 3},
                                           {"VEC4", 1, 4},
                                           {"MAT2", 2, 2},
                                           {"MAT3", 3, 3},
                                           {"MAT4", 4, 4}}};

/// `count` elements (at least 1) of `element_bytes`, `stride` apart, from `offset`, end within
/// `size` bytes. All are JSON integers of at most 2^53; the product is formed only once it is known
/// to be smaller than size.
bool fits(std::uint64_t offset, std::uint64_t stride, std::uint64_t count,
          std::uint64_t element_bytes, std::uint64_t size) {
  if (count - 1 > size / stride) return false;
  return offset + stride * (count - 1) + element_bytes <= size;
}

class AccessorCheck {
 public:
  AccessorCheck(const Json& json, const JsonPath& path)
      : views_(list_field(json, "bufferViews")), path_(path) {}

  Status check_dense(const Json& accessor, const Layout& layout) const {
    const std::uint32_t view_index = index_field(accessor, "bufferView");
    if (view_index == kAbsent) {
      if (accessor.contains("byteOffset")) return fail("byteOffset needs a bufferView");
      return {};
    }
    const Json& view = views_[view_index];
    const std::uint64_t offset = unsigned_field(accessor, "byteOffset");
    const std::uint64_t stride = unsigned_field(view, "byteStride", layout.element_bytes);
    if (stride < layout.element_bytes) {
      return fail("elements of " + std::to_string(layout.element_bytes) +
                  " bytes do not fit the bufferView's byteStride of " + std::to_string(stride));
    }
    const std::uint64_t start = unsigned_field(view, "byteOffset");
    const std::uint64_t alignment = layout.rows == layout.components ? layout.component_bytes : 4;
    if (offset % layout.component_bytes != 0 || (start + offset) % alignment != 0 ||
        stride % layout.component_bytes != 0) {
      return fail("is not aligned to its component size");
    }
    return check_fit(view, offset, stride, layout.count, layout.element_bytes);
  }

  Status check_sparse(const Json& sparse, const Layout& layout) const {
    const std::uint64_t count = unsigned_field(sparse, "count");
    if (count > layout.count) return fail("has more sparse values than elements");
    const Json& indices = sparse["indices"];
    const std::uint32_t index_bytes =
        component_bytes(indices["componentType"].get<std::uint32_t>());
    LB_RETURN_IF_ERROR(check_part(indices, index_bytes, index_bytes, count));
    return check_part(sparse["values"], layout.element_bytes, layout.component_bytes, count);
  }

 private:
  Status fail(const std::string& message) const {
    return malformed(path_.text(), "the accessor " + message);
  }

  Status check_part(const Json& part, std::uint64_t element_bytes, std::uint64_t alignment,
                    std::uint64_t count) const {
    const Json& view = views_[part["bufferView"].get<std::size_t>()];
    if (view.contains("byteStride")) return fail("has sparse data in a view with a byteStride");
    const std::uint64_t offset = unsigned_field(part, "byteOffset");
    if ((unsigned_field(view, "byteOffset") + offset) % alignment != 0) {
      return fail("has sparse data that is not aligned");
    }
    return check_fit(view, offset, element_bytes, count, element_bytes);
  }

  Status check_fit(const Json& view, std::uint64_t offset, std::uint64_t stride,
                   std::uint64_t count, std::uint64_t element_bytes) const {
    const std::uint64_t size = unsigned_field(view, "byteLength");
    if (fits(offset, stride, count, element_bytes, size)) return {};
    return fail("runs past its bufferView of " + std::to_string(size) + " bytes with " +
                std::to_string(count) + " elements from byte " + std::to_string(offset));
  }

  const Json& views_;
  const JsonPath& path_;
};

}  // namespace

std::uint32_t component_bytes(std::uint32_t component_type) {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

std::optional<Layout> layout_of(const Json& accessor) {
  const std::string& type = accessor["type"].get_ref<const std::string&>();
  for (const Shape& shape : kShapes) {
    if (shape.name != type) continue;
    Layout layout;
    layout.component_type = accessor["componentType"].get<std::uint32_t>();
    layout.component_bytes = component_bytes(layout.component_type);
    layout.components = shape.columns * shape.rows;
    layout.rows = shape.rows;
    layout.column_bytes = shape.rows * layout.component_bytes;
    if (shape.columns > 1) layout.column_bytes = (layout.column_bytes + 3) / 4 * 4;
    layout.element_bytes = shape.columns * layout.column_bytes;
    layout.count = accessor["count"].get<std::uint64_t>();
    layout.normalized = bool_field(accessor, "normalized");
    return layout;
  }
  return std::nullopt;
}

bool is_index_layout(const Layout& layout) {
  return layout.components == 1 && (layout.component_type == 5121 ||
                                    layout.component_type == 5123 || layout.component_type == 5125);
}

Status check_buffer_views(const Json& json, const JsonPath& root,
                          std::vector<std::string>& warnings) {
  const Json& buffers = list_field(json, "buffers");
  const Json& views = list_field(json, "bufferViews");
  const JsonPath list(root, "bufferViews");
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Json& view = views[i];
    const JsonPath path(list, i);
    const std::uint64_t offset = unsigned_field(view, "byteOffset");
    const std::uint64_t length = unsigned_field(view, "byteLength");
    const std::uint64_t size =
        unsigned_field(buffers[view["buffer"].get<std::size_t>()], "byteLength");
    if (offset > size || length > size - offset) {
      return malformed(path.text(), "the bufferView (" + std::to_string(length) +
                                        " bytes from byte " + std::to_string(offset) +
                                        ") runs past its buffer of " + std::to_string(size) +
                                        " bytes");
    }
    if (!view.contains("byteStride")) continue;
    const std::uint64_t stride = unsigned_field(view, "byteStride");
    if (stride % 4 != 0) warnings.push_back(path.text() + ": byteStride is not a multiple of 4");
    if (stride > length) warnings.push_back(path.text() + ": byteStride is larger than the view");
    if (unsigned_field(view, "target") == 34963) {
      warnings.push_back(path.text() + ": a view of indices has a byteStride");
    }
  }
  return {};
}

Status check_accessors(const Json& json, const JsonPath& root, std::uint64_t* zero_bytes,
                       std::vector<std::string>& warnings) {
  const Json& accessors = list_field(json, "accessors");
  const JsonPath list(root, "accessors");
  for (std::size_t i = 0; i < accessors.size(); ++i) {
    const Json& accessor = accessors[i];
    const JsonPath path(list, i);
    const std::optional<Layout> layout = layout_of(accessor);
    if (!layout) {
      warnings.push_back(path.text() + ": unknown type " + accessor["type"].dump());
      continue;
    }
    if (layout->normalized && layout->component_type >= 5125) {
      warnings.push_back(path.text() + ": normalized is ignored for this component type");
    }
    const AccessorCheck check(json, path);
    LB_RETURN_IF_ERROR(check.check_dense(accessor, *layout));
    if (const auto sparse = accessor.find("sparse"); sparse != accessor.end()) {
      LB_RETURN_IF_ERROR(check.check_sparse(*sparse, *layout));
    }
    if (!accessor.contains("bufferView")) {
      // At most 2^53 elements of 64 bytes; the sum stops far below overflow.
      constexpr std::uint64_t kEnough = std::uint64_t{1} << 60;
      *zero_bytes = std::min(kEnough, *zero_bytes + layout->count * layout->element_bytes);
    }
  }
  return {};
}

}  // namespace lightbatch::gltf
