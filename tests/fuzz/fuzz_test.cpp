// What libFuzzer runs for hours, in short: every reader on its corpus, and on mutations of it that
// are the same each time.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/mutator.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {
namespace {

namespace fs = std::filesystem;

class Reader : public testing::TestWithParam<Target> {
 protected:
  void SetUp() override {
    const fs::path folder =
        fs::path(CEILMAP_SOURCE_DIR) / "tests/fuzz/corpus" / std::string(GetParam().name);
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
      std::ifstream stream(file, std::ios::binary);
      corpus_.emplace_back(std::istreambuf_iterator<char>(stream),
                           std::istreambuf_iterator<char>());
    }
    ASSERT_FALSE(corpus_.empty());
  }

  std::vector<std::string> corpus_;
};

TEST_P(Reader, KeepsItsPromisesOnTheCorpus) {
  for (const std::string& bytes : corpus_) EXPECT_NO_THROW(GetParam().read(bytes)) << bytes;
  EXPECT_NO_THROW(GetParam().read({}));
}

TEST_P(Reader, KeepsItsPromisesOnMutations) {
  std::mt19937 random(1);  // NOLINT(cert-msc51-cpp): the same each time
  for (int i = 0; i < GetParam().mutations; ++i) {
    const std::string& seed = corpus_[random() % corpus_.size()];
    const std::string bytes = Mutate(seed, corpus_, random);
    ASSERT_NO_THROW(GetParam().read(bytes)) << bytes;
  }
}

INSTANTIATE_TEST_SUITE_P(Fuzz,
                         Reader,
                         testing::ValuesIn(Targets().begin(), Targets().end()),
                         [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace ceilmap::fuzz
