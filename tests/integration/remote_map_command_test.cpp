// Commands on a map that stands on a web server.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "tests/integration/command_results.hpp"
#include "tests/integration/recordings.hpp"
#include "tests/support/file_server.hpp"

namespace ceilmap::integration {
namespace {

using support::FileServer;
using support::ReadAll;
using testing::HasSubstr;
using testing::StartsWith;

class RemoteMapCommand : public testing::Test {
 protected:
  void SetUp() override {
    setenv("CEILMAP_CACHE_MB", "0", 1);
    setenv("GDAL_HTTP_MAX_RETRY", "2", 1);
    setenv("GDAL_HTTP_RETRY_DELAY", "0.01", 1);
    ASSERT_EQ(test_
                  .Run({"map",
                        "--quiet",
                        "--rig=@rig.yaml",
                        "--up=@run.avi",
                        "--stamps=@stamps.csv",
                        "-o",
                        "@m.gpkg"})
                  .exit_code,
              0);
    server_ = std::make_unique<FileServer>(FileServer::ContentOf(test_.in / "m.gpkg"));
  }
  void TearDown() override {
    for (const char* name : {"CEILMAP_CACHE_MB", "GDAL_HTTP_MAX_RETRY", "GDAL_HTTP_RETRY_DELAY"}) {
      unsetenv(name);
    }
  }

  [[nodiscard]] support::ProcessResult Localize(const std::string& map) const {
    return test_.Run(LocalizeArguments(map, "@rig.yaml", "@run.avi", {"--quiet"}));
  }

  Recordings test_;
  std::unique_ptr<FileServer> server_;
};

TEST_F(RemoteMapCommand, IsAsOnTheFile) {
  ASSERT_EQ(Localize("@m.gpkg").exit_code, 0);
  const std::string here = ReadAll(test_.out / "t.tum");
  server_->truncated = 2;  // and the server recovers
  const support::ProcessResult there = Localize(server_->Url());
  EXPECT_EQ(there.exit_code, 0) << there.err;
  EXPECT_EQ(ReadAll(test_.out / "t.tum"), here);
  EXPECT_EQ(test_.Run({"info", server_->Url(), "--json"}).out,
            test_.Run({"info", "@m.gpkg", "--json"}).out);
  EXPECT_EQ(test_.Run({"export", server_->Url(), "--format=cog", "-o", "there.tif"}).exit_code, 0);
  EXPECT_EQ(test_.Run({"export", "@m.gpkg", "--format=cog", "-o", "here.tif"}).exit_code, 0);
  EXPECT_EQ(ReadAll(test_.out / "there.tif"), ReadAll(test_.out / "here.tif"));
}

/// At each moment of the run, a replaced map is named, and there are no poses.
TEST_F(RemoteMapCommand, EndsWhenTheMapIsReplaced) {
  server_->requests = 0;
  ASSERT_EQ(Localize(server_->Url()).exit_code, 0);
  const int requests = server_->requests;
  ASSERT_GT(requests, 6);
  std::filesystem::remove(test_.out / "t.tum");
  for (int after = 1; after < requests; after += std::max(1, requests / 6)) {
    server_->Replace(FileServer::ContentOf(test_.in / "m.gpkg"), "\"1\"");
    server_->replaced_after = after;
    const support::ProcessResult result = Localize(server_->Url());
    EXPECT_EQ(result.exit_code, 1) << after << " of " << requests;
    EXPECT_EQ(result.err,
              "ceilmap: " + server_->Url() +
                  ": was replaced on the server while it was read; run again\n");
    EXPECT_FALSE(std::filesystem::exists(test_.out / "t.tum"));
  }
}

TEST_F(RemoteMapCommand, EndsWhenTheServerStaysAway) {
  server_->failing = 1000;
  const support::ProcessResult result = Localize(server_->Url());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err,
              StartsWith("ceilmap: " + server_->Url() +
                         ": cannot be read from the server, after 3 attempts (the server answers "
                         "with HTTP status 503); check"));
  EXPECT_EQ(Lines(result.err).size(), 1U);
}

TEST_F(RemoteMapCommand, IsNotChanged) {
  const support::ProcessResult result = test_.Run({"map",
                                                   "--rig=@rig.yaml",
                                                   "--up=@run.avi",
                                                   "--stamps=@stamps.csv",
                                                   "--append",
                                                   "-o",
                                                   server_->Url()});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr(": a server is only read from; write a file here"));
}

}  // namespace
}  // namespace ceilmap::integration
