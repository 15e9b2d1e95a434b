#include "app/page_server.hpp"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include <thread>
#include <utility>

#include "calib/error.hpp"

namespace ceilmap::app {
namespace {

constexpr int kMaxPort = 65535;
constexpr std::size_t kAnsweredAtATime = 4;
constexpr std::time_t kPatienceS = 3;  // for a request, and for who takes an answer
constexpr std::time_t kIdleS = 1;      // between requests of one connection

bool IsLoopback(const std::string& host) {
  const bool numbers = host.find_first_not_of("0123456789.") == std::string::npos;
  return host == "localhost" || host == "::1" || (numbers && host.starts_with("127."));
}

/// Of a Host header: without port and brackets.
std::string HostOf(const std::string& header) {
  if (header.starts_with('[')) return header.substr(1, header.find(']') - 1);
  return header.substr(0, header.find(':'));
}

std::string InUrl(const std::string& host) {
  return host.find(':') == std::string::npos ? host : "[" + host + "]";
}

}  // namespace

ServerAddress ParseServerAddress(const std::string& text, const std::string& option) {
  ServerAddress address;
  std::string port = text;
  if (const std::size_t colon = text.rfind(':'); colon != std::string::npos) {
    address.host = text.substr(0, colon);
    port = text.substr(colon + 1);
    if (address.host.starts_with('[') && address.host.ends_with(']')) {
      address.host = address.host.substr(1, address.host.size() - 2);
    }
  }
  const bool digits = !port.empty() && port.size() <= 5 &&
                      port.find_first_not_of("0123456789") == std::string::npos;
  address.port = digits ? std::stoi(port) : -1;
  if (address.port < 0 || address.port > kMaxPort || address.host.empty()) {
    throw calib::InputError(
        fmt::format("{} {}: must be [HOST:]PORT, e.g. 8800 or 0.0.0.0:8800", option, text));
  }
  return address;
}

struct PageServer::Impl {
  explicit Impl(std::map<std::string, Handler> served) : pages(std::move(served)) {}

  void SetUp(bool loopback);
  void Answer(const httplib::Request& request, httplib::Response& response, bool loopback) const;

  std::map<std::string, Handler> pages;
  httplib::Server server;
  std::thread thread;
  std::string url;
};

void PageServer::Impl::Answer(const httplib::Request& request,
                              httplib::Response& response,
                              bool loopback) const {
  if (request.method != "GET" && request.method != "HEAD") {
    response.status = 405;
    response.set_header("Allow", "GET, HEAD");
    return;
  }
  if (loopback && !IsLoopback(HostOf(request.get_header_value("Host")))) {
    response.status = 403;
    return;
  }
  const std::size_t mark = request.target.find('?');
  const auto page = pages.find(request.target.substr(0, mark));
  if (page == pages.end()) {
    response.status = 404;
    return;
  }
  ServedContent content =
      page->second(mark == std::string::npos ? "" : request.target.substr(mark + 1));
  response.status = 200;
  response.set_content(content.body, content.mime);
}

void PageServer::Impl::SetUp(bool loopback) {
  server.new_task_queue = [] { return new httplib::ThreadPool(kAnsweredAtATime); };
  server.set_tcp_nodelay(true);
  server.set_read_timeout(kPatienceS);
  server.set_write_timeout(kPatienceS);
  server.set_keep_alive_timeout(kIdleS);
  server.set_payload_max_length(0);
  // By default two programs could share a port.
  server.set_socket_options([](auto socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  server.set_default_headers({{"X-Content-Type-Options", "nosniff"},
                              {"X-Frame-Options", "DENY"},
                              {"Referrer-Policy", "no-referrer"},
                              {"Cache-Control", "no-store"}});
  // Before the server's own routing, which matches regular expressions against what strangers send.
  server.set_pre_routing_handler(
      [this, loopback](const httplib::Request& request, httplib::Response& response) {
        Answer(request, response, loopback);
        return httplib::Server::HandlerResponse::Handled;
      });
}

PageServer::PageServer(const ServerAddress& address, std::map<std::string, Handler> pages)
    : impl_(std::make_unique<Impl>(std::move(pages))) {
  httplib::Server& server = impl_->server;
  impl_->SetUp(IsLoopback(address.host));
  const int port = address.port == 0
                       ? server.bind_to_any_port(address.host)
                       : (server.bind_to_port(address.host, address.port) ? address.port : -1);
  if (port <= 0) {
    throw calib::InputError(
        fmt::format("{}:{}: no page can be served there; the port is in use, or the address is not "
                    "of this machine",
                    InUrl(address.host),
                    address.port));
  }
  impl_->url = fmt::format("http://{}:{}/", InUrl(address.host), port);
  impl_->thread = std::thread([&server] { server.listen_after_bind(); });
  // stop() has no effect before that.
  while (!server.is_running()) std::this_thread::yield();
}

PageServer::~PageServer() {
  impl_->server.stop();
  impl_->thread.join();
}

const std::string& PageServer::Url() const {
  return impl_->url;
}

}  // namespace ceilmap::app
