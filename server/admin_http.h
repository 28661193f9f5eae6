#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/status.h"

namespace lightbatch::server {

/// What an admin page answers: text, or a file of the blob store.
struct AdminAnswer {
  int code = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string text;
  std::filesystem::path file;  // not empty: the body is this file
};

/// HTTP for people and probes (Boost.Beast): GET and HEAD only, no request bodies, headers up to
/// 8 KiB, 10 s per request, a strict content-security policy. Unauthenticated: keep it on loopback.
/// Handlers run on the one thread of this server.
class AdminHttp {
 public:
  using Handler = std::function<AdminAnswer(std::string_view path)>;

  /// Binds and serves at once; UNAVAILABLE when the address is taken.
  static Result<std::unique_ptr<AdminHttp>> start(const std::string& address, std::uint16_t port,
                                                  Handler handler);
  ~AdminHttp();
  std::uint16_t port() const;

 private:
  struct Loop;
  explicit AdminHttp(std::unique_ptr<Loop> loop);
  std::unique_ptr<Loop> loop_;
};

/// For text between tags and in attributes.
std::string escape_html(std::string_view text);

}  // namespace lightbatch::server
