#include "app/recordings/bag_source.hpp"

#include <gmock/gmock.h>

#include "app/recordings/bag_options.hpp"
#include "calib/base/error.hpp"
#include "tests/app/recordings/memory_bag.hpp"
#include "tests/support/test_bag.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

using bags::MessageEncoding;

std::shared_ptr<BagRecording> BagWith(std::vector<bags::Topic> topics) {
  auto content = std::make_shared<MemoryBagContent>();
  content->topics = std::move(topics);
  return OpenMemoryBag(content);
}

std::string Found(const std::shared_ptr<BagRecording>& bag,
                  const std::string& topic,
                  TopicUse use,
                  const std::string& option = "--up-topic") {
  try {
    return bag->Topics().at(FindTopic(*bag, {.topic = topic, .option = option}, use)).name;
  } catch (const InputError& error) {
    return error.what();
  }
}

const bags::Topic kUp{"/up/image_raw", "sensor_msgs/msg/Image", MessageEncoding::kCdr, {}};
const bags::Topic kFront{
    "/front/image_raw/compressed", "sensor_msgs/msg/CompressedImage", MessageEncoding::kCdr, {}};
const bags::Topic kOdom{"/odom", "nav_msgs/msg/Odometry", MessageEncoding::kCdr, {}};
const bags::Topic kJson{"/up", "sensor_msgs/msg/Image", MessageEncoding::kOther, {}};
const bags::Topic kEmpty{"/up", "sensor_msgs/msg/Image", MessageEncoding::kCdr, 0};
const bags::Topic kTf{"/tf", "tf2_msgs/msg/TFMessage", MessageEncoding::kCdr, {}};

TEST(FindTopic, TakesTheOnlyOneOfItsUse) {
  const auto bag = BagWith({kOdom, kTf, kUp});
  EXPECT_EQ(Found(bag, "", TopicUse::kImages), "/up/image_raw");
  EXPECT_EQ(Found(bag, "", TopicUse::kOdometry), "/odom");
  EXPECT_EQ(Found(bag, "", TopicUse::kGyro),
            "run.mcap: has no topic of a gyro (sensor_msgs/msg/Imu); its topics are /odom "
            "(nav_msgs/msg/Odometry), /tf (tf2_msgs/msg/TFMessage), /up/image_raw "
            "(sensor_msgs/msg/Image)");
}

TEST(FindTopic, ListsThoseThatMayBeMeant) {
  const auto bag = BagWith({kFront, kOdom, kUp});
  EXPECT_EQ(Found(bag, "", TopicUse::kImages),
            "run.mcap: has 2 topics of images, /front/image_raw/compressed, /up/image_raw; choose "
            "one by --up-topic");
  EXPECT_EQ(Found(bag, "", TopicUse::kImages, ""),
            "run.mcap: has 2 topics of images, /front/image_raw/compressed, /up/image_raw; choose "
            "one");
}

TEST(FindTopic, ChecksANamedOne) {
  const auto bag = BagWith({kFront, kTf, kUp});
  EXPECT_EQ(Found(bag, "/up/image_raw", TopicUse::kImages), "/up/image_raw");
  EXPECT_EQ(Found(bag, "up/image_raw", TopicUse::kImages), "/up/image_raw");
  EXPECT_EQ(Found(bag, "/tf", TopicUse::kOdometry), "/tf") << "only where it is named";
  EXPECT_EQ(Found(bag, "/up", TopicUse::kImages),
            "run.mcap: has no topic /up; its topics are /front/image_raw/compressed "
            "(sensor_msgs/msg/CompressedImage), /tf (tf2_msgs/msg/TFMessage), /up/image_raw "
            "(sensor_msgs/msg/Image)");
  EXPECT_EQ(Found(bag, "/tf", TopicUse::kImages),
            "run.mcap: /tf holds messages of tf2_msgs/msg/TFMessage, must be sensor_msgs/msg/Image "
            "or sensor_msgs/msg/CompressedImage for images");
}

