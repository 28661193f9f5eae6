// Whole subtrees of at most eight primitives; included by sweep_impl.h only, where the instruction
// set has byte shuffles and bit gathering (BMI2).
//
// Records stay where they are. On each axis the order of a node's primitives is a word of bytes,
// their places among the eight; a split divides such a word by comparing places with that of the
// first primitive on the right, which is the order of the list, ties included.

constexpr std::uint32_t kSmallTree = 8;

class SmallTree {
 public:
  SmallTree(const std::array<const Record*, 3>& lists, std::uint32_t n, TreeArrays& tree)
      : records_(lists[0]), tree_(tree) {
    // Slots past the end hold no primitive's id.
    alignas(32) std::uint32_t ids[kSmallTree] = {};
    for (std::uint32_t k = 0; k < n; ++k) ids[k] = lists[0][k].tagged_id;
    const __m256i own = _mm256_load_si256(reinterpret_cast<const __m256i*>(ids));
    root_.order[0] = ranks_[0] = 0x0706050403020100u;
    for (std::size_t axis = 1; axis < 3; ++axis) {
      std::uint64_t order = 0, ranks = 0;
      for (std::uint32_t k = 0; k < n; ++k) {
        const __m256i id = _mm256_set1_epi32(static_cast<int>(lists[axis][k].tagged_id));
        const int equal = _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(own, id)));
        const auto slot =
            static_cast<std::uint64_t>(std::countr_zero(static_cast<unsigned>(equal)));
        order |= slot << (8 * k);
        ranks |= std::uint64_t{k} << (8 * slot);
      }
      root_.order[axis] = order;
      ranks_[axis] = ranks;
    }
    root_.count = n;
  }

  void write(std::uint32_t begin, std::uint32_t place) {
    root_.begin = begin;
    root_.place = place;
    std::array<Part, kSmallTree + 1> stack;
    std::size_t size = 0;
    Part part = root_;
    while (true) {
      if (part.count > 2) {
        stack[size] = part;
        split(stack[size], part);
        ++size;
        continue;
      }
      write_few(part);
      if (size == 0) return;
      part = stack[--size];
    }
  }

 private:
  struct Part {
    std::array<std::uint64_t, 3> order;  // slots, a byte each
    std::uint32_t count, begin, place;
  };

  const Record& record(std::uint64_t order, std::uint32_t k) const {
    return records_[(order >> (8 * k)) & 7u];
  }

  /// Turns `right` (a whole node) into its right child and sets the left one.
  void split(Part& right, Part& left) {
    switch (right.count) {
      case 3:
        return split_n<3>(right, left);
      case 4:
        return split_n<4>(right, left);
      case 5:
        return split_n<5>(right, left);
      case 6:
        return split_n<6>(right, left);
      case 7:
        return split_n<7>(right, left);
      default:
        return split_n<8>(right, left);
    }
  }

  template <std::uint32_t n>
  void split_n(Part& node, Part& left) {
    constexpr std::uint32_t kGroups = (n - 1 + 3) / 4;
    V4f cost[3][kGroups];
    V4f least = infinite4();
    V8f all = empty_box();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      V8f box[n];
      for (std::uint32_t k = 0; k < n; ++k) box[k] = load_box(&record(node.order[axis], k));
      V4f before[4 * kGroups], after[4 * kGroups];  // [k]: position k + 1
      V8f sum = box[0];
      for (std::uint32_t k = 0; k + 1 < n; ++k) {
        before[k] = negated_extent(sum);
        sum = unite(box[k + 1], sum);
      }
      if (axis == 0) all = sum;
      sum = box[n - 1];
      for (std::uint32_t k = n - 1; k-- > 0;) {
        after[k] = negated_extent(sum);
        sum = unite(box[k], sum);
      }
      // Past the last position a cost of infinity or NaN, which is never the least.
      for (std::uint32_t k = n - 1; k < 4 * kGroups; ++k) before[k] = after[k] = infinite4();
      for (std::uint32_t g = 0; g < kGroups; ++g) {
        const float k = static_cast<float>(4 * g + 1), m = static_cast<float>(n) - k;
        const V4f many_left{k, k + 1, k + 2, k + 3}, many_right{m, m - 1, m - 2, m - 3};
        const V4f* b = before + 4 * g;
        const V4f* a = after + 4 * g;
        cost[axis][g] = areas_of(b[0], b[1], b[2], b[3]) * many_left +
                        areas_of(a[0], a[1], a[2], a[3]) * many_right;
        least = cost[axis][g] < least ? cost[axis][g] : least;
      }
    }
    const float best = least_of(least);
    Split split = Split::middle(n);
    if (best < std::numeric_limits<float>::infinity()) {
      std::array<std::uint64_t, 3> where{};
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::uint32_t g = 0; g < kGroups; ++g) where[i] |= mask4(cost[i][g] == best) << 4 * g;
        where[i] &= (1u << (n - 1)) - 1;
      }
      split = nearest_to_middle(where, best, n);
    }
    const std::uint32_t position = split.position;
    write_node(all, node.begin, n, node.place);
    left.begin = node.begin;
    left.place = node.place + 1;
    left.count = position;
    divide(node, left, split.axis, position);
    node.begin += position;
    node.place += 2 * position;
    node.count = n - position;
  }

  void divide(Part& node, Part& left, std::uint32_t axis, std::uint32_t position) const {
    const std::uint64_t edge = (node.order[axis] >> (8 * position)) & 7u;
    const auto edge_rank = static_cast<char>((ranks_[axis] >> (8 * edge)) & 7u);
    const __m128i ranks = _mm_cvtsi64_si128(static_cast<long long>(ranks_[axis]));
    const std::uint64_t valid = ~std::uint64_t{0} >> (64 - 8 * node.count);
    for (std::uint64_t i = 0; i < 3; ++i) {
      const std::uint64_t order = node.order[i];
      const __m128i place =
          _mm_shuffle_epi8(ranks, _mm_cvtsi64_si128(static_cast<long long>(order)));
      const auto on_left = static_cast<std::uint64_t>(
          _mm_cvtsi128_si64(_mm_cmpgt_epi8(_mm_set1_epi8(edge_rank), place)));
      left.order[i] = _pext_u64(order, on_left & valid);
      node.order[i] = _pext_u64(order, ~on_left & valid);
    }
  }

  void write_node(V8f box, std::uint32_t begin, std::uint32_t count, std::uint32_t place) {
    write_box(tree_.nodes[place], box, begin, count);
  }
  void write_few(const Part& part) {
    const Record& first = record(part.order[0], 0);
    std::uint32_t place = part.place;
    if (part.count == 2) {
      const Record& second = record(part.order[0], 1);
      write_node(unite(load_box(&first), load_box(&second)), part.begin, 2, place++);
      write_leaf(second, part.begin + 1, place + 1);
    }
    write_leaf(first, part.begin, place);
  }
  void write_leaf(const Record& record, std::uint32_t begin, std::uint32_t place) {
    tree_.primitives[begin] = record.id();
    write_node(load_box(&record), begin, 1, place);
  }

  const Record* records_;
  TreeArrays& tree_;
  std::array<std::uint64_t, 3> ranks_;  // of each slot on each axis
  Part root_;
};
