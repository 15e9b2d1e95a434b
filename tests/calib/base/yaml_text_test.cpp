#include "calib/base/yaml_text.hpp"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <string>

namespace ceilmap {
namespace {

TEST(QuotedText, ReadsBackAsItWas) {
  for (const char* text : {"", "robot 1", "\"up\"", "C:\\rigs\\#1: a", "x: [1, 2]", "é"}) {
    EXPECT_EQ(YAML::Load(QuotedText(text)).as<std::string>(), text);
  }
}

TEST(QuotedText, HasNoControlCharacters) {
  EXPECT_EQ(QuotedText("a\nb\tc"), "\"a b c\"");
}

TEST(NumberText, WritesNoMoreThanItNeeds) {
  EXPECT_EQ(NumberText(0.14), "0.14");
  EXPECT_EQ(NumberText(-457.014), "-457.014");
  EXPECT_EQ(NumberText(1.0 / 3), "0.333333333");
  EXPECT_EQ(NumberText(640), "640");
}

TEST(NumberText, RoundingNoiseIsZero) {
  EXPECT_EQ(NumberText(1e-17), "0");
  EXPECT_EQ(NumberText(-1e-17), "0");
}

}  // namespace
}  // namespace ceilmap
