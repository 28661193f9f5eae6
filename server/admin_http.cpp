#include "server/admin_http.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <system_error>
#include <thread>
#include <utility>
#include <variant>

namespace lightbatch::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using tcp = asio::ip::tcp;

constexpr std::uint32_t kMaxHeaderBytes = 8 * 1024;
constexpr auto kRequestTime = std::chrono::seconds(10);
constexpr int kMaxSessions = 64;

template <typename Response>
void set_headers(Response& response, const AdminAnswer& answer, bool keep_alive) {
  response.set(http::field::content_type, answer.type);
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Content-Security-Policy",
               "sandbox allow-scripts; default-src 'none'; style-src 'unsafe-inline'; "
               "script-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'");
  response.keep_alive(keep_alive);
  response.prepare_payload();
}

/// One connection: reads a request, answers, reads the next.
class Session : public std::enable_shared_from_this<Session> {
 public:
  Session(tcp::socket socket, const AdminHttp::Handler& handler, int& sessions)
      : stream_(std::move(socket)), handler_(handler), sessions_(sessions) {
    ++sessions_;
  }
  ~Session() { --sessions_; }

  void read() {
    parser_.emplace();
    parser_->header_limit(kMaxHeaderBytes);
    parser_->body_limit(0);
    stream_.expires_after(kRequestTime);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                       // The header is whole then; nobody reads the body.
                       if (!error || error == http::error::body_limit) self->answer(error);
                     });
  }

 private:
  void answer(beast::error_code unread) {
    const auto& request = parser_->get();
    AdminAnswer answer;
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      answer = {405, "text/plain; charset=utf-8", "only GET and HEAD\n", {}};
    } else {
      const std::string target(request.target());
      answer = handler_(std::string_view(target).substr(0, target.find('?')));
    }
    const bool keep_alive = request.keep_alive() && !unread;
    const auto code = static_cast<unsigned>(answer.code);
    if (request.method() == http::verb::head) {
      std::error_code missing;
      const std::uint64_t size = answer.file.empty()
                                     ? answer.text.size()
                                     : std::filesystem::file_size(answer.file, missing);
      http::response<http::empty_body> response{
          missing ? http::status::not_found : http::int_to_status(code), request.version()};
      set_headers(response, answer, keep_alive);
      response.content_length(missing ? 0 : size);
      return write(std::move(response));
    }
    if (!answer.file.empty()) {
      http::response<http::file_body> response{http::int_to_status(code), request.version()};
      beast::error_code error;
      response.body().open(answer.file.c_str(), beast::file_mode::scan, error);
      if (!error) {
        set_headers(response, answer, keep_alive);
        return write(std::move(response));
      }
      answer = {404, "text/plain; charset=utf-8", "not found\n", {}};
    }
    http::response<http::string_body> response{
        http::int_to_status(static_cast<unsigned>(answer.code)), request.version()};
    response.body() = answer.text;
    set_headers(response, answer, keep_alive);
    write(std::move(response));
  }

  template <typename Body>
  void write(http::response<Body> response) {
    auto message = std::make_shared<http::response<Body>>(std::move(response));
    stream_.expires_after(kRequestTime);
    http::async_write(stream_, *message,
                      [self = shared_from_this(), message](beast::error_code error, std::size_t) {
                        if (error) return;
                        if (message->keep_alive()) {
                          self->read();
                        } else {
                          self->stream_.socket().shutdown(tcp::socket::shutdown_send, error);
                        }
                      });
  }

  beast::tcp_stream stream_;
  const AdminHttp::Handler& handler_;
  int& sessions_;
  beast::flat_buffer buffer_{kMaxHeaderBytes * 2};
  std::optional<http::request_parser<http::empty_body>> parser_;
};

}  // namespace

struct AdminHttp::Loop {
  asio::io_context io{1};
  tcp::acceptor acceptor{io};
  Handler handler;
  int sessions = 0;
  std::thread thread;

  void accept() {
    acceptor.async_accept([this](beast::error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (!error && sessions < kMaxSessions) {
        std::make_shared<Session>(std::move(socket), handler, sessions)->read();
      }
      accept();
    });
  }
};

AdminHttp::AdminHttp(std::unique_ptr<Loop> loop) : loop_(std::move(loop)) {}

AdminHttp::~AdminHttp() {
  loop_->io.stop();
  if (loop_->thread.joinable()) loop_->thread.join();
}

std::uint16_t AdminHttp::port() const { return loop_->acceptor.local_endpoint().port(); }

Result<std::unique_ptr<AdminHttp>> AdminHttp::start(const std::string& address, std::uint16_t port,
                                                    Handler handler) {
  auto loop = std::make_unique<Loop>();
  beast::error_code error;
  const auto ip = asio::ip::make_address(address, error);
  const tcp::endpoint endpoint(ip, port);
  if (!error) loop->acceptor.open(endpoint.protocol(), error);
  if (!error) loop->acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) loop->acceptor.bind(endpoint, error);
  if (!error) loop->acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    return Status(StatusCode::kUnavailable, "ADDRESS_TAKEN",
                  "cannot serve the admin pages on " + address + ":" + std::to_string(port) + ": " +
                      error.message());
  }
  loop->handler = std::move(handler);
  loop->accept();
  loop->thread = std::thread([io = &loop->io] { io->run(); });
  return std::unique_ptr<AdminHttp>(new AdminHttp(std::move(loop)));
}

std::string escape_html(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

}  // namespace lightbatch::server
