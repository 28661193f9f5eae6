#pragma once

#include <ImfIO.h>

#include <cstring>
#include <span>
#include <stdexcept>

#include "core/base/bytes.h"

namespace lightbatch::image {

/// OpenEXR's files in memory.
class SpanStream : public Imf::IStream {
 public:
  explicit SpanStream(std::span<const std::byte> bytes) : IStream("image"), bytes_(bytes) {}

  bool read(char c[], int n) override {
    if (n < 0 || static_cast<std::uint64_t>(n) > bytes_.size() - offset_) {
      throw std::runtime_error("the data ends too early");
    }
    std::memcpy(c, bytes_.data() + offset_, static_cast<std::size_t>(n));
    offset_ += static_cast<std::size_t>(n);
    return offset_ < bytes_.size();
  }
  std::uint64_t tellg() override { return offset_; }
  void seekg(std::uint64_t position) override {
    if (position > bytes_.size()) throw std::runtime_error("an offset lies past the end");
    offset_ = static_cast<std::size_t>(position);
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
};

class BytesStream : public Imf::OStream {
 public:
  BytesStream() : OStream("image") {}

  void write(const char c[], int n) override {
    const std::size_t count = static_cast<std::size_t>(n);
    if (offset_ + count > bytes.size()) bytes.resize(offset_ + count);
    std::memcpy(bytes.data() + offset_, c, count);
    offset_ += count;
  }
  std::uint64_t tellp() override { return offset_; }
  void seekp(std::uint64_t position) override { offset_ = static_cast<std::size_t>(position); }

  Bytes bytes;

 private:
  std::size_t offset_ = 0;
};

}  // namespace lightbatch::image
