#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

namespace ceilmap::live {

/// Where pages are served.
struct ServerAddress {
  std::string host = "127.0.0.1";  ///< this machine only; 0.0.0.0: whoever reaches it
  int port = 0;                    ///< 0: any that is free
};

/// `[HOST:]PORT`, e.g. "8800", "0.0.0.0:8800" or "[::1]:8800". `option` names it in the message.
/// @throws InputError
ServerAddress ParseServerAddress(const std::string& text, const std::string& option);

/// What a path is answered with.
struct ServedContent {
  std::string mime;  ///< e.g. "text/html; charset=utf-8"
  std::string body;
};

/// A small HTTP server for a few fixed paths, in threads of its own: GET (and HEAD) and nothing
/// else, no files, no bodies taken. Made for a page that a handful of people look at, on a network
/// where others may be less kind: a request has at most 8 KiB, comes within 4 s and is answered
/// within 60 s or is cut off, four are answered at a time and 32 wait (app/page_http.hpp), so a
/// slow or hostile client costs other clients their page at worst, never the program. While bound
/// to this machine, requests that name another host are refused, so that no page from elsewhere can
/// read this one under a name of its own (DNS rebinding).
class PageServer {
 public:
  /// @param query  what stands behind the `?` of the request, "" for none.
  /// Called by several threads at once; must not throw.
  using Handler = std::function<ServedContent(const std::string& query)>;

  /// Serves from now on. @param pages  by path, e.g. "/" and "/document.json".
  /// @throws InputError when the address cannot be bound (it is in use, or not of this
  ///   machine).
  PageServer(const ServerAddress& address, std::map<std::string, Handler> pages);
  /// Cuts off who is still asking.
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /// To be opened in a browser, e.g. "http://127.0.0.1:8800/".
  [[nodiscard]] const std::string& Url() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::live
