#include "app/bags/messages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "app/bags/message_error.hpp"
#include "tests/app/bags/bag_bytes.hpp"

namespace ceilmap::bags {
namespace {

using bytes::MessageBytes;
using testing::ElementsAre;
using Form = MessageBytes::Form;

std::span<const std::uint8_t> Span(const std::string& bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

class MessagesTest : public testing::TestWithParam<Form> {
 protected:
  static MessageEncoding Encoding() {
    return GetParam() == Form::kRos1 ? MessageEncoding::kRos1 : MessageEncoding::kCdr;
  }
  /// Decoding of every part that ends early is refused, and none reads beyond.
  template <typename Decode>
  static void ExpectRefusedWhenCut(const std::string& bytes, std::size_t end, Decode decode) {
    for (std::size_t size = 0; size < end; ++size) {
      const std::vector<std::uint8_t> part(bytes.begin(), bytes.begin() + static_cast<long>(size));
      EXPECT_THROW(decode(std::span<const std::uint8_t>(part), Encoding()), MessageError) << size;
    }
  }
};

TEST_P(MessagesTest, DecodesImage) {
  const std::string data = MessageBytes(GetParam())
                               .PutHeader(12, 34, "camera")
                               .Put(std::uint32_t{2})
                               .Put(std::uint32_t{3})
                               .PutText("mono8")
                               .Put(std::uint8_t{1})
                               .Put(std::uint32_t{4})
                               .PutBytes("abc_def_")
                               .Bytes();
  const ImageMessage message = DecodeImage(Span(data), Encoding());
  EXPECT_EQ(message.header.stamp_ns, 12'000'000'034);
  EXPECT_EQ(message.header.frame_id, "camera");
  EXPECT_EQ(message.height, 2U);
  EXPECT_EQ(message.width, 3U);
  EXPECT_EQ(message.encoding, "mono8");
  EXPECT_TRUE(message.big_endian);
  EXPECT_EQ(message.step, 4U);
  EXPECT_EQ(std::string(message.data.begin(), message.data.end()), "abc_def_");
  EXPECT_EQ(DecodeHeader(Span(data), Encoding()).stamp_ns, 12'000'000'034);
  ExpectRefusedWhenCut(data, data.size(), DecodeImage);
}

TEST_P(MessagesTest, DecodesCompressedImage) {
  const std::string data =
      MessageBytes(GetParam()).PutHeader(1, 0, "").PutText("jpeg").PutBytes("JPEG").Bytes();
  const CompressedImageMessage message = DecodeCompressedImage(Span(data), Encoding());
  EXPECT_EQ(message.format, "jpeg");
  EXPECT_EQ(std::string(message.data.begin(), message.data.end()), "JPEG");
  ExpectRefusedWhenCut(data, data.size(), DecodeCompressedImage);
}

TEST_P(MessagesTest, DecodesCameraInfo) {
  const std::string data = MessageBytes(GetParam())
                               .PutHeader(1, 0, "c")
                               .Put(std::uint32_t{480})
                               .Put(std::uint32_t{640})
                               .PutText("plumb_bob")
                               .Put(std::uint32_t{5})
                               .PutDoubles({0.1, 0.2, 0.3, 0.4, 0.5})
                               .PutDoubles({1, 2, 3, 4, 5, 6, 7, 8, 9})
                               .Bytes();
  const CameraInfoMessage message = DecodeCameraInfo(Span(data), Encoding());
  EXPECT_EQ(message.width, 640U);
  EXPECT_EQ(message.height, 480U);
  EXPECT_EQ(message.distortion_model, "plumb_bob");
  EXPECT_THAT(message.d, ElementsAre(0.1, 0.2, 0.3, 0.4, 0.5));
  EXPECT_THAT(message.k, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
  ExpectRefusedWhenCut(data, data.size(), DecodeCameraInfo);
}

std::vector<double> Counted(double first, std::size_t count) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(first + static_cast<double>(i));
  return numbers;
}

TEST_P(MessagesTest, DecodesOdometry) {
  const std::string data = MessageBytes(GetParam())
                               .PutHeader(-1, 999'999'999, "odom")
                               .PutText("base")
                               .PutDoubles({1, 2, 3, 0.1, 0.2, 0.3, 0.4})
                               .PutDoubles(Counted(100, 36))
                               .PutDoubles({4, 5, 6, 7, 8, 9})
                               .PutDoubles(Counted(200, 36))
                               .Bytes();
  const OdometryMessage message = DecodeOdometry(Span(data), Encoding());
  EXPECT_EQ(message.header.stamp_ns, GetParam() == Form::kRos1 ? 4'294'967'295'999'999'999 : -1);
  EXPECT_EQ(message.child_frame_id, "base");
  EXPECT_THAT(message.pose.translation, ElementsAre(1, 2, 3));
  EXPECT_THAT(message.pose.rotation, ElementsAre(0.1, 0.2, 0.3, 0.4));
  EXPECT_THAT(message.pose_covariance, testing::ElementsAreArray(Counted(100, 36)));
  EXPECT_THAT(message.linear, ElementsAre(4, 5, 6));
  EXPECT_THAT(message.angular, ElementsAre(7, 8, 9));
  EXPECT_THAT(message.twist_covariance, testing::ElementsAreArray(Counted(200, 36)));
  ExpectRefusedWhenCut(data, data.size(), DecodeOdometry);
}

TEST_P(MessagesTest, DecodesImu) {
  const std::string data = MessageBytes(GetParam())
                               .PutHeader(1, 2, "imu")
                               .PutDoubles(Counted(1, 13))
                               .PutDoubles({0.5, 0.6, 0.7})
                               .PutDoubles(Counted(1, 21))
                               .Bytes();
  EXPECT_THAT(DecodeImu(Span(data), Encoding()).angular_velocity, ElementsAre(0.5, 0.6, 0.7));
}

TEST_P(MessagesTest, DecodesTransforms) {
  MessageBytes composed(GetParam());
  composed.Put(std::uint32_t{2});
  for (const char* child : {"camera", "wheel"}) {
    composed.PutHeader(3, 4, "base").PutText(child).PutDoubles({1, 2, 3, 0, 0, 0, 1});
  }
  const std::string data = composed.Bytes();
  const std::vector<TransformStamped> transforms = DecodeTransforms(Span(data), Encoding());
  ASSERT_EQ(transforms.size(), 2U);
  EXPECT_EQ(transforms[1].header.stamp_ns, 3'000'000'004);
  EXPECT_EQ(transforms[1].header.frame_id, "base");
  EXPECT_EQ(transforms[1].child_frame_id, "wheel");
  EXPECT_THAT(transforms[1].transform.translation, ElementsAre(1, 2, 3));
  EXPECT_THAT(transforms[1].transform.rotation, ElementsAre(0, 0, 0, 1));
  ExpectRefusedWhenCut(data, data.size(), DecodeTransforms);
}

std::string NameOfForm(const testing::TestParamInfo<Form>& form) {
  constexpr std::array<const char*, 3> kNames = {"CdrLittle", "CdrBig", "Ros1"};
  return kNames.at(static_cast<std::size_t>(form.param));
}

INSTANTIATE_TEST_SUITE_P(Forms,
                         MessagesTest,
                         testing::Values(Form::kCdrLittle, Form::kCdrBig, Form::kRos1),
                         NameOfForm);

std::string RefusalOf(const std::string& data, MessageEncoding encoding) {
  try {
    (void)DecodeTransforms(Span(data), encoding);
  } catch (const MessageError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Messages, SayWhatIsWrong) {
  EXPECT_EQ(RefusalOf("{}", MessageEncoding::kOther), "is serialized neither by CDR nor by ROS 1");
  EXPECT_EQ(RefusalOf("abc", MessageEncoding::kCdr), "has 3 bytes, less than the header of CDR");
  EXPECT_EQ(RefusalOf(std::string("\0\7\0\0", 4), MessageEncoding::kCdr),
            "has the representation 0x0007, must be CDR (0x0000, 0x0001)");
  EXPECT_EQ(RefusalOf(std::string("\0\1\0\0\xFF\xFF\xFF\xFF", 8), MessageEncoding::kCdr),
            "has a sequence of 4294967295 elements, but ends 0 bytes later");
  EXPECT_EQ(RefusalOf("ab", MessageEncoding::kRos1),
            "ends early: a number of 4 bytes, of which 2 are there");
}

}  // namespace
}  // namespace ceilmap::bags