TEST(FindTopic, RefusesWhatCannotBeDecodedOrIsEmpty) {
  EXPECT_EQ(Found(BagWith({kJson}), "", TopicUse::kImages),
            "run.mcap: the messages of /up are serialized neither as by ROS 2 (CDR) nor as by ROS "
            "1; record the topic with rosbag");
  EXPECT_EQ(Found(BagWith({kEmpty}), "", TopicUse::kImages), "run.mcap: /up holds no messages");
  EXPECT_EQ(Found(BagWith({}), "", TopicUse::kImages),
            "run.mcap: has no topic of images (sensor_msgs/msg/Image or "
            "sensor_msgs/msg/CompressedImage); its topics are none");
}

class BagOptionsTest : public testing::Test {
 protected:
  BagOptionsTest() {
    support::TestBag bag(folder_ / "run.mcap");
    bag.Write("/odom", bags::kOdometryType, 1, bags::OdometryMessage());
    bag.Commit();
    folder_.Write("up.mp4", "no bag");
    bag_ = (folder_ / "run.mcap").string();
    video_ = (folder_ / "up.mp4").string();
  }
  static BagOptions Parse(std::vector<std::string> arguments) {
    BagOptions options;
    CLI::App cli;
    options.AddTo(cli, {"up", "odometry"});
    std::reverse(arguments.begin(), arguments.end());
    cli.parse(arguments);
    return options;
  }

  support::TestFolder folder_;
  std::string bag_;
  std::string video_;
};

TEST_F(BagOptionsTest, ATopicAloneIsOfTheBagOfTheMainSource) {
  const BagOptions options = Parse({"--odometry-topic=/odom", "--stamp=log"});
  EXPECT_EQ(options.Complete("odometry", "", "up", bag_), bag_);
  EXPECT_EQ(options.Complete("odometry", bag_, "up", video_), bag_);
  EXPECT_EQ(options.Topic("odometry").topic, "/odom");
  EXPECT_EQ(options.Topic("odometry").option, "--odometry-topic");
  EXPECT_EQ(options.Topic("odometry").stamp, BagStamp::kLog);
  EXPECT_EQ(options.Topic("odometry").bags, options.Topic("up").bags) << "one pass";
  EXPECT_EQ(options.TopicAlone("odometry").bags, nullptr);
  EXPECT_EQ(options.Topic("up").topic, "");
  EXPECT_EQ(Parse({}).Topic("up").stamp, BagStamp::kHeader);
  EXPECT_EQ(Parse({}).Complete("odometry", "", "up", bag_), "") << "no topic: not asked for";
}

TEST_F(BagOptionsTest, RefusesTopicsOfWhatIsNoBag) {
  const BagOptions options = Parse({"--odometry-topic=/odom", "--up-topic=/up"});
  support::ExpectInputError([&] { (void)options.Complete("odometry", "", "up", video_); },
                            {"--odometry-topic: " + video_ +
                             " of --up is no bag, and no other is given; leave it out, or name "
                             "the bag"});
  support::ExpectInputError(
      [&] { (void)options.Complete("odometry", video_, "up", bag_); },
      {"--odometry-topic: " + video_ + " is no bag, which has topics; leave it out"});
  support::ExpectInputError(
      [&] { options.CheckMain("up", video_); },
      {"--up-topic: " + video_ + " is no bag, which has topics; leave it out"});
  options.CheckMain("up", bag_);
  options.CheckMain("up", "missing.mcap");  // what opens it says so
}

TEST_F(BagOptionsTest, ABagIsOpenedOnce) {
  OpenBags bags;
  EXPECT_EQ(bags.Get(bag_),
            bags.Get((folder_ / "../" / folder_.Path().filename() / "run.mcap").string()));
  EXPECT_TRUE(IsBag(bag_));
  EXPECT_FALSE(IsBag(video_));
  EXPECT_FALSE(IsBag("http://robot/run.mcap"));
}

}  // namespace
}  // namespace ceilmap::recordings
