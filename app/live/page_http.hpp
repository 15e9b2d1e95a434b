#pragma once

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <map>
#include <string>
#include <thread>

#include "app/live/page_server.hpp"

namespace ceilmap::live {

/// The HTTP server of PageServer, on top of cpp-httplib, whose limits are per line and not per
/// request: endless headers would fill the memory, slow requests would occupy a thread forever, and
/// endless connections would exhaust the file descriptors that the map needs. Internal.

/// Limits of one client.
inline constexpr std::size_t kMaxRequestBytes =
    8192;  ///< request line and headers; bodies are refused
inline constexpr std::chrono::seconds kRequestPatience{4};  ///< until the request is complete
inline constexpr std::chrono::seconds kAnswerPatience{60};  ///< until the answer is sent
inline constexpr std::size_t kAnsweredAtATime = 4;
inline constexpr int kMaxWaiting = 32;  ///< connections; further ones are closed at once

/// Whether a host is this machine.
bool IsLoopback(const std::string& host);

/// A client's connection within these limits. It ends when a limit is exceeded or `stopping` is
/// set.
class ClientStream final : public httplib::Stream {
 public:
  /// @param socket  Not owned.
  ClientStream(int socket, const std::atomic<bool>& stopping);

  [[nodiscard]] bool is_readable() const override;
  [[nodiscard]] bool is_writable() const override;
  ssize_t read(char* bytes, std::size_t size) override;
  ssize_t write(const char* bytes, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  [[nodiscard]] int socket() const override { return socket_; }

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] bool Wait(short events, Clock::time_point until) const;

  int socket_;
  const std::atomic<bool>& stopping_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point asked_;  // when the answer began; before: the clock's epoch
  std::string buffer_;       // received, not yet read
  std::size_t received_ = 0;
};

class PageHttp final : public httplib::Server {
 public:
  /// @param loopback  Requests must name this machine as their host.
  PageHttp(std::map<std::string, PageServer::Handler> pages, bool loopback);

  /// Answers one request. @return false if there was none.
  bool Answer(httplib::Stream& stream);
  /// Ends open connections. Call it before stop().
  void CutOff() { stopping_ = true; }

 private:
  bool process_and_close_socket(int socket) override;
  void Respond(const httplib::Request& request, httplib::Response& response) const;

  std::map<std::string, PageServer::Handler> pages_;
  bool loopback_;
  std::atomic<bool> stopping_ = false;
  std::atomic<std::thread::id> listener_;
};

}  // namespace ceilmap::live
