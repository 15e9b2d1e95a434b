#include "app/bags/message_encoding.hpp"

#include <gtest/gtest.h>

#include <string>

#include "app/bags/cdr_writer.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::bags {
namespace {

using Bytes = std::vector<std::uint8_t>;

// Bytes as hexadecimal digits; blanks are for people.
Bytes FromHex(const std::string& text) {
  Bytes bytes;
  std::string digits;
  for (const char c : text) {
    if (c != ' ') digits += c;
  }
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(digits.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

TEST(CdrWriter, AlignsNumbersToTheirSizeAfterTheStart) {
  CdrWriter out;
  out.Put(std::uint8_t{1});
  out.Put(1.0);
  out.Put(true);
  out.Put(std::uint16_t{0x0203});
  out.Put(std::uint8_t{4});
  out.Put(-2);
  out.Put(1.0F);
  EXPECT_EQ(out.Take(),
            FromHex("00010000"
                    "01 00000000000000"
                    "000000000000f03f"
                    "01 00 0302"
                    "04 000000"
                    "feffffff"
                    "0000803f"));
}

TEST(CdrWriter, TextsEndWithZeroAndSequencesBeginWithTheirLength) {
  CdrWriter out;
  out.PutText("ab");
  out.PutText("");
  out.PutBytes(Bytes{7, 8});
  out.PutCount(1);
  out.PutAll(std::array<double, 1>{2});
  EXPECT_EQ(out.Take(),
            FromHex("00010000"
                    "03000000 616200 00"
                    "01000000 00 000000"
                    "02000000 0708 0000"
                    "01000000 00000000 0000000000000040"));
}

TEST(Encode, TransformsByteByByte) {
  TransformStamped transform;
  transform.header = {5'000'000'007, "map"};
  transform.child_frame_id = "b";
  transform.transform = {{1, 2, -2}, {0, 0, 0.5, 1}};
  EXPECT_EQ(Encode(std::vector{transform}),
            FromHex("00010000"
                    "01000000"
                    "05000000 07000000"
                    "04000000 6d617000"
                    "02000000 6200 0000 00000000"
                    "000000000000f03f 0000000000000040 00000000000000c0"
                    "0000000000000000 0000000000000000 000000000000e03f 000000000000f03f"));
}

TEST(Encode, ImageByteByByte) {
  const Bytes pixels = {9, 8};
  ImageMessage image;
  image.header.stamp_ns = 1;
  image.height = 1;
  image.width = 2;
  image.encoding = "mono8";
  image.big_endian = true;
  image.step = 2;
  image.data = pixels;
  EXPECT_EQ(Encode(image),
            FromHex("00010000"
                    "00000000 01000000"
                    "01000000 00 000000"
                    "01000000 02000000"
                    "06000000 6d6f6e6f3800"
                    "01 00"
                    "02000000"
                    "02000000 0908"));
}

TEST(Encode, DiagnosticsByteByByte) {
  DiagnosticsMessage message;
  message.header = {0, ""};
  message.status = {{DiagnosticsMessage::Level::kError, "n", "m", "h", {{"k", "v"}}}};
  EXPECT_EQ(Encode(message),
            FromHex("00010000"
                    "00000000 00000000"
                    "01000000 00 000000"
                    "01000000"
                    "02 000000"
                    "02000000 6e00 0000"
                    "02000000 6d00 0000"
                    "02000000 6800 0000"
                    "01000000"
                    "02000000 6b00 0000"
                    "02000000 7600"));
}

TEST(Encode, GridByteByByte) {
  GridMessage grid;
  grid.header = {2'000'000'003, "map"};
  grid.resolution_m = 0.5F;
  grid.width = 3;
  grid.height = 1;
  grid.data = {0, 100, 255};
  EXPECT_EQ(Encode(grid),
            FromHex("00010000"
                    "02000000 03000000"
                    "04000000 6d617000"
                    "02000000 03000000"
                    "0000003f 03000000 01000000 00000000"
                    "0000000000000000 0000000000000000 0000000000000000"
                    "0000000000000000 0000000000000000 0000000000000000 000000000000f03f"
                    "03000000 0064ff"));
}

TEST(Nanoseconds, AreExactForTimesWithMicroseconds) {
  EXPECT_EQ(Nanoseconds(0), 0);
  EXPECT_EQ(Nanoseconds(0.1), 100'000'000);
  EXPECT_EQ(Nanoseconds(100.033333), 100'033'333'000);
  // A double of today's time has steps of 238 ns.
  EXPECT_NEAR(
      static_cast<double>(Nanoseconds(1'700'000'000.123456) - 1'700'000'000'123'456'000), 0, 120);
  EXPECT_EQ(Nanoseconds(0.9999999999), 1'000'000'000);
}

TEST(Nanoseconds, RefusesWhatRosCannotExpress) {
  for (const auto& [stamp_s, text] : {std::pair{-0.5, "-0.500000"},
                                      {2147483647.0, "2147483647.000000"},
                                      {std::numeric_limits<double>::quiet_NaN(), "nan"}}) {
    try {
      Nanoseconds(stamp_s);
      FAIL();
    } catch (const InputError& error) {
      EXPECT_EQ(
          error.what(),
          "time " + std::string(text) + " s cannot be written to a bag, must be from 1970 to 2038");
    }
  }
}

}  // namespace
}  // namespace ceilmap::bags
