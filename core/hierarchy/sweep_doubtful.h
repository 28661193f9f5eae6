// Bins that may hold the best split of a node; included by sweep_impl.h only.

constexpr std::uint32_t kBins = 1024;

/// One axis of a node whose records are in bins.
struct BinnedAxis {
  const Record* records;
  const std::uint16_t* codes;  // the bin of each
  SweepContext context;
  float low, scale, place_scale;  // bin = (key - low) * scale + place * place_scale
  const Blocks& blocks;           // the bins
};

class DoubtfulBins {
 public:
  /// Finds the bins, and returns how many records they hold.
  std::uint32_t find(const BinnedAxis& node, const Split& best) {
    std::uint32_t count = 0;
    for (std::size_t b = 0; b < kBins; ++b) {
      const bool out = ruled_out(b, node.blocks, node.context.n, best);
      places_[b] = out ? kNowhere : count;
      if (!out) count += node.blocks.starts[b + 1] - node.blocks.starts[b];
    }
    members_.resize(count);
    return count;
  }

  /// Sweeps what was found.
  void sweep(const BinnedAxis& node, Split& best) {
    const auto is_in = [](std::uint32_t place) { return place != kNowhere; };
    const auto first = std::find_if(places_.begin(), places_.end(), is_in) - places_.begin();
    const auto last = places_.rend() - std::find_if(places_.rbegin(), places_.rend(), is_in) - 1;
    if (last < 0) return;
    std::array<std::uint32_t, kBins> next = places_;
    each_in_bins(node, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last),
                 [&](std::size_t i, std::size_t bin) {
                   if (is_in(next[bin])) members_[next[bin]++] = static_cast<std::uint32_t>(i);
                 });
    for (std::size_t b = 0; b < kBins; ++b) {
      if (!is_in(places_[b]) || ruled_out(b, node.blocks, node.context.n, best)) continue;
      const std::span members = std::span(members_).subspan(
          places_[b], node.blocks.starts[b + 1] - node.blocks.starts[b]);
      const V8f before = load_box(&node.blocks.prefix[b]),
                after = load_box(&node.blocks.suffix[b + 1]);
      if (members.size() <= kFewInBin) {
        sweep_members(node, members, {node.blocks.starts[b], before, after}, best);
      } else {
        sweep_finer(node, b, members, best);
      }
    }
  }

  /// The records of a bin, key and place; the first k of their order come first, then the next.
  std::span<const std::uint64_t> divided(const BinnedAxis& node, std::uint32_t b, std::size_t k) {
    members_.clear();
    each_in_bins(node, b, b, [&](std::size_t i, std::size_t) {
      members_.push_back(static_cast<std::uint32_t>(i));
    });
    list_members(node, members_);
    std::nth_element(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(k), order_.end());
    return order_;
  }

 private:
  static constexpr std::size_t kFiner = 64;      // bins in a bin
  static constexpr std::size_t kFewInBin = 256;  // are sorted at once
  static constexpr std::uint32_t kNowhere = 0xffffffffu;

  /// Calls body(record, bin) for the records in bins first to last.
  template <typename Body>
  LB_INLINE void each_in_bins(const BinnedAxis& node, std::uint32_t first, std::uint32_t last,
                              Body body) const {
    constexpr std::size_t kGroup = 32;
    const std::uint16_t* codes = node.codes;
    const auto low = static_cast<std::uint16_t>(first),
               span = static_cast<std::uint16_t>(last - first);
    const auto inside = [&](std::uint16_t code) {
      return static_cast<std::uint16_t>(code - low) <= span;
    };
    const std::size_t count = node.context.n;
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

  /// Cuts a bin into finer ones, and does with them as with bins.
  void sweep_finer(const BinnedAxis& node, std::size_t b, std::span<const std::uint32_t> members,
                   Split& best) {
    finer_.resize(kFiner);
    for (std::size_t f = 0; f < kFiner; ++f) store_box(&finer_.boxes[f], empty_box());
    std::array<std::uint32_t, kFiner + 1> next{};
    codes_.resize(members.size());
    grouped_.resize(members.size());
    for (std::size_t k = 0; k < members.size(); ++k) {
      const Record& record = node.records[members[k]];
      // Powers of two change no digit: these codes divide those of the bins.
      const float place = static_cast<float>(static_cast<std::int32_t>(members[k]));
      const float at =
          (record.key(node.context.axis) - node.low) * node.scale + place * node.place_scale;
      const std::int32_t code = static_cast<std::int32_t>(at * static_cast<float>(kFiner)) -
                                static_cast<std::int32_t>(b * kFiner);
      const auto f =
          static_cast<std::size_t>(std::clamp(code, 0, static_cast<std::int32_t>(kFiner) - 1));
      store_box(&finer_.boxes[f], unite(load_box(&finer_.boxes[f]), load_box(&record)));
      codes_[k] = static_cast<std::uint8_t>(f);
      ++next[f + 1];
    }
    for (std::size_t f = 0; f < kFiner; ++f) {
      next[f + 1] += next[f];
      finer_.starts[f] = node.blocks.starts[b] + next[f];
    }
    finer_.starts[kFiner] = node.blocks.starts[b + 1];
    for (std::size_t k = 0; k < members.size(); ++k) {
      grouped_[next[codes_[k]]++] = members[k];
    }
    scan_blocks(kFiner, load_box(&node.blocks.prefix[b]), load_box(&node.blocks.suffix[b + 1]),
                finer_, node.context, best);
    for (std::size_t f = 0; f < kFiner; ++f) {
      if (ruled_out(f, finer_, node.context.n, best)) continue;
      sweep_members(
          node,
          std::span(grouped_).subspan(finer_.starts[f] - node.blocks.starts[b],
                                      finer_.starts[f + 1] - finer_.starts[f]),
          {finer_.starts[f], load_box(&finer_.prefix[f]), load_box(&finer_.suffix[f + 1])}, best);
    }
  }

  /// What lies outside some members of the list, which begin at position `first` of it.
  struct Around {
    std::uint32_t first;
    V8f before, after;
  };

  void sweep_members(const BinnedAxis& node, std::span<const std::uint32_t> members,
                     const Around& around, Split& best) {
    list_members(node, members);
    std::sort(order_.begin(), order_.end());
    sorted_.resize(2 * kMargin + members.size());
    Record* const list = sorted_.data() + kMargin;
    for (std::size_t k = 0; k < members.size(); ++k) {
      list[k] = node.records[static_cast<std::uint32_t>(order_[k])];
    }
    const std::size_t number =
        box_blocks(list, static_cast<std::uint32_t>(members.size()), around.first, inside_);
    scan_blocks(number, around.before, around.after, inside_, node.context, best);
    sweep_blocks(list, number, inside_, node.context, best);
  }

  /// Key and place.
  void list_members(const BinnedAxis& node, std::span<const std::uint32_t> members) {
    order_.resize(members.size());
    for (std::size_t k = 0; k < members.size(); ++k) {
      order_[k] = std::uint64_t{ordered_bits(node.records[members[k]].key(node.context.axis))}
                      << 32 |
                  members[k];
    }
  }

  std::array<std::uint32_t, kBins> places_{};  // of each bin among the members, or kNowhere
  std::vector<std::uint32_t> members_, grouped_;
  std::vector<std::uint8_t> codes_;
  Blocks finer_, inside_;
  std::vector<std::uint64_t> order_;
  std::vector<Record> sorted_;
};
