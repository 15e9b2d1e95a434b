#include "mapping/store/range_answer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "calib/base/error.hpp"

namespace ceilmap::store {
namespace {

using testing::HasSubstr;

/// The first 16 of 100 bytes.
class RangeAnswerTest : public testing::Test {
 protected:
  RangeAnswerTest() {
    response_.content_range = "bytes 0-15/100";
    response_.etag = "\"1\"";
    response_.body = bytes_;
  }
  std::string Refused(std::uint64_t offset = 0, std::uint64_t bytes = 16) {
    try {
      (void)CheckedAnswer(response_, offset, bytes);
    } catch (const TransientError& error) {
      return std::string("again: ") + error.what();
    } catch (const BeyondEnd& error) {
      return std::string("end: ") + error.what();
    } catch (const InputError& error) {
      return std::string("input: ") + error.what();
    }
    return "none";
  }

  const std::vector<unsigned char> bytes_ = std::vector<unsigned char>(16, 7);
  RangeResponse response_;
};

TEST_F(RangeAnswerTest, HoldsWhatWasAskedFor) {
  const RangeAnswer answer = CheckedAnswer(response_, 0, 16);
  EXPECT_EQ(answer.bytes, bytes_);
  EXPECT_EQ(answer.file_bytes, 100U);
  const std::string version = answer.version;
  response_.etag = "\"2\"";
  EXPECT_NE(CheckedAnswer(response_, 0, 16).version, version);
  response_.etag = "\"1\"";
  response_.content_range = "bytes 0-15/101";
  EXPECT_NE(CheckedAnswer(response_, 0, 16).version, version) << "of another length";
}

TEST_F(RangeAnswerTest, MayBeShorterOnlyAtTheEnd) {
  response_.content_range = "bytes 84-99/100";
  EXPECT_EQ(CheckedAnswer(response_, 84, 1000).bytes.size(), 16U);
  response_.content_range = "bytes 83-98/100";
  EXPECT_THAT(Refused(83, 1000), HasSubstr("input: the server sends a smaller part"));
}

TEST_F(RangeAnswerTest, OfAnotherRangeIsRefused) {
  for (const char* range : {"bytes 1-16/100",
                            "bytes 0-16/100",
                            "bytes 15-0/100",
                            "bytes 0-15/15",
                            "bytes 0-15/*",
                            "bytes */100",
                            "bytes 0-15/100 ",
                            "bytes 0-15",
                            "bytes -15/100",
                            "items 0-15/100",
                            "bytes 0-18446744073709551615/100",
                            "bytes 0-15/18446744073709551616",
                            "bytes 0--1/100"}) {
    response_.content_range = range;
    EXPECT_EQ(Refused(), "input: the server sends another part of the file than was asked for")
        << range;
  }
}

TEST_F(RangeAnswerTest, OfAnImpossibleLengthIsRefused) {
  for (const char* length : {"18446744073709551615", "9223372036854775808", "281474976710657"}) {
    response_.content_range = std::string("bytes 0-15/") + length;
    EXPECT_THAT(Refused(), HasSubstr("input: the server states a length that no map has"))
        << length;
  }
  response_.content_range = "bytes 0-15/281474976710656";
  EXPECT_EQ(Refused(), "none");
}

TEST_F(RangeAnswerTest, ThatIsIncompleteIsAskedForAgain) {
  response_.body = response_.body.first(15);
  EXPECT_EQ(Refused(), "again: the server's answer is incomplete");
  response_.body = bytes_;
  response_.complete = false;
  response_.message = "timeout";
  EXPECT_EQ(Refused(), "again: timeout");
  response_.body = {};
  response_.content_range = "";
  response_.message = "";
  EXPECT_EQ(Refused(), "again: the server's answer is incomplete");
}

TEST_F(RangeAnswerTest, OfTheWholeFileOrWithoutAVersionIsRefused) {
  response_.etag = "";
  EXPECT_THAT(Refused(), HasSubstr("input: the server sends neither ETag nor Last-Modified"));
  response_.content_range = "";
  EXPECT_THAT(Refused(), HasSubstr("input: the server does not send parts of a file"));
  response_.complete = false;
  response_.too_large = true;
  response_.body = {};
  EXPECT_THAT(Refused(), HasSubstr("input: the server does not send parts of a file"));
}

TEST_F(RangeAnswerTest, StatesTheStatusOfTheServer) {
  for (const auto& [status, text] : {std::pair{416, "end: the file is shorter"},
                                     {404, "input: the server has no such file"},
                                     {403, "input: the server does not allow"},
                                     {429, "again: the server answers with HTTP status 429"},
                                     {599, "again: the server answers with HTTP status 599"},
                                     {400, "input: the server refuses the request"}}) {
    response_.status = status;
    EXPECT_THAT(Refused(), testing::StartsWith(text));
  }
}

}  // namespace
}  // namespace ceilmap::store
