#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>
#include <sqlite3.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "calib/base/error.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/store/map_metadata.hpp"
#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::store {
namespace {

namespace fs = std::filesystem;
using synthetic::SmallMap;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

std::string Bytes(const fs::path& file) {
  std::ostringstream bytes;
  bytes << std::ifstream(file, std::ios::binary).rdbuf();
  return bytes.str();
}

void Store(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

auto Opening(const fs::path& file) {
  return [file] { const MapReader reader(file); };
}

/// Changes a good map by SQL.
fs::path Altered(const support::TempFolder& folder, const std::vector<std::string>& statements) {
  fs::path file = folder / "altered.gpkg";
  SmallMap().Write(file);
  GDALAllRegister();
  const GDALDatasetUniquePtr dataset(
      GDALDataset::Open(file.c_str(), GDAL_OF_VECTOR | GDAL_OF_UPDATE | GDAL_OF_VERBOSE_ERROR));
  for (const std::string& sql : statements) {
    dataset->ReleaseResultSet(dataset->ExecuteSQL(sql.c_str(), nullptr, nullptr));
  }
  return file;
}

TEST(MapDamage, FilesThatAreNoMap) {
  const support::TempFolder folder;
  EXPECT_THAT(Opening(folder / "none.gpkg"),
              ThrowsMessage<InputError>(AllOf(HasSubstr("none.gpkg"), HasSubstr("no such"))));
  fs::create_directory(folder / "dir.gpkg");
  EXPECT_THAT(Opening(folder / "dir.gpkg"), ThrowsMessage<InputError>(HasSubstr("no file")));
  Store(folder / "empty.gpkg", "");
  Store(folder / "text.gpkg", std::string(5000, 'x'));
  for (const char* name : {"empty.gpkg", "text.gpkg"}) {
    EXPECT_THAT(Opening(folder / name),
                ThrowsMessage<InputError>(AllOf(
                    HasSubstr(name), HasSubstr("is no GeoPackage"), HasSubstr("ceilmap map"))));
  }
}

TEST(MapDamage, AnotherGeoPackage) {
  const support::TempFolder folder;
  GDALAllRegister();
  {
    const GDALDatasetUniquePtr other(GetGDALDriverManager()->GetDriverByName("GPKG")->Create(
        (folder / "other.gpkg").c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    ASSERT_NE(other->CreateLayer("roads", nullptr, wkbPoint, nullptr), nullptr);
  }
  EXPECT_THAT(Opening(folder / "other.gpkg"),
              ThrowsMessage<InputError>(HasSubstr("no ceilmap map")));
}

TEST(MapDamage, AnotherFormatVersion) {
  const support::TempFolder folder;
  EXPECT_THAT(
      Opening(Altered(folder,
                      {"UPDATE ceilmap_metadata SET value = '9' WHERE key = 'format_version'"})),
      ThrowsMessage<InputError>(
          AllOf(HasSubstr("format version 9"), HasSubstr("make the map again"))));
}

TEST(MapDamage, ImpossibleMetadata) {
  for (const auto& [key, value] :
       std::vector<std::pair<std::string, std::string>>{{"format_version", "one"},
                                                        {"unit", "ft"},
                                                        {"resolution", "-1"},
                                                        {"resolution", "nan"},
                                                        {"resolution", "0.005x"},
                                                        {"view_width_px", "2000000000"},
                                                        {"view_height_px", "0"},
                                                        {"view_units_per_px", "inf"},
                                                        {"T_base_view_x", "1e300"},
                                                        {"view_focal_px", "-1"},
                                                        {"view_focal_px", "inf"},
                                                        {"view_principal_x_px", "nan"},
                                                        {"view_principal_y_px", "1e10"}}) {
    const support::TempFolder folder;
    std::string sql = "UPDATE ceilmap_metadata SET value = '";
    sql.append(value).append("' WHERE key = '").append(key).append("'");
    EXPECT_THAT(
        Opening(Altered(folder, {sql})),
        ThrowsMessage<InputError>(AllOf(HasSubstr("altered.gpkg"), HasSubstr("ceilmap_metadata"))))
        << key << " = " << value;
  }
  const support::TempFolder folder;
  EXPECT_THAT(Opening(Altered(folder, {"DELETE FROM ceilmap_metadata WHERE key = 'unit'"})),
              ThrowsMessage<InputError>(HasSubstr("no 'unit'")));
}

TEST(MapDamage, MapsMadeBeforeCeilingsHadHeightsAreRead) {
  const support::TempFolder folder;
  const MapReader map(
      Altered(folder,
              {"DELETE FROM ceilmap_metadata WHERE key IN ('view_focal_px', 'view_principal_x_px', "
               "'view_principal_y_px')"}));
  EXPECT_EQ(map.Metadata().view_focal_px, 0);
  EXPECT_EQ(map.Metadata().view_principal_px, Eigen::Vector2d(0, 0));
}

TEST(MapDamage, MissingTable) {
  const support::TempFolder folder;
  EXPECT_THAT(Opening(Altered(folder, {"DROP TABLE edges"})),
              ThrowsMessage<InputError>(HasSubstr("no table edges")));
}

/// The message of opening a good map changed by SQLite alone: GDAL would read what it makes.
std::string MessageAfter(const std::string& sql) {
  const support::TempFolder folder;
  const fs::path file = folder / "altered.gpkg";
  SmallMap().Write(file);
  sqlite3* database = nullptr;
  EXPECT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sql;
  EXPECT_EQ(sqlite3_close(database), SQLITE_OK);
  try {
    const MapReader reader(file);
    return "";
  } catch (const InputError& error) {
    return std::string(error.what()).substr(file.string().size());
  }
}

// Reading them would never end, or execute foreign code.
TEST(MapDamage, WhatIsWorkedOutWhenItIsReadIsRefused) {
  constexpr auto kEnd = "', which no map has; do not use it if it comes from elsewhere";
  constexpr auto kEndless =
      " AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT x FROM n";
  EXPECT_EQ(MessageAfter(""), "");
  EXPECT_EQ(MessageAfter(std::string("DROP TABLE weak_spots; CREATE VIEW weak_spots") + kEndless),
            std::string(": has a view, 'weak_spots") + kEnd);
  EXPECT_EQ(
      MessageAfter(std::string("DROP TABLE gpkg_contents; CREATE VIEW gpkg_contents") + kEndless),
      std::string(": has a view, 'gpkg_contents") + kEnd);
  EXPECT_EQ(MessageAfter("CREATE VIEW \"\x1b[2J\n" + std::string(500, 'x') + "\" AS SELECT 1"),
            ": has a view, '?[2J " + std::string(395, 'x') + "..." + kEnd);
  EXPECT_EQ(MessageAfter("CREATE VIRTUAL TABLE words USING fts5(word)"),
            std::string(": has a virtual table, 'words") + kEnd);
  EXPECT_EQ(MessageAfter("CREATE TABLE large (a, b AS (zeroblob(1000000000)))"),
            std::string(": has a table with columns that are worked out, 'large") + kEnd);
}

TEST(MapDamage, ImpossibleRows) {
  const auto reading = [](const std::string& sql) {
    return [sql] {
      const support::TempFolder folder;
      const MapReader reader(Altered(folder, {sql}));
      (void)reader.ReadKeyframes();
      (void)reader.ReadTrajectory();
      (void)reader.ReadEdges();
    };
  };
  for (const std::string sql : {"UPDATE keyframes SET yaw_rad = 9e999 WHERE id = 2",
                                "UPDATE keyframes SET yaw_rad = NULL WHERE id = 2",
                                "UPDATE keyframes SET geom = NULL WHERE id = 2",
                                "UPDATE trajectory SET status = 'sure' WHERE fid = 3",
                                "UPDATE trajectory SET cxx = -9e999 WHERE fid = 3",
                                "UPDATE trajectory SET cyy = -1e-9 WHERE fid = 3",
                                "UPDATE edges SET kind = 'guess' WHERE fid = 1",
                                "UPDATE edges SET x = 1e200 WHERE fid = 1",
                                "UPDATE edges SET ixx = NULL WHERE fid = 1"}) {
    EXPECT_THAT(reading(sql),
                ThrowsMessage<InputError>(AllOf(HasSubstr("altered.gpkg"), HasSubstr("row"))))
        << sql;
  }
}

/// The message of reading the keyframes of a good map changed by `sql`, without the file's name.
std::string MessageOfKeyframes(const std::string& sql) {
  const support::TempFolder folder;
  const fs::path file = Altered(folder, {sql});
  try {
    (void)MapReader(file).ReadKeyframes();
    return "";
  } catch (const InputError& error) {
    return std::string(error.what()).substr(file.string().size());
  }
}

TEST(MapDamage, ImpossibleHeights) {
  const auto damaged = [](const std::string& what) {
    return ": table keyframe_heights, row 4: " + what + "; the file is damaged";
  };
  const auto set = [](const std::string& what) {
    return "UPDATE keyframe_heights SET " + what + " WHERE id = 4";
  };
  EXPECT_EQ(MessageOfKeyframes(set("columns = 4")), "");
  for (const char* size : {"columns = 3",
                           "columns = 0",
                           "columns = -4",
                           "columns = 2147483647, rows = 2147483647",
                           "rows = 4",
                           "float32 = NULL",
                           "float32 = x'00'",
                           "float32 = substr(float32, 1, 95)"}) {
    EXPECT_EQ(MessageOfKeyframes(set(size)), damaged("heights of an impossible size")) << size;
  }
  EXPECT_EQ(MessageOfKeyframes(set("columns = NULL")), damaged("no value in column 'columns'"));
  EXPECT_EQ(MessageOfKeyframes(set("first_v = -9e999")), damaged("column 'first_v' is not finite"));
  for (const char* grid :
       {"first_u = 1e9", "step_u = 0", "step_v = -16", "step_v = 1e9", "scale_sigma = -0.1"}) {
    EXPECT_EQ(MessageOfKeyframes(set(grid)), damaged("heights on an impossible grid")) << grid;
  }
  // The first cell's rho or sigma as NaN, infinity, -1 and 2^24.
  for (const char* number : {"0000C07F", "0000807F", "000080BF", "0000804B"}) {
    const std::string bytes = std::string("x'") + number + "'";
    EXPECT_EQ(
        MessageOfKeyframes(set("float32 = CAST(" + bytes + " || substr(float32, 5) AS BLOB)")),
        damaged("heights out of range"))
        << number;
    EXPECT_EQ(MessageOfKeyframes(set("float32 = CAST(substr(float32, 1, 4) || " + bytes +
                                     " || substr(float32, 9) AS BLOB)")),
              damaged("heights out of range"))
        << number;
  }
  EXPECT_EQ(MessageOfKeyframes("UPDATE keyframe_heights SET id = 9 WHERE id = 4"),
            ": table keyframe_heights: keyframe 9 is missing; the file is damaged");
}

TEST(MapDamage, MapsWithoutHeightsAreRead) {
  const support::TempFolder folder;
  const MapReader reader(Altered(folder,
                                 {"DROP TABLE keyframe_heights",
                                  "DELETE FROM ceilmap_metadata WHERE key LIKE 'view_focal%'",
                                  "DELETE FROM ceilmap_metadata WHERE key LIKE 'view_princ%'"}));
  EXPECT_EQ(reader.Metadata().view_focal_px, 0);
  EXPECT_EQ(HeightAboveFloor(reader.Metadata(), 1), std::nullopt);
  for (const graph::Keyframe& keyframe : reader.ReadKeyframes()) {
    EXPECT_EQ(keyframe.heights, nullptr);
  }
}

TEST(MapDamage, ImagesOfAnotherSizeAreNotDecoded) {
  const support::TempFolder folder;
  // The header of a PNG of 60000 x 60000 pixels.
  const fs::path file =
      Altered(folder,
              {"UPDATE keyframe_pictures SET png = x'89504E470D0A1A0A0000000D494844"
               "520000EA600000EA600800000000' WHERE id = 1",
               "UPDATE keyframe_pictures SET png = x'00' WHERE id = 2",
               "UPDATE keyframe_pictures SET png = NULL WHERE id = 3"});
  const MapReader reader(file);
  for (const int id : {1, 2, 3, 99}) {
    EXPECT_THROW((void)reader.ReadImage(id), InputError) << id;
  }
  EXPECT_EQ(reader.ReadImage(0).size(), cv::Size(64, 48));
}

TEST(MapDamage, HostileMosaicSize) {
  const support::TempFolder folder;
  EXPECT_THROW(Opening(Altered(
                   folder, {"UPDATE gpkg_contents SET max_x = 1e12 WHERE table_name='mosaic'"}))(),
               InputError);
  EXPECT_THROW(Opening(Altered(folder, {"UPDATE gpkg_tile_matrix SET tile_width = 2000000000"}))(),
               InputError);
  EXPECT_THROW(Opening(Altered(folder, {"DELETE FROM gpkg_tile_matrix"}))(), InputError);
  MosaicGrid grid{0, 0, 0.01, 1 << 18, 1 << 18};
  EXPECT_EQ(Problem(grid), "");
  ++grid.width_px;
  EXPECT_EQ(Problem(grid),
            "a mosaic of 262145 x 262144 pixels cannot be stored (at most 68719476736 in all)");
}

TEST(MapDamage, TruncatedFilesAreNoticedAtOnce) {
  const support::TempFolder folder;
  SmallMap().Write(folder / "good.gpkg");
  const std::string good = Bytes(folder / "good.gpkg");
  for (const std::size_t size : {std::size_t{1},
                                 std::size_t{99},
                                 std::size_t{100},
                                 std::size_t{4096},
                                 good.size() / 2,
                                 good.size() - 1}) {
    Store(folder / "short.gpkg", good.substr(0, size));
    EXPECT_THAT(Opening(folder / "short.gpkg"),
                ThrowsMessage<InputError>(AllOf(HasSubstr("short.gpkg"), Not(HasSubstr("\n")))))
        << size;
  }
}

/// Reads all that the map holds.
void ReadAll(const fs::path& file) {
  const MapReader reader(file);
  for (const graph::Keyframe& keyframe : reader.ReadKeyframes())
    (void)reader.ReadImage(keyframe.id);
  (void)reader.ReadTrajectory();
  (void)reader.ReadEdges();
  cv::Mat grey;
  cv::Mat alpha;
  reader.ReadMosaic({0, 0, reader.Grid().width_px, reader.Grid().height_px}, grey, alpha);
}

TEST(MapDamage, AFlippedByteInAImageOrTileIsNoticed) {
  const support::TempFolder folder;
  SmallMap().Write(folder / "good.gpkg");
  const std::string good = Bytes(folder / "good.gpkg");
  const std::string signature("\x89PNG\r\n\x1a\n", 8);
  int noticed = 0;
  for (std::size_t at = good.find(signature); at != std::string::npos;
       at = good.find(signature, at + 1)) {
    std::string bad = good;
    bad[at + 300] = static_cast<char>(bad[at + 300] ^ 0x10);  // within the compressed pixels
    Store(folder / "bad.gpkg", bad);
    try {
      ReadAll(folder / "bad.gpkg");
    } catch (const InputError&) {
      ++noticed;
    }
  }
  EXPECT_EQ(noticed, 6 + 6);  // images and tiles; the pyramid above them is not read
}

TEST(MapDamage, FlippedBytesGiveAnErrorOrOtherValuesButNoCrash) {
  const support::TempFolder folder;
  SmallMap().Write(folder / "good.gpkg");
  const std::string good = Bytes(folder / "good.gpkg");
  cv::RNG rng(5);
  int errors = 0;
  ::testing::internal::CaptureStderr();
  for (int round = 0; round < 60; ++round) {
    std::string bad = good;
    // A block of 64 bytes anywhere, most often in the first pages, which hold the schema.
    const int limit = static_cast<int>(round % 2 == 0 ? bad.size() : 40'000) - 64;
    const auto start = static_cast<std::size_t>(rng.uniform(0, limit));
    for (std::size_t i = start; i < start + 64; ++i)
      bad[i] = static_cast<char>(rng.uniform(0, 256));
    Store(folder / "bad.gpkg", bad);
    try {
      ReadAll(folder / "bad.gpkg");
    } catch (const InputError& error) {
      ++errors;
      EXPECT_THAT(error.what(), AllOf(HasSubstr("bad.gpkg"), Not(HasSubstr("\n"))));
    }
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_GT(errors, 0);
}

}  // namespace
}  // namespace ceilmap::store
