#pragma once

#include <httplib.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <iterator>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace ceilmap::support {

/// A web server on this machine with one file, /map.gpkg, and the faults of real ones.
class FileServer {
 public:
  explicit FileServer(std::string content, std::string etag = "\"1\"") {
    Replace(std::move(content), std::move(etag));
    server_.Get("/map.gpkg", [this](const httplib::Request& request, httplib::Response& response) {
      Answer(request, response);
    });
    server_.set_keep_alive_timeout(1);  // Stop() waits for it
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::yield();
  }
  ~FileServer() { Stop(); }
  FileServer(const FileServer&) = delete;
  FileServer& operator=(const FileServer&) = delete;

  static std::string ContentOf(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  [[nodiscard]] std::string Url(const std::string& user = "") const {
    return "http://" + user + "127.0.0.1:" + std::to_string(port_) + "/map.gpkg";
  }
  /// An empty etag: none is sent.
  void Replace(std::string content, std::string etag) {
    const std::lock_guard lock(mutex_);
    content_ = std::make_shared<const std::string>(std::move(content));
    etag_ = std::move(etag);
  }
  void Stop() {
    server_.stop();
    if (thread_.joinable()) thread_.join();
  }

  std::atomic<int> truncated{0};   ///< so many of the next answers end early ...
  std::atomic<int> failing{0};     ///< ... or have this ...
  std::atomic<int> status{503};    ///< ... status
  std::atomic<bool> ranges{true};  ///< false: the whole file each time
  std::atomic<int> requests{0};
  /// The content has another ETag from so many further requests on; negative: never.
  std::atomic<int> replaced_after{-1};
  std::atomic<std::size_t> bytes{0};  ///< of the file, sent

 private:
  std::string ContentNow() {
    const std::lock_guard lock(mutex_);
    return *content_;
  }

  void Answer(const httplib::Request& request, httplib::Response& response) {
    ++requests;
    if (replaced_after >= 0 && replaced_after-- == 0) Replace(ContentNow(), "\"replaced\"");
    if (failing > 0) {
      --failing;
      response.status = status;
      return;
    }
    std::shared_ptr<const std::string> content;
    {
      const std::lock_guard lock(mutex_);
      content = content_;
      if (!etag_.empty()) response.set_header("ETag", etag_);
    }
    auto& wanted = const_cast<httplib::Request&>(request).ranges;  // as web servers treat them
    const auto size = static_cast<ssize_t>(content->size());
    if (!ranges) wanted.clear();
    if (!wanted.empty() && wanted[0].first >= size) {
      response.status = 416;
      return;
    }
    if (!wanted.empty()) wanted[0].second = std::min(wanted[0].second, size - 1);
    const bool cut = truncated > 0;
    if (cut) --truncated;
    response.set_content_provider(
        content->size(),
        "application/geopackage+sqlite3",
        [this, content, cut](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
          const std::size_t sent = cut ? length / 2 : length;
          bytes += sent;
          return sink.write(content->data() + offset, sent) && !cut;
        });
  }

  httplib::Server server_;
  std::mutex mutex_;
  std::shared_ptr<const std::string> content_;
  std::string etag_;
  int port_ = 0;
  std::thread thread_;
};

}  // namespace ceilmap::support
