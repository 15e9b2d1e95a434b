#include "app/site/manifest.hpp"

#include "tests/app/site/site_folder.hpp"

namespace ceilmap::site {
namespace {

using testing::ElementsAre;

TEST(ReadManifest, HasEveryKey) {
  const SiteFolder site;
  site.folder.Write("site.yaml",
                    "output: hall.gpkg\n"
                    "work: jobs\n"
                    "recordings:\n"
                    "  - name: night-2\n"
                    "    rig: rig.yaml\n"
                    "    up: a.mp4\n"
                    "    stamps: a.csv\n"
                    "    odometry: wheels.csv\n"
                    "    gyro: wheels.csv\n"
                    "    forward: b.mp4\n"
                    "    priority: -3\n"
                    "    options: [--resolution, \"0.02\"]\n"
                    "  - {rig: rig.yaml, up: c.mp4}\n"
                    "maps: [old.gpkg]\n"
                    "options: {map: [--tilt=none], match: [--x], solve: [--y], align: [--scale],\n"
                    "          mosaic_parts: 7}\n"
                    "control_points: points.csv\n"
                    "crs: EPSG:25832\n");
  const Manifest manifest = ReadManifest(site.folder / "site.yaml");
  EXPECT_EQ(manifest.folder, site.folder.Path());
  EXPECT_EQ(manifest.output, "hall.gpkg");
  EXPECT_EQ(manifest.work, "jobs");
  ASSERT_EQ(manifest.recordings.size(), 2U);
  const Recording& night = manifest.recordings[0];
  EXPECT_EQ(night.name, "night-2");
  EXPECT_EQ(night.rig, "rig.yaml");
  EXPECT_EQ(night.up, "a.mp4");
  EXPECT_EQ(night.stamps, "a.csv");
  EXPECT_EQ(night.odometry, "wheels.csv");
  EXPECT_EQ(night.gyro, "wheels.csv");
  EXPECT_EQ(night.forward, "b.mp4");
  EXPECT_EQ(night.priority, -3);
  EXPECT_THAT(night.options, ElementsAre("--resolution", "0.02"));
  EXPECT_EQ(manifest.recordings[1].name, "c");
  EXPECT_EQ(manifest.recordings[1].priority, 0);
  ASSERT_EQ(manifest.maps.size(), 1U);
  EXPECT_EQ(manifest.maps[0].name, "old");
  EXPECT_EQ(manifest.maps[0].file, "old.gpkg");
  EXPECT_THAT(manifest.options.map, ElementsAre("--tilt=none"));
  EXPECT_THAT(manifest.options.match, ElementsAre("--x"));
  EXPECT_THAT(manifest.options.solve, ElementsAre("--y"));
  EXPECT_THAT(manifest.options.align, ElementsAre("--scale"));
  EXPECT_EQ(manifest.options.mosaic_parts, 7);
  EXPECT_EQ(manifest.control_points, "points.csv");
  EXPECT_EQ(manifest.crs, "EPSG:25832");
}

TEST(ReadManifest, WorksBesideTheOutput) {
  const SiteFolder site;
  EXPECT_EQ(site.Parse(kTwoRecordings).work, "site.work");
}

TEST(ReadManifest, PatternsAndUrlsNeedNotExist) {
  const SiteFolder site;
  const Manifest manifest = site.Parse(
      "output: site.gpkg\n"
      "recordings:\n"
      "  - {rig: rig.yaml, up: 'frames/%04d.png'}\n"
      "  - {name: b, rig: rig.yaml, up: 'http://robot/b.mp4'}\n");
  EXPECT_EQ(manifest.recordings[0].name, "_04d");
}

// A name that begins with '-' would be an option.
TEST(ReadManifest, PathsAreNoOptions) {
  const SiteFolder site;
  site.folder.Write("-rig.yaml", "x");
  const Manifest manifest = site.Parse(
      "output: -site.gpkg\n"
      "recordings:\n"
      "  - {rig: -rig.yaml, up: a.mp4}\n"
      "  - {rig: rig.yaml, up: b.mp4}\n");
  EXPECT_EQ(manifest.recordings[0].rig, "./-rig.yaml");
  EXPECT_EQ(manifest.output, "./-site.gpkg");
  EXPECT_EQ(manifest.work, "./-site.work");
}

class BadManifest : public testing::Test {
 protected:
  /// The whole message behind `FOLDER/site.yaml:`.
  void ExpectRefused(const std::string& text, const std::string& message) const {
    try {
      (void)site_.Parse(text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()), (site_.folder / "site.yaml").string() + ":" + message);
    }
  }
  /// With a second line of the first recording.
  void ExpectRecordingRefused(const std::string& line, const std::string& message) const {
    ExpectRefused("output: site.gpkg\nrecordings:\n  - rig: rig.yaml\n    up: a.mp4\n    " + line +
                      "\n  - {rig: rig.yaml, up: b.mp4}\n",
                  message);
  }

