#include "ceilmap_ros/logic/task_runner.hpp"

#include <gtest/gtest.h>

#include <future>
#include <vector>

namespace ceilmap_ros {
namespace {

TEST(TaskRunnerTest, RunsTasksInOrderBesideTheCaller) {
  std::vector<int> order;
  std::promise<void> go;
  std::promise<void> done;
  TaskRunner runner;
  runner.Add([&] {
    go.get_future().wait();
    order.push_back(1);
  });
  runner.Add([&] {
    order.push_back(2);
    done.set_value();
  });
  go.set_value();
  done.get_future().wait();
  EXPECT_EQ(order, (std::vector{1, 2}));
}

TEST(TaskRunnerTest, ItsEndWaitsForTheTaskThatRuns) {
  std::promise<void> begun;
  std::promise<void> go;
  bool ended = false;
  std::future<void> released;
  {
    TaskRunner runner;
    runner.Add([&] {
      begun.set_value();
      go.get_future().wait();
      ended = true;
    });
    begun.get_future().wait();
    released = std::async(std::launch::async, [&] { go.set_value(); });
  }
  EXPECT_TRUE(ended);
}

}  // namespace
}  // namespace ceilmap_ros
