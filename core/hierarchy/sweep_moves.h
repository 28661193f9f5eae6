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

/// Two lists at once, so that the processor has more to do at a time.
template <bool kTies>
void distribute_two(std::array<Record*, 2> lists, std::array<Record*, 2> right_lists,
                    std::size_t count, const Record& edge, std::uint32_t axis) {
  const float limit = edge.key(axis);
  const Record* a = lists[0];
  const Record* b = lists[1];
  auto to_a = reinterpret_cast<std::uintptr_t>(lists[0]);
  auto to_b = reinterpret_cast<std::uintptr_t>(lists[1]);
  auto other_a = reinterpret_cast<std::uintptr_t>(right_lists[0]);
  auto other_b = reinterpret_cast<std::uintptr_t>(right_lists[1]);
  for (std::size_t k = 0; k < count; ++k) {
    const float key_a = a[k].key(axis), key_b = b[k].key(axis);
    bool left_a = key_a < limit, left_b = key_b < limit;
    if constexpr (kTies) {
      left_a |= (key_a == limit) & (a[k].tagged_id < edge.tagged_id);
      left_b |= (key_b == limit) & (b[k].tagged_id < edge.tagged_id);
    }
    const std::uintptr_t mask_a = std::uintptr_t{0} - static_cast<std::uintptr_t>(left_a);
    const std::uintptr_t mask_b = std::uintptr_t{0} - static_cast<std::uintptr_t>(left_b);
    store_box(reinterpret_cast<Record*>(other_a ^ ((to_a ^ other_a) & mask_a)), load_box(a + k));
    store_box(reinterpret_cast<Record*>(other_b ^ ((to_b ^ other_b) & mask_b)), load_box(b + k));
    to_a += sizeof(Record) & mask_a;
    to_b += sizeof(Record) & mask_b;
    other_a += sizeof(Record) & ~mask_a;
    other_b += sizeof(Record) & ~mask_b;
  }
}

template <bool kTies>
std::size_t count_left(const Record* r, std::size_t count, const Record& edge, std::uint32_t axis) {
  const float limit = edge.key(axis);
  std::size_t sum = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const float key = r[k].key(axis);
    bool to_left = key < limit;
    if constexpr (kTies) to_left |= (key == limit) & (r[k].tagged_id < edge.tagged_id);
    sum += to_left;
  }
  return sum;
}
