// Splits of nodes too large for sorted lists near a core; included by sweep_impl.h only.
//
// Records lie in the order of their ids. On each axis the range of the centres is cut into bins,
// which are to the sorted list what blocks are: splits between bins are costed exactly, those
// inside are bounded, and only bins that may hold the best are looked into: cut into finer bins,
// and what is still in doubt sorted and swept. So the split is that of the full sweep, and the sort
// of most primitives is put off until it fits the caches.

/// A node by its records, and where its subtree goes.
struct Part {
  Record range;  // a box that holds all its boxes
  std::uint32_t begin = 0;
  std::uint32_t count = 0;
  std::uint32_t place = 0;
  int depth = 0;
  bool in_tree = false;  // where the records are

  bool operator<(const Part& other) const { return count < other.count; }
};

/// Where parts keep their records: level by level in memory of their own, and in the nodes of their
/// subtree, which are written last. The bins of the records are always in the nodes.
struct PartMemory {
  Record* apart;
  TreeNode* nodes;

  Record* records(const Part& part) const {
    return part.in_tree ? reinterpret_cast<Record*>(nodes + part.place + part.count - 1)
                        : apart + part.begin;
  }
  /// Between the root of the subtree and the records.
  std::uint16_t* codes(const Part& part, std::size_t axis) const {
    return reinterpret_cast<std::uint16_t*>(nodes + part.place + 1) + axis * part.count;
  }
};
static_assert(sizeof(Record) == sizeof(TreeNode) && 3 * sizeof(std::uint16_t) < sizeof(Record) / 3);

class BinSplit {
 public:
  BinSplit(const PartMemory& memory, int threads)
      : memory_(memory), threads_(static_cast<std::size_t>(threads)) {}

