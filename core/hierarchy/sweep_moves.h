// Nodes written, and records moved to their side of a split; included by sweep_impl.h only.

LB_INLINE void write_box(TreeNode& node, V8f box, std::uint32_t first, std::uint32_t count) {
  store_box(&node, __builtin_shufflevector(box, -box, 0, 1, 2, 3, 12, 13, 14, 15));
  node.first = first;
  node.count = count;
}

/// Moves r[0, count) to the two outputs, stably, without a branch on the outcome: a record goes
/// to the left if it comes before `edge`, the first one on the right, in the order of the axis.
template <bool kTies>
void distribute(const Record* r, std::size_t count, const Record& edge, std::uint32_t axis,
                Record* left, Record* right) {
  const float limit = edge.key(axis);
  auto to = reinterpret_cast<std::uintptr_t>(left);
  auto other = reinterpret_cast<std::uintptr_t>(right);
  for (std::size_t k = 0; k < count; ++k) {
    const float key = r[k].key(axis);
    bool to_left = key < limit;
    if constexpr (kTies) to_left |= (key == limit) & (r[k].tagged_id < edge.tagged_id);
    const std::uintptr_t mask = std::uintptr_t{0} - static_cast<std::uintptr_t>(to_left);
    const std::uintptr_t target = other ^ ((to ^ other) & mask);
    store_box(reinterpret_cast<Record*>(target), load_box(r + k));
    to += sizeof(Record) & mask;
    other += sizeof(Record) & ~mask;
  }
}

/// Two lists at once, so that the processor has more to do at a time; the left parts stay in place.
/// Every record is stored on both sides, and only those that belong there move the end on: what is
/// stored in vain lies where the next one goes, or just past the end of the right part, which is
/// put back.
template <bool kTies>
void distribute_two(std::array<Record*, 2> lists, std::array<Record*, 2> right_lists,
                    std::size_t count, std::size_t right_count, const Record& edge,
                    std::uint32_t axis) {
  const float limit = edge.key(axis);
  Record *const a = lists[0], *const b = lists[1];
  Record *const right_a = right_lists[0], *const right_b = right_lists[1];
  const V8f past_a = load_box(right_a + right_count), past_b = load_box(right_b + right_count);
  // In bytes.
  const auto from_a = reinterpret_cast<std::uintptr_t>(a),
             from_b = reinterpret_cast<std::uintptr_t>(b);
  const auto to_a = reinterpret_cast<std::uintptr_t>(right_a),
             to_b = reinterpret_cast<std::uintptr_t>(right_b);
  std::uintptr_t left_a = 0, left_b = 0;
  const auto record_at = [](std::uintptr_t place)
                             LB_LAMBDA_INLINE { return reinterpret_cast<Record*>(place); };
  for (std::uintptr_t at = 0; at < count * sizeof(Record); at += sizeof(Record)) {
    const Record &one = *record_at(from_a + at), &other = *record_at(from_b + at);
    const float key_a = one.key(axis), key_b = other.key(axis);
    bool is_left_a = key_a < limit, is_left_b = key_b < limit;
    if constexpr (kTies) {
      is_left_a |= (key_a == limit) & (one.tagged_id < edge.tagged_id);
      is_left_b |= (key_b == limit) & (other.tagged_id < edge.tagged_id);
    }
    const V8f box_a = load_box(&one), box_b = load_box(&other);
    store_box(record_at(from_a + left_a), box_a);
    store_box(record_at(to_a + at - left_a), box_a);
    store_box(record_at(from_b + left_b), box_b);
    store_box(record_at(to_b + at - left_b), box_b);
    left_a += std::uintptr_t{is_left_a} * sizeof(Record);
    left_b += std::uintptr_t{is_left_b} * sizeof(Record);
  }
  store_box(right_a + right_count, past_a);
  store_box(right_b + right_count, past_b);
}