  SiteFolder site_;
};

TEST_F(BadManifest, UnknownKeysAndWrongTypes) {
  ExpectRecordingRefused(
      "stmaps: a.csv",
      "5: recordings[0].stmaps = a.csv is an unknown key, must be one of name, rig, up, stamps, "
      "odometry, gyro, forward, priority, options; correct its spelling or remove it");
  ExpectRecordingRefused(
      "priority: high",
      "5: recordings[0].priority = high, must be a whole number in -1000000..1000000; correct the "
      "value");
  ExpectRecordingRefused("options: --tilt",
                         "5: recordings[0].options = --tilt, must be a list; write '- value' lines "
                         "below it, or [one, two]");
  ExpectRefused("output: site.gpkg\nrecordings: all\n",
                "2: recordings = all, must be a list; write '- value' lines below it, or [one, "
                "two]");
  ExpectRefused("output: site.gpkg\nrecordings: [a]\n",
                "2: recordings[0] = a, must be a map of keys; write 'key: value' lines below it");
}

TEST_F(BadManifest, WhatIsMissing) {
  ExpectRefused("recordings: []\n", "1: output is missing, must be given; add 'output: site.gpkg'");
  ExpectRefused("output: site.gpkg\n",
                "1: recordings is missing, must be given; add a list of them");
  ExpectRefused("output: site.gpkg\nrecordings:\n  - {rig: rig.yaml, up: a.mp4}\n",
                "2: recordings = [...], must be at least two recordings or maps together; for one "
                "recording, run 'ceilmap map'");
  ExpectRefused("output: site.gpkg\nrecordings:\n  - {up: a.mp4}\n",
                "3: recordings[0].rig is missing, must be given; add 'rig: RIG.yaml'");
  ExpectRecordingRefused("stamps: none.csv",
                         "5: recordings[0].stamps = none.csv, must be a file that exists; paths "
                         "count from the manifest's folder");
  ExpectRefused("output: none/site.gpkg\nmaps: [old.gpkg, old.gpkg]\n",
                "2: maps[1] = old.gpkg, must be named otherwise than 'old', which is taken; rename "
                "the file");
  ExpectRefused(
      "output: none/site.gpkg\nrecordings:\n  - {rig: rig.yaml, up: a.mp4}\n"
      "maps: [old.gpkg]\n",
      "1: output = none/site.gpkg, must be in a folder that exists; create it, or choose "
      "another");
}

TEST_F(BadManifest, NamesAreSafe) {
  for (const char* const name : {"../b", "a b", "\"\"", "-b", ".b", "a--b", "b-", "$(b)", "a;b"}) {
    ExpectRecordingRefused(
        std::string("name: ") + name,
        std::string("5: recordings[0].name = ") + name +
            ", must be letters, digits, '.', '_' and single '-' inside, at most 80 of them; it "
            "becomes the name of files");
  }
  ExpectRecordingRefused("name: b",
                         "6: recordings[1].up = b.mp4, must be named otherwise than 'b', which is "
                         "taken; add 'name: NAME' to one of the recordings");
}

TEST_F(BadManifest, LineBreaksAreRefused) {
  ExpectRecordingRefused("options: [\"--tilt=x\\n\\trm -rf /\"]",
                         "5: recordings[0].options[0] = \"--tilt=x??rm -rf /\", must be one line "
                         "without control characters; rename the file");
  ExpectRefused("output: \"a\\nb.gpkg\"\n",
                "1: output = \"a?b.gpkg\", must be one line without control characters; rename the "
                "file");
}

TEST_F(BadManifest, OptionsThatThePlanSets) {
  for (const char* const word : {"-o", "-oother.gpkg", "--output=x.gpkg", "--force", "--"}) {
    ExpectRecordingRefused(std::string("options: [") + word + "]",
                           std::string("5: recordings[0].options[0] = ") + word +
                               ", must be an option that leaves the results' names alone; remove "
                               "it: the plan names the results");
  }
  ExpectRecordingRefused("options: [--rig=other.yaml]",
                         "5: recordings[0].options[0] = --rig=other.yaml, must be without it: it "
                         "is the key 'rig' of a recording; remove it from the options");
  ExpectRefused(std::string(kTwoRecordings) + "options: {mosaic_parts: 0}",
                "5: options.mosaic_parts = 0, must be a whole number in 1..10000; correct the "
                "value");
  ExpectRefused(std::string(kTwoRecordings) + "options: {solve: [--no-mosaic]}",
                "5: options.solve[0] = --no-mosaic, must be without it: the plan sets it by "
                "'mosaic_parts'; remove it from the options");
  ExpectRefused(std::string(kTwoRecordings) + "options: {map: [--tilt, none, --trajectory, t.tum]}",
                "5: options.map[2] = --trajectory, must be in the options of one recording, "
                "because all would write the same file; move it there");
}

TEST_F(BadManifest, OutputsAmongTheInputs) {
  ExpectRefused(
      "output: old.gpkg\nrecordings:\n  - {rig: rig.yaml, up: a.mp4}\n"
      "maps: [./old.gpkg]\n",
      "1: output = old.gpkg, must be another file than those in 'maps'; name a new file");
  ExpectRefused(std::string(kTwoRecordings) + "work: .\n",
                "1: output = site.gpkg, must be outside of the folder 'work'; choose another "
                "folder for one of them");
  ExpectRefused("output: site.tif\n",
                "1: output = site.tif, must be a name that ends in .gpkg; write e.g. site.gpkg");
  ExpectRefused(std::string(kTwoRecordings) + "crs: EPSG:25832\n",
                "5: crs = EPSG:25832, must be beside 'control_points'; add 'control_points: "
                "points.csv'");
}

}  // namespace
}  // namespace ceilmap::site