  /// Splits the node, which has more than two records, and moves them. False, and nothing done, if
  /// bins tell too little.
  bool operator()(const Part& part, std::array<Part, 2>& children) {
    part_ = &part;
    records_ = memory_.records(part);
    chunk_ = std::max(kLeastChunk, (part.count + threads_ - 1) / threads_);
    range_ = allowed_positions(part.count, part.depth);
    if (range_.first > 1 || !place_bins()) return false;
    fill_bins();
    merge_bins();
    Split best = Split::middle(part.count);
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      scan_blocks(kBins, empty_box(), empty_box(), blocks_[axis], binned(axis).context, best);
    }
    if (!sweep_doubtful(best)) return false;
    if (!(best.cost < std::numeric_limits<float>::infinity())) return false;
    divide(best, children);
    return true;
  }

 private:
  static constexpr std::size_t kLeastChunk = 8192;
  static constexpr std::uint32_t kMostDoubtful = 4;      // a fraction: one in so many
  static constexpr std::uint32_t kFewForThreads = 8192;  // records

  /// How centres and places are mapped to bins, monotonely. Where all centres are the same, the
  /// order is that of the ids.
  bool place_bins() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float low = 2 * part_->range.lower[axis], high = -2 * part_->range.negated_upper[axis];
      const float extent = high - low;
      if (!(extent < std::numeric_limits<float>::infinity())) return false;
      flat_[axis] = extent == 0;
      low_[axis] = low;
      scale_[axis] = flat_[axis] ? 0.0f : static_cast<float>(kBins) / extent;
      place_scale_[axis] =
          flat_[axis] ? static_cast<float>(kBins) / static_cast<float>(part_->count) : 0.0f;
      if (!(scale_[axis] < std::numeric_limits<float>::infinity())) return false;
    }
    return true;
  }

  /// Results do not depend on the number of chunks.
  std::size_t chunks() const { return (part_->count + chunk_ - 1) / chunk_; }
  template <typename Body>
  void each_chunk(Body body) const {
    parallel_for(part_->count, chunk_,
                 [&](std::size_t begin, std::size_t end) { body(begin / chunk_, begin, end); });
  }

  /// The last place of `bin` is a count, an integer.
  static LB_INLINE V8f unite_and_count(V8f bin, V8f box) {
    const V8f more = reinterpret_cast<V8f>(reinterpret_cast<V8i>(bin) + 1);
    return __builtin_shufflevector(unite(bin, box), more, 0, 1, 2, 3, 4, 5, 6, 15);
  }

  /// Two sets of bins a chunk, one for each half of it, filled in turn: neighbours often fall into
  /// one bin, and would wait for each other.
  void fill_bins() {
    boxes_.resize(2 * chunks() * 3 * kBins);
    each_chunk([&](std::size_t chunk, std::size_t begin, std::size_t end) {
      Record* const boxes = boxes_.data() + chunk * 6 * kBins;
      V8f empty = empty_box();
      empty[7] = 0;
      for (std::size_t i = 0; i < 6 * kBins; ++i) store_box(boxes + i, empty);
      const V4f low = low_, scale = scale_, place_scale = place_scale_;
      const V4i last = V4i{} + static_cast<std::int32_t>(kBins - 1);
      const Record* const records = records_;
      std::uint16_t* const codes[3] = {memory_.codes(*part_, 0), memory_.codes(*part_, 1),
                                       memory_.codes(*part_, 2)};
      const auto add = [&](std::size_t i, std::size_t set) {
        const V8f box = load_box(records + i);
        const V4f key = __builtin_shufflevector(box, box, 0, 1, 2, 3) -
                        __builtin_shufflevector(box, box, 4, 5, 6, 7);
        const V4f place = V4f{} + static_cast<float>(static_cast<std::int32_t>(i));
        V4i code = __builtin_convertvector((key - low) * scale + place * place_scale, V4i);
        code = code < last ? code : last;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto bin = static_cast<std::size_t>(static_cast<std::uint32_t>(code[axis]));
          const std::size_t to = (set + axis) * kBins + bin;
          store_box(boxes + to, unite_and_count(load_box(boxes + to), box));
          codes[axis][i] = static_cast<std::uint16_t>(bin);
        }
      };
      const std::size_t half = (end - begin) / 2;
      for (std::size_t i = begin; i < begin + half; ++i) {
        add(i, 0);
        add(i + half, 3);
      }
      if (begin + 2 * half < end) add(end - 1, 3);
    });
  }

  void merge_bins() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Blocks& blocks = blocks_[axis];
      blocks.resize(kBins);
      std::uint32_t sum = 0;
      for (std::size_t b = 0; b < kBins; ++b) {
        V8f box = empty_box();
        blocks.starts[b] = sum;
        for (std::size_t set = 0; set < 2 * chunks(); ++set) {
          const std::size_t i = (set * 3 + axis) * kBins + b;
          box = unite(load_box(&boxes_[i]), box);
          sum += boxes_[i].one;
        }
        store_box(&blocks.boxes[b], box);
      }
      blocks.starts[kBins] = sum;
    }
  }

  BinnedAxis binned(std::uint32_t axis) const {
    return {records_,
            memory_.codes(*part_, axis),
            {part_->count, axis, range_},
            low_[axis],
            scale_[axis],
            place_scale_[axis],
            blocks_[axis]};
  }

  /// Sweeps the bins that may hold the best split. False if they hold too many records.
  bool sweep_doubtful(Split& best) {
    std::uint32_t sum = 0;
    for (std::uint32_t axis = 0; axis < 3; ++axis) sum += doubtful_[axis].find(binned(axis), best);
    if (sum > part_->count / kMostDoubtful) return false;
    std::array<Split, 3> splits{best, best, best};
    // Threads take longer to wake than few records to be looked through.
    parallel_for(3, sum < kFewForThreads ? 3 : 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t axis = begin; axis < end; ++axis) {
        doubtful_[axis].sweep(binned(static_cast<std::uint32_t>(axis)), splits[axis]);
      }
    });
    for (const Split& split : splits) {
      best.offer(split.cost, split.axis, split.position, split.rank);
    }
    return true;
  }

  struct Cut {
    Record edge;                     // the first on the right
    bool ties;                       // others of its centre may be on the left
    std::vector<std::size_t> lefts;  // records on the left before each chunk
  };

  /// `b`: the bin of the first on the right.
  Cut cut(const Split& best, std::size_t b) {
    const std::size_t axis = best.axis;
    const std::size_t k = best.position - blocks_[axis].starts[b];
    const std::span<const std::uint64_t> order =
        doubtful_[axis].divided(binned(best.axis), static_cast<std::uint32_t>(b), k);
    bool ties = flat_[axis];
    for (std::size_t i = 0; i < k; ++i) ties |= order[i] >> 32 == order[k] >> 32;
    Cut result{records_[static_cast<std::uint32_t>(order[k])], ties,
               std::vector<std::size_t>(chunks() + 1)};
    for (std::size_t set = 0; set < 2 * chunks(); ++set) {
      const Record* const bins = boxes_.data() + (set * 3 + axis) * kBins;
      for (std::size_t i = 0; i < b; ++i) result.lefts[set / 2 + 1] += bins[i].one;
    }
    for (std::size_t i = 0; i < k; ++i) {
      ++result.lefts[static_cast<std::uint32_t>(order[i]) / chunk_ + 1];
    }
    std::partial_sum(result.lefts.begin(), result.lefts.end(), result.lefts.begin());
    return result;
  }

  void divide(const Split& best, std::array<Part, 2>& children) {
    const Part& part = *part_;
    const Blocks& blocks = blocks_[best.axis];
    std::size_t b = 0;  // the bin of the first on the right
    while (blocks.starts[b + 1] <= best.position) ++b;
    write_box(memory_.nodes[part.place], load_box(&blocks.suffix[0]), part.begin, part.count);
    children = {part, part};
    children[0].range = blocks.prefix[b + (best.position == blocks.starts[b] ? 0 : 1)];
    children[0].count = best.position;
    children[0].place = part.place + 1;
    children[1].range = blocks.suffix[b];
    children[1].begin += best.position;
    children[1].count -= best.position;
    children[1].place = part.place + 2 * best.position;
    for (Part& child : children) {
      ++child.depth;
      child.in_tree = !part.in_tree;
    }
    const Cut at = cut(best, b);
    Record* const to_left = memory_.records(children[0]);
    Record* const to_right = memory_.records(children[1]);
    each_chunk([&](std::size_t chunk, std::size_t begin, std::size_t end) {
      Record* left = to_left + at.lefts[chunk];
      Record* right = to_right + (begin - at.lefts[chunk]);
      if (at.ties) {
        distribute<true>(records_ + begin, end - begin, at.edge, best.axis, left, right);
      } else {
        distribute<false>(records_ + begin, end - begin, at.edge, best.axis, left, right);
      }
    });
  }

  PartMemory memory_;
  std::size_t threads_;
  // Of the node at hand.
  const Part* part_ = nullptr;
  const Record* records_ = nullptr;
  std::size_t chunk_ = 0;
  PositionRange range_{};
  V4f low_{}, scale_{}, place_scale_{};
  std::array<bool, 3> flat_{};
  LargeVector<Record> boxes_;  // by half chunk, axis, bin; `one` is the number of records
  NodeBlocks blocks_;
  std::array<DoubtfulBins, 3> doubtful_;
};
