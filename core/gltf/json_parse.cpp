#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

#include "core/gltf/json_text.h"

namespace lightbatch::gltf {
namespace {

/// Memory a value of each kind takes in Json, roughly: the value itself sits in its parent.
constexpr std::uint64_t kValueBytes = sizeof(Json);
constexpr std::uint64_t kContainerBytes = 64;
constexpr std::uint64_t kMemberBytes = 80;  // map node with its key, beside the value

/// Builds the tree from the parser's events, so that depth and size are known before they exist.
class TreeBuilder : public nlohmann::json_sax<Json> {
 public:
  TreeBuilder(int depth, std::uint64_t max_memory) : max_depth_(depth), max_memory_(max_memory) {}

  Json take() { return std::move(root_); }
  /// Empty when nothing went wrong; the reason is over budget rather than malformed when
  /// over_budget() says so.
  const std::string& error() const { return error_; }
  bool is_over_budget() const { return over_budget_; }
  std::size_t error_offset() const { return error_offset_; }
  bool has_offset() const { return has_offset_; }

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(std::int64_t value) override { return add(value); }
  bool number_unsigned(std::uint64_t value) override { return add(value); }
  bool number_float(double value, const std::string&) override { return add(value); }
  bool string(std::string& value) override {
    memory_ += value.size();
    return add(std::move(value));
  }
  bool binary(Json::binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(std::string& name) override {
    memory_ += kMemberBytes + name.size();
    auto& members = *open_.back()->get_ptr<Json::object_t*>();
    const auto [place, added] = members.try_emplace(std::move(name));
    if (!added) return fail("the name \"" + place->first + "\" occurs twice in one object");
    member_ = &place->second;
    return true;
  }

  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::detail::exception& exception) override {
    std::string_view text =
        exception.what();  // "[json.exception...] parse error at line 1...: why"
    const std::size_t start = text.find("] ");
    if (start != std::string_view::npos) text.remove_prefix(start + 2);
    error_ = text;
    error_offset_ = position;
    has_offset_ = true;
    return false;
  }

 private:
  bool fail(std::string message) {
    error_ = std::move(message);
    return false;
  }

  bool within_budget() {
    memory_ += kValueBytes;
    if (memory_ <= max_memory_) return true;
    over_budget_ = true;
    return fail("the JSON text holds too many values");
  }

  template <typename Value>
  Json* place(Value&& value) {
    if (open_.empty()) {
      root_ = std::forward<Value>(value);
      return &root_;
    }
    if (open_.back()->is_object()) {
      *member_ = std::forward<Value>(value);
      return member_;
    }
    auto& items = *open_.back()->get_ptr<Json::array_t*>();
    items.emplace_back(std::forward<Value>(value));
    return &items.back();
  }

  template <typename Value>
  bool add(Value&& value) {
    if (!within_budget()) return false;
    place(std::forward<Value>(value));
    return true;
  }

  bool open(Json container) {
    memory_ += kContainerBytes;
    if (!within_budget()) return false;
    if (open_.size() >= static_cast<std::size_t>(max_depth_)) {
      over_budget_ = true;
      return fail("more than " + std::to_string(max_depth_) +
                  " arrays and objects inside each other");
    }
    open_.push_back(place(std::move(container)));
    return true;
  }

  bool close() {
    open_.pop_back();
    return true;
  }

  int max_depth_;
  std::uint64_t max_memory_;
  std::uint64_t memory_ = 0;
  Json root_;
  std::vector<Json*> open_;
  Json* member_ = nullptr;
  std::string error_;
  std::size_t error_offset_ = 0;
  bool has_offset_ = false;
  bool over_budget_ = false;
};

/// Reads as a pointer does, and tells how far.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, const char** farthest) : at_(at), farthest_(farthest) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    *farthest_ = ++at_;
    return *this;
  }
  bool operator==(const CountingIterator& other) const { return at_ == other.at_; }
  bool operator!=(const CountingIterator& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  const char** farthest_;
};

/// Where the builder refuses a text that it has refused before. The parser does not tell its
/// events where they are.
std::size_t refused_at(std::string_view text, int depth, std::uint64_t max_memory) {
  TreeBuilder builder(depth, max_memory);
  const char* farthest = text.data();
  Json::sax_parse(CountingIterator(text.data(), &farthest),
                  CountingIterator(text.data() + text.size(), &farthest), &builder);
  return static_cast<std::size_t>(farthest - text.data());
}

}  // namespace

Result<Json> parse_json(std::string_view text, const std::string& place, int depth,
                        std::uint64_t max_memory, std::uint64_t base_offset) {
  if (text.starts_with("\xef\xbb\xbf")) {
    return malformed(place + "@" + std::to_string(base_offset),
                     "the JSON text starts with a byte order mark; glTF forbids it");
  }
  TreeBuilder builder(depth, max_memory);
  const bool done = Json::sax_parse(text.begin(), text.end(), &builder);
  if (done && builder.error().empty()) return builder.take();
  const std::size_t offset =
      builder.has_offset() ? builder.error_offset() : refused_at(text, depth, max_memory);
  const std::string where = place + "@" + std::to_string(base_offset + offset);
  if (builder.is_over_budget()) return over_budget(where, builder.error());
  return malformed(where, "not valid JSON: " + builder.error());
}

}  // namespace lightbatch::gltf
