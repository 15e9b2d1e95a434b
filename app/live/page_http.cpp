#include "app/live/page_http.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

namespace ceilmap::live {
namespace {

/// A few threads and a short queue. When the queue is full, the task is run by the caller: the
/// listener, for which no time is left, so that it closes the connection.
class ShortQueue final : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> task) override {
    if (++waiting_ > kMaxWaiting) {
      --waiting_;
      task();
      return;
    }
    pool_.enqueue([this, task = std::move(task)] {
      --waiting_;
      task();
    });
  }
  void shutdown() override { pool_.shutdown(); }

 private:
  std::atomic<int> waiting_ = 0;
  httplib::ThreadPool pool_{kAnsweredAtATime};
};

/// The host of a Host header, without port and brackets.
std::string HostOf(const std::string& header) {
  if (header.starts_with('[')) return header.substr(1, header.find(']') - 1);
  return header.substr(0, header.find(':'));
}

}  // namespace

bool IsLoopback(const std::string& host) {
  const bool numbers = host.find_first_not_of("0123456789.") == std::string::npos;
  return host == "localhost" || host == "::1" || (numbers && host.starts_with("127."));
}

ClientStream::ClientStream(int socket, const std::atomic<bool>& stopping)
    : socket_(socket), stopping_(stopping) {}

bool ClientStream::Wait(short events, Clock::time_point until) const {
  constexpr std::chrono::milliseconds kPollInterval{100};  // for a quick stop
  while (!stopping_) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
    if (left.count() <= 0) return false;
    pollfd waiting{socket_, events, 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::min(left, kPollInterval).count()));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
  return false;
}

bool ClientStream::is_readable() const {
  return !buffer_.empty() || Wait(POLLIN, start_ + kRequestPatience);
}

bool ClientStream::is_writable() const {
  return Wait(POLLOUT, (asked_ == Clock::time_point() ? Clock::now() : asked_) + kAnswerPatience);
}

ssize_t ClientStream::read(char* bytes, std::size_t size) {
  if (buffer_.empty()) {
    std::array<char, 2048> block{};
    const std::size_t room = std::min(block.size(), kMaxRequestBytes - received_);
    if (room == 0 || !Wait(POLLIN, start_ + kRequestPatience)) return -1;
    const ssize_t count = recv(socket_, block.data(), room, MSG_DONTWAIT);
    if (count <= 0) return count;
    buffer_.assign(block.data(), static_cast<std::size_t>(count));
    received_ += buffer_.size();
  }
  const std::size_t count = std::min(size, buffer_.size());
  std::copy_n(buffer_.begin(), count, bytes);
  buffer_.erase(0, count);
  return static_cast<ssize_t>(count);
}

ssize_t ClientStream::write(const char* bytes, std::size_t size) {
  if (asked_ == Clock::time_point()) asked_ = Clock::now();
  if (!is_writable()) return -1;
  return send(socket_, bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
}

// Addresses of clients are not used and not recorded.
void ClientStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  ip.clear();
  port = 0;
}
void ClientStream::get_local_ip_and_port(std::string& ip, int& port) const {
  ip.clear();
  port = 0;
}

PageHttp::PageHttp(std::map<std::string, PageServer::Handler> pages, bool loopback)
    : pages_(std::move(pages)), loopback_(loopback) {
  new_task_queue = [this] {
    listener_ = std::this_thread::get_id();
    return new ShortQueue;
  };
  set_tcp_nodelay(true);
  set_payload_max_length(0);
  // By default two programs could share a port.
  set_socket_options([](auto socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  set_default_headers({{"X-Content-Type-Options", "nosniff"},
                       {"X-Frame-Options", "DENY"},
                       {"Referrer-Policy", "no-referrer"},
                       {"Cache-Control", "no-store"}});
  // Before the server's own routing, which matches untrusted input against regular expressions.
  set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    Respond(request, response);
    return httplib::Server::HandlerResponse::Handled;
  });
}

bool PageHttp::Answer(httplib::Stream& stream) {
  bool closed = false;
  constexpr bool kClose = true;  // one request per connection
  // A request of many ranges could multiply the size of the answer.
  return process_request(
      stream, kClose, closed, [](httplib::Request& request) { request.ranges.clear(); });
}

bool PageHttp::process_and_close_socket(int socket) {
  bool answered = false;
  if (std::this_thread::get_id() != listener_.load()) {
    ClientStream stream(socket, stopping_);
    answered = Answer(stream);
  }
  shutdown(socket, SHUT_RDWR);
  close(socket);
  return answered;
}

void PageHttp::Respond(const httplib::Request& request, httplib::Response& response) const {
  if (request.method != "GET" && request.method != "HEAD") {
    response.status = 405;
    response.set_header("Allow", "GET, HEAD");
    return;
  }
  if (loopback_ && !IsLoopback(HostOf(request.get_header_value("Host")))) {
    response.status = 403;
    return;
  }
  const std::size_t mark = request.target.find('?');
  const auto page = pages_.find(request.target.substr(0, mark));
  if (page == pages_.end()) {
    response.status = 404;
    return;
  }
  const ServedContent content =
      page->second(mark == std::string::npos ? "" : request.target.substr(mark + 1));
  response.status = 200;
  response.set_content(content.body, content.mime);
}

}  // namespace ceilmap::live
