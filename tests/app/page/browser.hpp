#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ceilmap::page {

/// Chromium without a window, driven through chromedriver by the W3C WebDriver protocol. Calls
/// throw std::runtime_error with the driver's message when the browser refuses.
class Browser {
 public:
  /// Null when no chromedriver is installed.
  /// @param folder  for the browser's own files.
  static std::unique_ptr<Browser> Start(const std::filesystem::path& folder);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  void Open(const std::string& url);
  /// What a function of this body returns; `arguments` are in it.
  nlohmann::json Run(const std::string& body,
                     const nlohmann::json& arguments = nlohmann::json::array());
  /// Until an expression holds on the page; false when it does not within 20 s.
  bool WaitFor(const std::string& expression);
  /// As a user does; the element is scrolled into view.
  void Click(const std::string& selector);
  /// With the mouse, from one pixel of an element's rectangle to another; the same: a click.
  void Drag(const std::string& selector, int from_x, int from_y, int to_x, int to_y);
  void Press(const std::string& key);
  void Resize(int width, int height, bool phone = false);
  /// Of the whole page, as PNG.
  void Screenshot(const std::filesystem::path& file);
  /// Errors and warnings since the last call.
  std::vector<std::string> ConsoleMessages();
  bool HasAlert();

 private:
  struct Impl;
  explicit Browser(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::page
