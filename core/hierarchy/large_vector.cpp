#include "core/hierarchy/large_vector.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace lightbatch::hierarchy {
namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;
std::align_val_t alignment(std::size_t bytes) {
  return std::align_val_t{bytes >= kHugePage ? kHugePage : 64};
}

}  // namespace

void* allocate_large(std::size_t bytes) {
  void* data = ::operator new(bytes, alignment(bytes));
#ifdef __linux__
  // A hint: failure costs speed alone.
  if (bytes >= kHugePage) madvise(data, bytes, MADV_HUGEPAGE);
#endif
  return data;
}

void free_large(void* data, std::size_t bytes) { ::operator delete(data, alignment(bytes)); }

}  // namespace lightbatch::hierarchy
