// Splits of nodes too large for sorted lists near a core; included by sweep_impl.h only.
//
// Records lie in the order of their ids. On each axis the range of the centres is cut into bins,
// which are to the sorted list what blocks are: splits between bins are costed exactly, those
// inside are bounded, and only bins that may hold the best are looked into: cut into finer bins,
// and what is still in doubt sorted and swept. So the split is that of the full sweep, and the sort
// of most primitives is put off until it fits the caches.

/// A node by its records, and where its subtree goes.
struct Part {
  V8f range;  // a box that holds all its boxes
  std::uint32_t begin = 0;
  std::uint32_t count = 0;
  std::uint32_t place = 0;
  int depth = 0;
  bool in_tree = false;  // where the records are
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
    const std::size_t pieces = threads_ == 1 ? 1 : 2 * threads_;
    chunk_ = std::max(kLeastChunk, (part.count + pieces - 1) / pieces);
    range_ = allowed_positions(part.count, part.depth);
    if (range_.first > 1 || !place_bins()) return false;
    fill_bins();
    merge_bins();
    Split best = Split::middle(part.count);
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      scan_blocks(kBins, empty_box(), empty_box(), blocks_[axis], context(axis), best);
    }
    if (!sweep_doubtful(best)) return false;
    if (!(best.cost < std::numeric_limits<float>::infinity())) return false;
    divide(best, children);
    return true;
  }

 private:
  static constexpr std::uint32_t kBins = 1024;
  static constexpr std::size_t kLeastChunk = 8192;
  static constexpr std::uint32_t kMostDoubtful = 4;  // a fraction: one in so many
  static constexpr std::size_t kFiner = 64;          // bins in a bin
  static constexpr std::size_t kFewInBin = 256;      // are sorted at once
  static constexpr std::uint32_t kNowhere = 0xffffffffu;

  /// Of one axis: the bins that may hold the best split.
  struct Doubtful {
    std::array<std::uint32_t, kBins> places;  // of each bin among the members, or kNowhere
    std::vector<std::uint32_t> members, grouped;
    std::vector<std::uint8_t> codes;
    Blocks finer, inside;
    std::vector<std::uint64_t> order;
    std::vector<Record> sorted;
  };

  SweepContext context(std::uint32_t axis) const { return {part_->count, axis, range_}; }

  /// How centres and places are mapped to bins, monotonely. Where all centres are the same, the
  /// order is that of the ids.
  bool place_bins() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float low = part_->range[axis] + part_->range[axis],
                  high = -part_->range[axis + 4] - part_->range[axis + 4];
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

  /// Two sets of bins a chunk, one for each half of it, filled in turn: neighbours often fall into
  /// one bin, and would wait for each other.
  void fill_bins() {
    boxes_.resize(2 * chunks() * 3 * kBins);
    counts_.resize(2 * chunks() * 3 * kBins);
    each_chunk([&](std::size_t chunk, std::size_t begin, std::size_t end) {
      Record* const boxes = boxes_.data() + chunk * 6 * kBins;
      std::uint32_t* const counts = counts_.data() + chunk * 6 * kBins;
      for (std::size_t i = 0; i < 6 * kBins; ++i) store_box(boxes + i, empty_box());
      std::fill_n(counts, 6 * kBins, 0u);
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
          store_box(boxes + to, unite(load_box(boxes + to), box));
          ++counts[to];
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
          sum += counts_[i];
        }
        store_box(&blocks.boxes[b], box);
      }
      blocks.starts[kBins] = sum;
    }
  }

  /// Sweeps the bins that may hold the best split. False if they hold too many records.
  bool sweep_doubtful(Split& best) {
    std::uint32_t sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Doubtful& own = doubtful_[axis];
      std::uint32_t count = 0;
      for (std::size_t b = 0; b < kBins; ++b) {
        const bool out = ruled_out(b, blocks_[axis], part_->count, best);
        own.places[b] = out ? kNowhere : count;
        if (!out) count += blocks_[axis].starts[b + 1] - blocks_[axis].starts[b];
      }
      own.members.resize(count);
      sum += count;
    }
    if (sum > part_->count / kMostDoubtful) return false;
    std::array<Split, 3> splits{best, best, best};
    parallel_for(3, 1, [&](std::size_t axis, std::size_t) { sweep_axis(axis, splits[axis]); });
    for (const Split& split : splits) {
      best.offer(split.cost, split.axis, split.position, split.rank);
    }
    return true;
  }

  /// Calls body(record, bin) for the records in bins first to last.
  template <typename Body>
  LB_INLINE void each_in_bins(std::size_t axis, std::uint32_t first, std::uint32_t last,
                              Body body) const {
    constexpr std::size_t kGroup = 32;
    const std::uint16_t* codes = memory_.codes(*part_, axis);
    const auto low = static_cast<std::uint16_t>(first),
               span = static_cast<std::uint16_t>(last - first);
    const auto inside = [&](std::uint16_t code) {
      return static_cast<std::uint16_t>(code - low) <= span;
    };
    const std::size_t count = part_->count;
    for (std::size_t begin = 0; begin < count; begin += kGroup) {
      const std::size_t end = std::min(count, begin + kGroup);
      if (end == begin + kGroup) {
        std::uint16_t any = 0;
        for (std::size_t k = 0; k < kGroup; ++k) {
          any = static_cast<std::uint16_t>(any | (inside(codes[begin + k]) ? 1 : 0));
        }
        if (any == 0) continue;
      }
      for (std::size_t i = begin; i < end; ++i) {
        if (inside(codes[i])) body(i, codes[i]);
      }
    }
  }

  void sweep_axis(std::size_t axis, Split& best) {
    Doubtful& own = doubtful_[axis];
    const auto is_in = [](std::uint32_t place) { return place != kNowhere; };
    const auto& places = own.places;
    const auto first = std::find_if(places.begin(), places.end(), is_in) - places.begin();
    const auto last = places.rend() - std::find_if(places.rbegin(), places.rend(), is_in) - 1;
    if (last < 0) return;
    std::array<std::uint32_t, kBins> next = places;
    each_in_bins(axis, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last),
                 [&](std::size_t i, std::size_t bin) {
                   if (is_in(next[bin])) own.members[next[bin]++] = static_cast<std::uint32_t>(i);
                 });
    for (std::size_t b = 0; b < kBins; ++b) {
      const Blocks& blocks = blocks_[axis];
      if (!is_in(places[b]) || ruled_out(b, blocks, part_->count, best)) continue;
      const std::span members =
          std::span(own.members).subspan(places[b], blocks.starts[b + 1] - blocks.starts[b]);
      const V8f before = load_box(&blocks.prefix[b]), after = load_box(&blocks.suffix[b + 1]);
      if (members.size() <= kFewInBin) {
        sweep_members(axis, members, {blocks.starts[b], before, after}, best);
      } else {
        sweep_finer(axis, b, members, best);
      }
    }
  }

  /// Cuts a bin into finer ones, and does with them as with bins.
  void sweep_finer(std::size_t axis, std::size_t b, std::span<const std::uint32_t> members,
                   Split& best) {
    Doubtful& own = doubtful_[axis];
    Blocks& finer = own.finer;
    finer.resize(kFiner);
    for (std::size_t f = 0; f < kFiner; ++f) store_box(&finer.boxes[f], empty_box());
    std::array<std::uint32_t, kFiner + 1> next{};
    own.codes.resize(members.size());
    own.grouped.resize(members.size());
    for (std::size_t k = 0; k < members.size(); ++k) {
      const Record& record = records_[members[k]];
      // Powers of two change no digit: these codes divide those of the bins.
      const float place = static_cast<float>(static_cast<std::int32_t>(members[k]));
      const float at = (record.key(axis) - low_[axis]) * scale_[axis] + place * place_scale_[axis];
      const std::int32_t code = static_cast<std::int32_t>(at * static_cast<float>(kFiner)) -
                                static_cast<std::int32_t>(b * kFiner);
      const auto f =
          static_cast<std::size_t>(std::clamp(code, 0, static_cast<std::int32_t>(kFiner) - 1));
      store_box(&finer.boxes[f], unite(load_box(&finer.boxes[f]), load_box(&record)));
      own.codes[k] = static_cast<std::uint8_t>(f);
      ++next[f + 1];
    }
    const Blocks& blocks = blocks_[axis];
    for (std::size_t f = 0; f < kFiner; ++f) {
      next[f + 1] += next[f];
      finer.starts[f] = blocks.starts[b] + next[f];
    }
    finer.starts[kFiner] = blocks.starts[b + 1];
    for (std::size_t k = 0; k < members.size(); ++k) {
      own.grouped[next[own.codes[k]]++] = members[k];
    }
    scan_blocks(kFiner, load_box(&blocks.prefix[b]), load_box(&blocks.suffix[b + 1]), finer,
                context(static_cast<std::uint32_t>(axis)), best);
    for (std::size_t f = 0; f < kFiner; ++f) {
      if (ruled_out(f, finer, part_->count, best)) continue;
      sweep_members(
          axis,
          std::span(own.grouped)
              .subspan(finer.starts[f] - blocks.starts[b], finer.starts[f + 1] - finer.starts[f]),
          {finer.starts[f], load_box(&finer.prefix[f]), load_box(&finer.suffix[f + 1])}, best);
    }
  }

  /// What lies outside some members of the list, which begin at position `first` of it.
  struct Around {
    std::uint32_t first;
    V8f before, after;
  };

  void sweep_members(std::size_t axis, std::span<const std::uint32_t> members, const Around& around,
                     Split& best) {
    Doubtful& own = doubtful_[axis];
    sort_members(axis, members, own.order);
    own.sorted.resize(2 * kMargin + members.size());
    Record* const list = own.sorted.data() + kMargin;
    for (std::size_t k = 0; k < members.size(); ++k) {
      list[k] = records_[static_cast<std::uint32_t>(own.order[k])];
    }
    const SweepContext limits = context(static_cast<std::uint32_t>(axis));
    const std::size_t number =
        box_blocks(list, static_cast<std::uint32_t>(members.size()), around.first, own.inside);
    scan_blocks(number, around.before, around.after, own.inside, limits, best);
    sweep_blocks(list, number, own.inside, limits, best);
  }

  /// By key and place.
  void sort_members(std::size_t axis, std::span<const std::uint32_t> members,
                    std::vector<std::uint64_t>& order) const {
    order.resize(members.size());
    for (std::size_t k = 0; k < members.size(); ++k) {
      order[k] = std::uint64_t{ordered_bits(records_[members[k]].key(axis))} << 32 | members[k];
    }
    std::sort(order.begin(), order.end());
  }

  /// The first record on the right, and whether others of its centre may be on the left.
  const Record& first_on_right(const Split& best, std::size_t b, bool& ties) {
    const std::size_t axis = best.axis;
    const Blocks& blocks = blocks_[axis];
    ties = flat_[axis];
    if (ties) return records_[best.position];
    std::vector<std::uint32_t>& members = doubtful_[axis].members;
    std::vector<std::uint64_t>& order = doubtful_[axis].order;
    members.clear();
    const auto bin = static_cast<std::uint32_t>(b);
    each_in_bins(axis, bin, bin, [&](std::size_t i, std::size_t) {
      members.push_back(static_cast<std::uint32_t>(i));
    });
    sort_members(axis, members, order);
    const std::size_t k = best.position - blocks.starts[b];
    ties = k > 0 && order[k - 1] >> 32 == order[k] >> 32;
    return records_[static_cast<std::uint32_t>(order[k])];
  }

  void divide(const Split& best, std::array<Part, 2>& children) {
    const Part& part = *part_;
    const Blocks& blocks = blocks_[best.axis];
    std::size_t b = 0;  // the bin of the first on the right
    while (blocks.starts[b + 1] <= best.position) ++b;
    write_box(memory_.nodes[part.place], load_box(&blocks.suffix[0]), part.begin, part.count);
    children = {part, part};
    children[0].range = load_box(&blocks.prefix[b + (best.position == blocks.starts[b] ? 0 : 1)]);
    children[0].count = best.position;
    children[0].place = part.place + 1;
    children[1].range = load_box(&blocks.suffix[b]);
    children[1].begin += best.position;
    children[1].count -= best.position;
    children[1].place = part.place + 2 * best.position;
    for (Part& child : children) {
      ++child.depth;
      child.in_tree = !part.in_tree;
    }
    bool ties = false;
    const Record edge = first_on_right(best, b, ties);
    std::vector<std::size_t> lefts(chunks() + 1, 0);
    each_chunk([&](std::size_t chunk, std::size_t begin, std::size_t end) {
      lefts[chunk + 1] = chunks() == 1 ? 0
                         : ties ? count_left<true>(records_ + begin, end - begin, edge, best.axis)
                                : count_left<false>(records_ + begin, end - begin, edge, best.axis);
    });
    for (std::size_t chunk = 0; chunk < chunks(); ++chunk) lefts[chunk + 1] += lefts[chunk];
    Record *const to_left = memory_.records(children[0]), *const to_right =
                                                              memory_.records(children[1]);
    each_chunk([&](std::size_t chunk, std::size_t begin, std::size_t end) {
      Record* left = to_left + lefts[chunk];
      Record* right = to_right + (begin - lefts[chunk]);
      if (ties) {
        distribute<true>(records_ + begin, end - begin, edge, best.axis, left, right);
      } else {
        distribute<false>(records_ + begin, end - begin, edge, best.axis, left, right);
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
  LargeVector<Record> boxes_;  // by half chunk, axis, bin
  LargeVector<std::uint32_t> counts_;
  NodeBlocks blocks_;
  std::array<Doubtful, 3> doubtful_;
};
