#include "app/bags/result_messages.hpp"

#include <gtest/gtest.h>

#include <random>

#include "app/bags/bag_reader.hpp"
#include "app/bags/message_error.hpp"
#include "tests/app/bags/all_messages.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::bags {
namespace {

constexpr auto kCdr = MessageEncoding::kCdr;

void ExpectSame(const Header& read, const Header& written) {
  EXPECT_EQ(read.stamp_ns, written.stamp_ns);
  EXPECT_EQ(read.frame_id, written.frame_id);
}

void ExpectSame(const Transform& read, const Transform& written) {
  EXPECT_EQ(read.translation, written.translation);
  EXPECT_EQ(read.rotation, written.rotation);
}

TEST(RoundTrip, Image) {
  const ImageMessage written = AnImage();
  const auto bytes = Encode(written);
  const ImageMessage read = DecodeImage(bytes, kCdr);
  ExpectSame(read.header, written.header);
  EXPECT_EQ(read.height, written.height);
  EXPECT_EQ(read.width, written.width);
  EXPECT_EQ(read.encoding, written.encoding);
  EXPECT_EQ(read.big_endian, written.big_endian);
  EXPECT_EQ(read.step, written.step);
  EXPECT_EQ(std::vector<std::uint8_t>(read.data.begin(), read.data.end()), kPixels);
}

TEST(RoundTrip, CompressedImage) {
  const auto bytes = Encode(ACompressedImage());
  const CompressedImageMessage read = DecodeCompressedImage(bytes, kCdr);
  ExpectSame(read.header, kHeader);
  EXPECT_EQ(read.format, "jpeg");
  EXPECT_EQ(std::vector<std::uint8_t>(read.data.begin(), read.data.end()), kPixels);
}

TEST(RoundTrip, CameraInfo) {
  const CameraInfoMessage written = ACameraInfo();
  const CameraInfoMessage read = DecodeCameraInfo(Encode(written), kCdr);
  ExpectSame(read.header, written.header);
  EXPECT_EQ(read.height, written.height);
  EXPECT_EQ(read.width, written.width);
  EXPECT_EQ(read.distortion_model, written.distortion_model);
  EXPECT_EQ(read.d, written.d);
  EXPECT_EQ(read.k, written.k);
}

TEST(RoundTrip, Odometry) {
  const OdometryMessage written = AnOdometry();
  const OdometryMessage read = DecodeOdometry(Encode(written), kCdr);
  ExpectSame(read.header, written.header);
  EXPECT_EQ(read.child_frame_id, written.child_frame_id);
  ExpectSame(read.pose, written.pose);
  EXPECT_EQ(read.pose_covariance, written.pose_covariance);
  EXPECT_EQ(read.linear, written.linear);
  EXPECT_EQ(read.angular, written.angular);
  EXPECT_EQ(read.twist_covariance, written.twist_covariance);
}

TEST(RoundTrip, Imu) {
  const ImuMessage read = DecodeImu(Encode(AnImu()), kCdr);
  ExpectSame(read.header, kHeader);
  EXPECT_EQ(read.angular_velocity, AnImu().angular_velocity);
}

TEST(RoundTrip, Transforms) {
  const auto written = TwoTransforms();
  const auto read = DecodeTransforms(Encode(written), kCdr);
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    ExpectSame(read[i].header, written[i].header);
    EXPECT_EQ(read[i].child_frame_id, written[i].child_frame_id);
    ExpectSame(read[i].transform, written[i].transform);
  }
}

TEST(RoundTrip, Pose) {
  const PoseMessage read = DecodePose(Encode(APose()), kCdr);
  ExpectSame(read.header, kHeader);
  ExpectSame(read.pose, kTransform);
  EXPECT_EQ(read.covariance, APose().covariance);
}

TEST(RoundTrip, Diagnostics) {
  const DiagnosticsMessage written = SomeDiagnostics();
  const DiagnosticsMessage read = DecodeDiagnostics(Encode(written), kCdr);
  ExpectSame(read.header, written.header);
  ASSERT_EQ(read.status.size(), written.status.size());
  for (std::size_t i = 0; i < read.status.size(); ++i) {
    EXPECT_EQ(read.status[i].level, written.status[i].level);
    EXPECT_EQ(read.status[i].name, written.status[i].name);
    EXPECT_EQ(read.status[i].message, written.status[i].message);
    EXPECT_EQ(read.status[i].hardware_id, written.status[i].hardware_id);
    EXPECT_EQ(read.status[i].values, written.status[i].values);
  }
}

TEST(RoundTrip, CutMessagesThrow) {
  for (const auto& bytes : {Encode(APose()), Encode(SomeDiagnostics())}) {
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const std::span<const std::uint8_t> cut(bytes.data(), size);
      if (bytes == Encode(APose())) {
        EXPECT_THROW(DecodePose(cut, kCdr), MessageError) << size;
      } else {
        EXPECT_THROW(DecodeDiagnostics(cut, kCdr), MessageError) << size;
      }
    }
  }
}

// A wrong length must not cost memory or leave the message; the sanitizers watch.
TEST(RoundTrip, DamagedMessagesAreDecodedOrThrow) {
  std::mt19937 random(7);
  const std::vector<std::vector<std::uint8_t>> messages = {Encode(APose()),
                                                           Encode(SomeDiagnostics())};
  int refused = 0;
  for (int i = 0; i < 4000; ++i) {
    std::vector<std::uint8_t> bytes = messages[i % 2];
    for (int change = 0; change < 3; ++change) {
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    }
    try {
      if (i % 2 == 0) {
        (void)DecodePose(bytes, kCdr);
      } else {
        (void)DecodeDiagnostics(bytes, kCdr);
      }
    } catch (const MessageError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);
  EXPECT_LT(refused, 3500);
}

TEST(RoundTrip, BagsAreReadAsWritten) {
  const support::TestFolder folder;
  for (const Compression compression :
       {Compression::kNone, Compression::kZstd, Compression::kLz4}) {
    const auto file = folder / "t.mcap";
    McapWriter writer(file, {.compression = compression, .chunk_bytes = 5000});
    WriteAllMessages(writer);
    writer.Commit();
    const auto bag = BagReader::Open(file);
    EXPECT_EQ(bag->Facts().format, "MCAP");
    EXPECT_EQ(bag->Facts().compression, NameOf(compression));
    std::vector<std::string> topics;
    std::int64_t time_ns = kHeader.stamp_ns;
    for (RawMessage message; bag->Next(message); time_ns += 1'000'000) {
      const Topic& topic = bag->Topics()[message.topic];
      EXPECT_EQ(message.log_time_ns, time_ns);
      EXPECT_EQ(topic.encoding, kCdr);
      EXPECT_EQ(topic.messages, 1);
      topics.push_back(topic.name);
    }
    EXPECT_EQ(topics,
              (std::vector<std::string>{"/image",
                                        "/compressed",
                                        "/camera_info",
                                        "/odom",
                                        "/imu",
                                        "/tf",
                                        "/pose",
                                        "/path",
                                        "/map",
                                        "/diagnostics"}));
    EXPECT_EQ(bag->Warnings(), std::vector<std::string>{});
  }
}

}  // namespace
}  // namespace ceilmap::bags
