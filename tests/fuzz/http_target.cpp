#include <algorithm>
#include <string>

#include "app/live/page_http.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {
namespace {

/// A client that sends bytes and takes whatever comes.
class Client final : public httplib::Stream {
 public:
  explicit Client(std::string_view bytes) : rest_(bytes) {}

  [[nodiscard]] bool is_readable() const override { return !rest_.empty(); }
  [[nodiscard]] bool is_writable() const override { return true; }
  ssize_t read(char* bytes, std::size_t size) override {
    const std::size_t count = std::min(size, rest_.size());
    std::copy_n(rest_.begin(), count, bytes);
    rest_.remove_prefix(count);
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* bytes, std::size_t size) override {
    answer_.append(bytes, size);
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  [[nodiscard]] int socket() const override { return -1; }
  [[nodiscard]] const std::string& Received() const { return answer_; }

 private:
  std::string_view rest_;
  std::string answer_;
};

}  // namespace

void ReadAsHttp(std::string_view bytes) {
  static live::PageHttp server(
      {{"/",
        [](const std::string& query) {
          return live::ServedContent{"text/html; charset=utf-8", "page " + query};
        }}},
      true);
  Client client(bytes.substr(0, live::kMaxRequestBytes));
  (void)server.Answer(client);
  const std::string& answer = client.Received();
  Require(answer.size() < 2 * live::kMaxRequestBytes, "an answer larger than the page");
  const bool page = answer.starts_with("HTTP/1.1 200");
  const std::string_view line = bytes.substr(0, bytes.find('\n'));
  const auto has = [&line](std::string_view words) { return line.find(words) != line.npos; };
  Require(!page || has("GET") || has("HEAD"), "another method was answered");
}

}  // namespace ceilmap::fuzz
