#include "app/live/page_server.hpp"

#include <fmt/format.h>

#include <thread>
#include <utility>

#include "app/live/page_http.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::live {
namespace {

constexpr int kMaxPort = 65535;
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
    throw InputError(
        fmt::format("{} {}: must be [HOST:]PORT, e.g. 8800 or 0.0.0.0:8800", option, text));
  }
  return address;
}

struct PageServer::Impl {
  Impl(std::map<std::string, Handler> pages, bool loopback) : server(std::move(pages), loopback) {}

  PageHttp server;
  std::thread thread;
  std::string url;
};

PageServer::PageServer(const ServerAddress& address, std::map<std::string, Handler> pages)
    : impl_(std::make_unique<Impl>(std::move(pages), IsLoopback(address.host))) {
  httplib::Server& server = impl_->server;
  const int port = address.port == 0
                       ? server.bind_to_any_port(address.host)
                       : (server.bind_to_port(address.host, address.port) ? address.port : -1);
  if (port <= 0) {
    throw InputError(
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
  impl_->server.CutOff();
  impl_->server.stop();
  impl_->thread.join();
}

const std::string& PageServer::Url() const {
  return impl_->url;
}

}  // namespace ceilmap::live
