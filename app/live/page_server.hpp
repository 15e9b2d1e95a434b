#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

namespace ceilmap::live {

/// Address of a page server.
struct ServerAddress {
  std::string host = "127.0.0.1";  ///< this machine only; 0.0.0.0: whoever reaches it
  int port = 0;                    ///< 0: any free port
};

/// `[HOST:]PORT`, e.g. "8800", "0.0.0.0:8800" or "[::1]:8800". `option` is used in the message.
/// @throws InputError
ServerAddress ParseServerAddress(const std::string& text, const std::string& option);

/// Content of a path.
struct ServedContent {
  std::string mime;  ///< e.g. "text/html; charset=utf-8"
  std::string body;
};

/// A small HTTP server for a few fixed paths, in its own threads: GET and HEAD only, no files, no
/// bodies. It serves a page to a few clients and limits misuse: a request has at most 8 KiB, must
/// be complete within 4 s and is answered within 60 s, four are answered at a time and 32 wait
/// (app/live/page_http.hpp). A slow or hostile client can block the page for other clients, but not
/// the program. When bound to this machine, requests that name another host are refused, which
/// prevents access by pages of other sites (DNS rebinding).
class PageServer {
 public:
  /// Returns the content of a page. @param query  The part of the request after `?`, "" for none.
  /// Called by several threads at once; must not throw.
  using Handler = std::function<ServedContent(const std::string& query)>;

  /// Starts the server. @param pages  By path, e.g. "/" and "/document.json".
  /// @throws InputError when the address cannot be bound: it is in use, or not an address of this
  /// machine.
  PageServer(const ServerAddress& address, std::map<std::string, Handler> pages);
  /// Ends open connections.
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /// Address for a browser, e.g. "http://127.0.0.1:8800/".
  [[nodiscard]] const std::string& Url() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::live
