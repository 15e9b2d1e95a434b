#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "app/page/page.hpp"
#include "tests/app/page/browser.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::page {
/// Pages in a real browser, one for all tests: it takes a second to start.
class PageInBrowser : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_.emplace();
    browser_ = Browser::Start(*folder_ / "profile");
  }
  static void TearDownTestSuite() {
    browser_.reset();
    folder_.reset();
  }
  void SetUp() override {
    if (!browser_)
      GTEST_SKIP() << "chromedriver is not installed (samples/install-deps.sh --tests)";
    browser_->Resize(1000, 700);  // fewer pixels, less time
  }
  void TearDown() override {
    if (!browser_) return;
    EXPECT_THAT(browser_->ConsoleMessages(), testing::IsEmpty());
  }

  static void Open(const PageData& data) {
    browser_->Open("file://" + folder_->Write("index.html", WritePage(data)).string());
  }
  static nlohmann::json State() { return browser_->Run("return ceilmap.state()"); }
  static void SetTime(double stamp_s) { browser_->Run("ceilmap.setTime(arguments[0])", {stamp_s}); }
  static nlohmann::json RobotNamed(const std::string& name) {
    const nlohmann::json state = State();
    for (const nlohmann::json& robot : state["robots"]) {
      if (robot["name"] == name) return robot;
    }
    return nullptr;
  }
  static nlohmann::json PixelOf(double x, double y) {
    return browser_->Run("return ceilmap.pixelOf(arguments[0], arguments[1])", {x, y});
  }
  static void ExpectNear(const nlohmann::json& pixel, const nlohmann::json& expected) {
    EXPECT_NEAR(pixel[0].get<double>(), expected[0].get<double>(), 1);
    EXPECT_NEAR(pixel[1].get<double>(), expected[1].get<double>(), 1);
  }
  static std::string TextOf(const std::string& selector) {
    return browser_->Run("return document.querySelector(arguments[0]).textContent", {selector});
  }
  /// Screenshots for people, in the folder CEILMAP_SCREENSHOTS if it is set.
  static void Show(const std::string& name, bool phone = false) {
    const char* const folder = std::getenv("CEILMAP_SCREENSHOTS");
    if (folder == nullptr) return;
    if (!phone) browser_->Resize(1440, 1000);
    ASSERT_TRUE(browser_->WaitFor("[...document.images].every((image) => image.complete)"));
    browser_->Screenshot(std::filesystem::path(folder) / (name + ".png"));
  }

  inline static std::optional<support::TestFolder> folder_;
  inline static std::unique_ptr<Browser> browser_;
};

}  // namespace ceilmap::page
