#include "server/executable.h"

#include <elf.h>
#include <link.h>

#include <cstring>
#include <string_view>

#include "core/base/bytes.h"
#include "core/base/hash.h"

namespace lightbatch::server {
namespace {

/// The build id among the notes of a segment (ELF: header, name, content, each padded to 4 bytes);
/// empty: none.
std::string build_id_in(const char* notes, std::size_t size) {
  const auto padded = [](std::size_t n) { return (n + 3) / 4 * 4; };
  constexpr std::string_view kOwner("GNU", 4);
  for (std::size_t at = 0; at + sizeof(ElfW(Nhdr)) <= size;) {
    ElfW(Nhdr) note;
    std::memcpy(&note, notes + at, sizeof note);
    const std::size_t name = at + sizeof note, content = name + padded(note.n_namesz);
    const std::size_t end = content + padded(note.n_descsz);
    if (end > size) break;
    if (note.n_type == NT_GNU_BUILD_ID && std::string_view(notes + name, note.n_namesz) == kOwner)
      return std::string(notes + content, note.n_descsz);
    at = end;
  }
  return {};
}

/// What the linker noted of the executable's contents; empty: nothing.
std::string linked_build_id() {
  std::string id;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* out) {
        for (int i = 0; i < info->dlpi_phnum; ++i) {
          const ElfW(Phdr)& segment = info->dlpi_phdr[i];
          if (segment.p_type != PT_NOTE || segment.p_align > 4) continue;
          auto& found = *static_cast<std::string*>(out);
          if (found.empty())
            found = build_id_in(reinterpret_cast<const char*>(info->dlpi_addr + segment.p_vaddr),
                                segment.p_memsz);
        }
        return 1;  // the executable comes first: no library is asked
      },
      &id);
  return id;
}

}  // namespace

const std::string& executable_digest() {
  static const std::string digest = [] {
    if (const std::string id = linked_build_id(); !id.empty()) return sha256_hex(as_bytes(id));
    const auto bytes = read_file("/proc/self/exe");
    return bytes.ok() ? sha256_hex(*bytes) : std::string("unknown");
  }();
  return digest;
}

}  // namespace lightbatch::server
