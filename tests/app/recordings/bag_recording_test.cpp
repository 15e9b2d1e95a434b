#include "app/recordings/bag_recording.hpp"

#include <gmock/gmock.h>

#include <random>
#include <thread>

#include "tests/app/recordings/memory_bag.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

/// Message i is of topic `topics[i]`, recorded at i seconds, with `bytes` bytes of value i.
std::shared_ptr<MemoryBagContent> Content(const std::vector<std::size_t>& topics,
                                          std::size_t bytes = 10) {
  auto content = std::make_shared<MemoryBagContent>();
  const auto topic = [](const char* name) {
    return bags::Topic{name, "T", bags::MessageEncoding::kCdr, {}};
  };
  content->topics = {topic("/a"), topic("/b"), topic("/c")};
  for (std::size_t i = 0; i < topics.size(); ++i) {
    content->messages.push_back({topics[i],
                                 static_cast<std::int64_t>(i) * 1'000'000'000,
                                 std::vector<std::uint8_t>(bytes, static_cast<std::uint8_t>(i))});
  }
  return content;
}

/// The value of the next message; -1 at the end.
int Next(BagStream& stream) {
  BagMessage message;
  return stream.Next(message) ? message.data.at(0) : -1;
}

std::vector<int> Rest(BagStream& stream) {
  std::vector<int> values;
  for (int value = Next(stream); value >= 0; value = Next(stream)) values.push_back(value);
  return values;
}

TEST(BagRecording, ReadsSeveralTopicsInOnePass) {
  const auto content = Content({0, 1, 2, 1, 0, 1, 2, 0});
  const auto bag = OpenMemoryBag(content);
  const auto a = bag->Subscribe(0);
  const auto b = bag->Subscribe(1);
  EXPECT_EQ(a->Topic().name, "/a");
  EXPECT_EQ(Next(*a), 0);
  EXPECT_EQ(Next(*a), 4);
  EXPECT_EQ(bag->WaitingBytes(), 20) << "two of b wait, c is not asked for";
  EXPECT_EQ(Next(*b), 1);
  EXPECT_EQ(Rest(*b), (std::vector<int>{3, 5}));
  EXPECT_TRUE(b->Ended());
  EXPECT_FALSE(a->Ended());
  EXPECT_EQ(Rest(*a), (std::vector<int>{7}));
  EXPECT_EQ(content->opened, 1);
  EXPECT_EQ(content->read, 6) << "each message once, and none of c";
  EXPECT_EQ(bag->WaitingBytes(), 0);
  EXPECT_EQ(bag->MostWaitingBytes(), 30);
}

TEST(BagRecording, KeepsWhatIsReservedForWhoComesLate) {
  const auto content = Content({0, 1, 0, 1});
  const auto bag = OpenMemoryBag(content);
  bag->Reserve(1);
  const auto a = bag->Subscribe(0);
  EXPECT_EQ(Rest(*a), (std::vector<int>{0, 2}));
  const auto b = bag->Subscribe(1);
  EXPECT_FALSE(b->IsAlone());
  EXPECT_EQ(Rest(*b), (std::vector<int>{1, 3}));
  EXPECT_EQ(content->opened, 1);
}

TEST(BagRecording, WhoComesLateUnannouncedReadsAlone) {
  const auto content = Content({0, 1, 0, 1});
  const auto bag = OpenMemoryBag(content);
  const auto a = bag->Subscribe(0);
  EXPECT_EQ(Next(*a), 0);
  const auto b = bag->Subscribe(1);
  EXPECT_TRUE(b->IsAlone());
  EXPECT_EQ(Rest(*b), (std::vector<int>{1, 3}));
  EXPECT_EQ(content->opened, 2);
}

