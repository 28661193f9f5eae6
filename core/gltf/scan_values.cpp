#include "core/gltf/scan_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/parallel.h"
#include "core/gltf/elements.h"

namespace lightbatch::gltf {
namespace {

/// Accessors may overlap; sound files look at a byte a few times at most.
constexpr std::uint64_t kLooksPerByte = 64;
constexpr std::uint64_t kFreeBytes = 1 << 20;

/// Smallest and largest stored value of each component (integers not normalised).
struct Range {
  std::array<double, 16> low;
  std::array<double, 16> high;
  bool finite = true;
};

template <typename T>
void widen(const Layout& layout, const std::byte* element, Range& range) {
  for (std::uint32_t i = 0; i < layout.components; ++i) {
    const std::uint32_t column = i / layout.rows;
    const std::uint32_t row = i % layout.rows;
    const auto value =
        static_cast<double>(load<T>(element + column * layout.column_bytes + row * sizeof(T)));
    if constexpr (std::is_same_v<T, float>) range.finite = range.finite && std::isfinite(value);
    range.low[i] = std::min(range.low[i], value);
    range.high[i] = std::max(range.high[i], value);
  }
}

template <typename T>
Range scan(const Document& document, std::uint32_t accessor, const Elements& elements) {
  Range range;
  range.low.fill(std::numeric_limits<double>::infinity());
  range.high.fill(-std::numeric_limits<double>::infinity());
  static constexpr std::array<std::byte, 64> kZeros{};
  const SparseLookup sparse(document, accessor, elements.layout);
  for (std::uint64_t i = 0; i < elements.layout.count; ++i) {
    const std::byte* element = sparse.find(i);
    if (element == nullptr) {
      element = elements.data == nullptr ? kZeros.data() : elements.data + i * elements.stride;
    }
    widen<T>(elements.layout, element, range);
  }
  return range;
}

Range scan_any(const Document& document, std::uint32_t accessor, const Elements& elements) {
  switch (elements.layout.component_type) {
    case 5120:
      return scan<std::int8_t>(document, accessor, elements);
    case 5121:
      return scan<std::uint8_t>(document, accessor, elements);
    case 5122:
      return scan<std::int16_t>(document, accessor, elements);
    case 5123:
      return scan<std::uint16_t>(document, accessor, elements);
    case 5125:
      return scan<std::uint32_t>(document, accessor, elements);
    default:
      return scan<float>(document, accessor, elements);
  }
}

/// Whether a bound in the JSON, rounded to the stored type, is the one of the data.
bool agrees(const Json& bound, const std::array<double, 16>& found, bool is_float) {
  for (std::size_t i = 0; i < bound.size(); ++i) {
    double value = bound[i].get<double>();
    if (is_float) value = static_cast<double>(static_cast<float>(value));
    if (value != found[i]) return false;
  }
  return true;
}

Json bound_of(const std::array<double, 16>& found, std::uint32_t components) {
  return std::vector<double>(found.begin(), found.begin() + components);
}

}  // namespace

Status scan_values(Document& document, const JsonPath& root,
                   const std::vector<std::uint32_t>& decoded, std::vector<std::string>& warnings) {
  const auto found = document.json.find("accessors");
  if (found == document.json.end()) return {};
  Json& accessors = *found;
  const JsonPath list(root, "accessors");

  // Which to look at, and whether that is affordable.
  std::uint64_t budget = kFreeBytes;
  for (const Bytes& buffer : document.buffers) budget += kLooksPerByte * buffer.size();
  std::vector<std::uint32_t> tasks;
  std::vector<Elements> elements;
  for (std::uint32_t i = 0; i < accessors.size(); ++i) {
    Result<Elements> data = elements_of(document, i);
    if (!data.ok()) continue;  // unknown type, or no data and no user
    if (data->data == nullptr && !accessors[i].contains("sparse")) continue;
    const std::uint64_t bytes = data->layout.count * data->layout.element_bytes;
    if (bytes > budget) {
      return over_budget(JsonPath(list, i).text(), "accessors overlap more than sound files do");
    }
    budget -= bytes;
    tasks.push_back(i);
    elements.push_back(*data);
  }
  std::vector<Range> ranges(tasks.size());
  parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      ranges[t] = scan_any(document, tasks[t], elements[t]);
    }
  });

  std::vector<bool> from_stream(accessors.size(), false);
  for (const std::uint32_t accessor : decoded) from_stream[accessor] = true;
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    const JsonPath path(list, tasks[t]);
    Json& accessor = accessors[tasks[t]];
    const Layout& layout = elements[t].layout;
    if (!ranges[t].finite)
      return malformed(path.text(), "the accessor holds values that are not finite");
    if (from_stream[tasks[t]]) {
      if (accessor.contains("min")) accessor["min"] = bound_of(ranges[t].low, layout.components);
      if (accessor.contains("max")) accessor["max"] = bound_of(ranges[t].high, layout.components);
      continue;
    }
    const bool is_float = layout.component_type == 5126;
    for (const char* name : {"min", "max"}) {
      const auto bound = accessor.find(name);
      if (bound == accessor.end()) continue;
      if (bound->size() != layout.components) {
        return malformed(path.text() + "/" + name, "needs one number for each component");
      }
      if (!agrees(*bound, name[1] == 'i' ? ranges[t].low : ranges[t].high, is_float)) {
        warnings.push_back(path.text() + "/" + name + ": differs from the data");
      }
    }
  }
  return {};
}

}  // namespace lightbatch::gltf
