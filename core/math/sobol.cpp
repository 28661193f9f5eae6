// Generator matrices of the first eight Sobol dimensions (Sobol 1967; direction numbers of Joe and
// Kuo 2008), bit-reversed and tabulated by index byte.
#include "core/math/sobol.h"

namespace lightbatch::sobol {
namespace {

/// A row of the Joe-Kuo file: degree and inner coefficients of the primitive polynomial, and the
/// initial numbers m. Dimension 0 (van der Corput) has none.
struct Row {
  unsigned degree;
  std::uint32_t coefficients;
  std::array<std::uint32_t, 5> initial;
};
constexpr std::array<Row, kDimensions> kRows = {{{0, 0, {}},
                                                 {1, 0, {1}},
                                                 {2, 1, {1, 3}},
                                                 {3, 1, {1, 3, 1}},
                                                 {3, 2, {1, 1, 1}},
                                                 {4, 1, {1, 1, 3, 3}},
                                                 {4, 4, {1, 3, 5, 13}},
                                                 {5, 2, {1, 1, 5, 5, 17}}}};

constexpr std::array<std::uint32_t, 32> directions(const Row& row) {
  std::array<std::uint32_t, 32> v{};
  for (unsigned i = 0; i < 32; ++i) {
    if (row.degree == 0) {
      v[i] = 1u << (31 - i);
    } else if (i < row.degree) {
      v[i] = row.initial[i] << (31 - i);
    } else {
      const unsigned s = row.degree;
      v[i] = v[i - s] ^ (v[i - s] >> s);
      for (unsigned k = 1; k < s; ++k) {
        if ((row.coefficients >> (s - 1 - k)) & 1u) v[i] ^= v[i - k];
      }
    }
  }
  return v;
}

constexpr Table make_table() {
  Table table{};
  for (std::size_t d = 0; d < kDimensions; ++d) {
    const std::array<std::uint32_t, 32> v = directions(kRows[d]);
    for (unsigned place = 0; place < 4; ++place) {
      for (unsigned byte = 1; byte < 256; ++byte) {
        const unsigned low = static_cast<unsigned>(__builtin_ctz(byte));
        table[d][place][byte] =
            table[d][place][byte & (byte - 1)] ^ reverse_bits(v[8 * place + low]);
      }
    }
  }
  return table;
}

}  // namespace

constinit const Table kReversed = make_table();

}  // namespace lightbatch::sobol