TEST(BagRecording, NothingWaitsForWhoDoesNotCome) {
  const auto bag = OpenMemoryBag(Content({0, 1, 0, 1, 0}));
  bag->Reserve(1);
  auto gone = bag->Subscribe(1);  // takes the reservation
  bag->Reserve(2);
  bag->Reserve(1);
  bag->ReleaseReserved();
  const auto a = bag->Subscribe(0);
  EXPECT_EQ(Next(*a), 0);
  EXPECT_EQ(Next(*a), 2);
  EXPECT_EQ(bag->WaitingBytes(), 10);
  gone.reset();
  EXPECT_EQ(bag->WaitingBytes(), 0);
  EXPECT_EQ(Rest(*a), (std::vector<int>{4}));
  EXPECT_EQ(bag->WaitingBytes(), 0);
}

TEST(BagRecording, TwoConsumersOfATopicGetAllOfIt) {
  const auto bag = OpenMemoryBag(Content({0, 0, 0}));
  const auto one = bag->Subscribe(0);
  const auto two = bag->Subscribe(0);
  EXPECT_EQ(Rest(*one), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(Rest(*two), (std::vector<int>{0, 1, 2}));
}

TEST(BagRecording, GivesUpTheLongestQueueAndLosesNothing) {
  const auto content = Content({1, 2, 1, 0, 1, 1, 1, 0, 1, 2}, 100);
  const auto bag = OpenMemoryBag(content, 450);
  const auto a = bag->Subscribe(0);
  const auto b = bag->Subscribe(1);
  const auto c = bag->Subscribe(2);
  EXPECT_EQ(Next(*b), 0);
  EXPECT_EQ(Next(*a), 3);
  EXPECT_FALSE(b->IsAlone());
  EXPECT_EQ(Next(*a), 7);  // 2, 4, 5, 6 of b and 1 of c before it
  EXPECT_TRUE(b->IsAlone());
  EXPECT_FALSE(c->IsAlone());
  EXPECT_EQ(bag->WaitingBytes(), 100);
  EXPECT_EQ(Rest(*b), (std::vector<int>{2, 4, 5, 6, 8})) << "on from where it was";
  EXPECT_EQ(Rest(*c), (std::vector<int>{1, 9}));
  EXPECT_EQ(Next(*a), -1);
  EXPECT_EQ(content->opened, 2);
}

TEST(BagRecording, AMessageLargerThanTheBoundIsRead) {
  const auto bag = OpenMemoryBag(Content({0, 1, 0, 1}, 1000), 100);
  const auto a = bag->Subscribe(0);
  const auto b = bag->Subscribe(1);
  EXPECT_EQ(Rest(*a), (std::vector<int>{0, 2}));
  EXPECT_EQ(Rest(*b), (std::vector<int>{1, 3}));
}

TEST(BagRecording, DoesNotReadOnBeyondTheTimeOfInterest) {
  const auto content = Content({0, 1, 1, 1, 0, 1});
  const auto bag = OpenMemoryBag(content);
  const auto a = bag->Subscribe(0);
  const auto b = bag->Subscribe(1);
  EXPECT_EQ(Next(*a), 0);
  BagMessage message;
  EXPECT_FALSE(a->Next(message, 1'500'000'000));
  EXPECT_FALSE(a->Ended());
  EXPECT_EQ(content->read, 3) << "the message at 2 s shows that there is none";
  EXPECT_FALSE(a->Next(message, 1'500'000'000));
  EXPECT_EQ(content->read, 3);
  EXPECT_EQ(Next(*a), 4);
  EXPECT_FALSE(a->Next(message, 6'000'000'000));
  EXPECT_TRUE(a->Ended());
}

TEST(BagRecording, AStreamThatIsStoppedReadsNoFurther) {
  const auto content = Content({0, 1, 1, 0});
  const auto bag = OpenMemoryBag(content);
  const auto a = bag->Subscribe(0);
  EXPECT_EQ(Next(*a), 0);
  a->Stop();
  EXPECT_EQ(Next(*a), -1);
  EXPECT_EQ(content->read, 1);
  const auto late = bag->Subscribe(1);
  late->Stop();
  EXPECT_EQ(Next(*late), -1);
}

TEST(BagRecording, AllConsumersSeeThatTheFileCannotBeRead) {
  const auto content = Content({0, 1, 0, 1});
  content->fails_at = 2;
  const auto bag = OpenMemoryBag(content);
  const auto a = bag->Subscribe(0);
  const auto b = bag->Subscribe(1);
  EXPECT_EQ(Next(*a), 0);
  EXPECT_THROW(Next(*a), InputError);
  EXPECT_THROW(Next(*a), InputError);
  EXPECT_EQ(Next(*b), 1) << "was read before";
  EXPECT_THROW(Next(*b), InputError);
}

TEST(BagRecording, GivesEachWarningOnce) {
  const auto bag = OpenMemoryBag(Content({0}));
  EXPECT_EQ(bag->TakeWarnings(), (std::vector<std::string>{"run.mcap: first"}));
  EXPECT_TRUE(bag->TakeWarnings().empty());
  Rest(*bag->Subscribe(0));
  EXPECT_EQ(bag->TakeWarnings(), (std::vector<std::string>{"second"}));
}

/// Whatever the consumers do, each gets all of its topic in order, and no more waits than the bound
/// and the message that was just read.
TEST(BagRecording, MemoryIsBoundedForAnyConsumers) {
  std::mt19937 random(31);
  const auto below = [&random](std::size_t end) { return random() % end; };
  for (int run = 0; run < 200; ++run) {
    std::vector<std::size_t> topics(40 + below(60));
    for (std::size_t& topic : topics) topic = below(3);
    const auto content = Content(topics);
    std::size_t largest = 0;
    for (auto& message : content->messages) {
      message.data.resize(1 + below(500), message.data.front());
      largest = std::max(largest, message.data.size());
    }
    const std::size_t bound = below(3000);
    const auto bag = OpenMemoryBag(content, bound);
    std::vector<std::unique_ptr<BagStream>> streams;
    for (std::size_t topic = 0; topic < 3; ++topic) streams.push_back(bag->Subscribe(topic));
    std::vector<std::vector<int>> received(3);
    std::vector<std::size_t> open{0, 1, 2};
    while (!open.empty()) {
      const std::size_t at = below(open.size());
      const int value = Next(*streams[open[at]]);
      EXPECT_LE(bag->WaitingBytes(), bound);
      if (value >= 0) {
        received[open[at]].push_back(value);
      } else {
        open.erase(open.begin() + static_cast<std::ptrdiff_t>(at));
      }
    }
    EXPECT_LE(bag->MostWaitingBytes(), bound + largest);
    for (std::size_t topic = 0; topic < 3; ++topic) {
      std::vector<int> expected;
      for (std::size_t i = 0; i < topics.size(); ++i) {
        if (topics[i] == topic) expected.push_back(static_cast<int>(i));
      }
      EXPECT_EQ(received[topic], expected) << run;
    }
  }
}

TEST(BagRecording, ConsumersInThreadsOfTheirOwnGetAllOfTheirs) {
  std::vector<std::size_t> topics(250);
  for (std::size_t i = 0; i < topics.size(); ++i) topics[i] = i * i % 3 == 0 ? 0 : i % 2 + 1;
  const auto bag = OpenMemoryBag(Content(topics, 1000), 20000);
  std::vector<std::vector<int>> received(3);
  std::vector<std::thread> threads;
  for (std::size_t topic = 0; topic < 3; ++topic) {
    threads.emplace_back(
        [&received, topic, stream = bag->Subscribe(topic)] { received[topic] = Rest(*stream); });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t topic = 0; topic < 3; ++topic) {
    EXPECT_EQ(received[topic].size(), std::count(topics.begin(), topics.end(), topic));
    EXPECT_TRUE(std::is_sorted(received[topic].begin(), received[topic].end()));
  }
}

}  // namespace
}  // namespace ceilmap::recordings
