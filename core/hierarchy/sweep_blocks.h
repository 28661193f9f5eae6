// Lists cut into blocks, whose boxes bound from below what splits inside them cost; included by
// sweep_impl.h only. Floating-point operations are monotone, so a block that is ruled out has no
// split as good as the best, ties included.

LB_INLINE std::uint32_t block_size(std::uint32_t n) {
  return n <= kManySmall ? kSmallBlock : kLargeBlock;
}

/// Cuts r[0, count), which begins at position `first` of its node. Returns the number of blocks.
std::size_t box_blocks(const Record* r, std::uint32_t count, std::uint32_t first, Blocks& blocks) {
  const std::uint32_t size = block_size(count);
  const std::size_t number = (count + size - 1) / size;
  blocks.resize(number);
  for (std::size_t b = 0; b < number; ++b) {
    const std::size_t begin = b * size, end = std::min<std::size_t>(count, begin + size);
    blocks.starts[b] = first + static_cast<std::uint32_t>(begin);
    store_box(&blocks.boxes[b], box_of(r + begin, end - begin));
  }
  blocks.starts[number] = first + count;
  return number;
}

/// Prefixes and suffixes of the blocks, where `before` and `after` are the boxes of what lies
/// outside; offers the positions between blocks.
void scan_blocks(std::size_t count, V8f before, V8f after, Blocks& blocks,
                 const SweepContext& context, Split& best) {
  V8f box = before;
  for (std::size_t b = 0; b <= count; ++b) {
    store_box(&blocks.prefix[b], box);
    blocks.prefix_area[b] = blocks.starts[b] == 0 ? 0.0f : area_of(box);
    if (b < count) box = unite(load_box(&blocks.boxes[b]), box);
  }
  box = after;
  for (std::size_t b = count + 1; b-- > 0;) {
    if (b < count) box = unite(load_box(&blocks.boxes[b]), box);
    store_box(&blocks.suffix[b], box);
    blocks.suffix_area[b] = blocks.starts[b] == context.n ? 0.0f : area_of(box);
  }
  for (std::size_t b = 1; b < count; ++b) {
    const std::uint32_t k = blocks.starts[b];
    if (k < context.range.first || k > context.range.last) continue;
    best.offer(blocks.prefix_area[b] * static_cast<float>(k) +
                   blocks.suffix_area[b] * static_cast<float>(context.n - k),
               context.axis, k, tie_rank(k, context.n));
  }
}

/// Whether no position inside the block can be as good as the best.
LB_INLINE bool ruled_out(std::size_t b, const Blocks& blocks, std::uint32_t n, const Split& best) {
  const std::uint32_t begin = blocks.starts[b], end = blocks.starts[b + 1];
  if (end - begin < 2) return true;
  const float bound = blocks.prefix_area[b] * static_cast<float>(begin + 1) +
                      blocks.suffix_area[b + 1] * static_cast<float>(n - end + 1);
  return bound > best.cost;
}

/// Sweeps the blocks of r[0, ...), the list that they were cut from, that are not ruled out.
void sweep_blocks(const Record* r, std::size_t count, const Blocks& blocks,
                  const SweepContext& context, Split& best) {
  for (std::size_t b = 0; b < count; ++b) {
    if (ruled_out(b, blocks, context.n, best)) continue;
    const std::uint32_t begin = blocks.starts[b];
    sweep_inside(r + (begin - blocks.starts[0]), blocks.starts[b + 1] - begin, begin,
                 load_box(&blocks.prefix[b]), load_box(&blocks.suffix[b + 1]), context, best);
  }
}
