#include "calib/base/remote_name.hpp"

#include <gtest/gtest.h>

namespace ceilmap {
namespace {

TEST(RemoteName, IsAUrlOrANameOfGdal) {
  for (const char* name : {"http://host/a", "HTTPS://host/a", "/vsicurl/http://a", "/vsis3/b/k"}) {
    EXPECT_TRUE(IsRemoteName(name)) << name;
  }
  for (const char* name : {"", "a.gpkg", "https/a.gpkg", "rtsp://host/a", "/vsizip/a", "/data/a"}) {
    EXPECT_FALSE(IsRemoteName(name)) << name;
  }
}

TEST(WithoutSecrets, LeavesOutPasswords) {
  EXPECT_EQ(WithoutSecrets("maps/password"), "maps/password");
  EXPECT_EQ(WithoutSecrets("https://host/a@b.gpkg"), "https://host/a@b.gpkg");
  EXPECT_EQ(WithoutSecrets("https://ann@host/a"), "https://ann@host/a");
  EXPECT_EQ(WithoutSecrets("rtsp://ann:p@ss@host:554/a?b=1"), "rtsp://ann:***@host:554/a?b=1");
  EXPECT_EQ(WithoutSecrets("https://host/a?X-Sig=1&b"), "https://host/a?***");
  EXPECT_EQ(WithoutSecrets("/vsicurl/https://u:p@host/a?s"), "/vsicurl/https://u:***@host/a?***");
  EXPECT_EQ(WithoutSecrets("PG:host=db password=secret dbname=a"),
            "PG:host=db password=*** dbname=a");
  EXPECT_EQ(WithoutSecrets("PG:password = 'se cr\\'et' dbname=a"), "PG:password = *** dbname=a");
  EXPECT_EQ(WithoutSecrets("PG:PASSWORD=a\\ b"), "PG:PASSWORD=***");
  EXPECT_EQ(WithoutSecrets("PG:password='never closed"), "PG:password=***");
  EXPECT_EQ(WithoutSecrets("postgresql://ann:s@db/site?sslpassword=x&a=1"),
            "postgresql://ann:***@db/site?sslpassword=***&a=1");
}

}  // namespace
}  // namespace ceilmap
