#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "calib/base/error.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::bags {

/// A message as text: "/topic time data".
inline std::vector<std::string> ReadAll(BagReader& bag) {
  std::vector<std::string> messages;
  RawMessage message;
  while (bag.Next(message)) {
    messages.push_back(bag.Topics().at(message.topic).name + " " +
                       std::to_string(message.log_time_ns) + " " +
                       std::string(message.data.begin(), message.data.end()));
  }
  return messages;
}

inline std::string ErrorOf(const std::filesystem::path& path) {
  try {
    (void)BagReader::Open(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace ceilmap::bags
