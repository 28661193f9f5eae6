#include "core/base/bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace lightbatch {
namespace {

class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

std::string error_text() { return std::strerror(errno); }

constexpr std::size_t kLargestTransfer = std::size_t{1} << 30;

}  // namespace

Result<Bytes> read_file(const std::filesystem::path& path) {
  const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return io_error(path.string(), "cannot open file: " + error_text());
  struct stat info {};
  if (::fstat(file.get(), &info) != 0 || !S_ISREG(info.st_mode)) {
    return io_error(path.string(), "not a readable regular file");
  }
  Bytes bytes(static_cast<std::size_t>(info.st_size));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(file.get(), bytes.data() + done,
                               std::min(bytes.size() - done, kLargestTransfer));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return io_error(path.string(), "cannot read file: " + error_text());
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  bytes.resize(done);
  return bytes;
}

Status write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  const std::string temporary = path.string() + ".partial-" + std::to_string(::getpid());
  {
    const File file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (file.get() < 0) return io_error(temporary, "cannot create file: " + error_text());
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t put = ::write(file.get(), bytes.data() + done,
                                  std::min(bytes.size() - done, kLargestTransfer));
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) {
        const std::string why = error_text();
        ::unlink(temporary.c_str());
        return io_error(path.string(), "cannot write file: " + why);
      }
      done += static_cast<std::size_t>(put);
    }
    if (::fsync(file.get()) != 0) {
      const std::string why = error_text();
      ::unlink(temporary.c_str());
      return io_error(path.string(), "cannot flush file: " + why);
    }
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) {
    const std::string why = error_text();
    ::unlink(temporary.c_str());
    return io_error(path.string(), "cannot put file in place: " + why);
  }
  return {};
}

}  // namespace lightbatch
