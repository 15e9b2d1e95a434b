#include "app/site/plan.hpp"

#include "tests/app/site/site_folder.hpp"

namespace ceilmap::site {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::string> JobNames(const Plan& plan) {
  std::vector<std::string> names;
  for (const Job& job : plan.jobs) names.push_back(job.name);
  return names;
}

std::vector<std::string> AllWords(const Plan& plan, std::size_t job) {
  return WordsOf(plan.jobs[job], std::vector<bool>(plan.jobs.size(), true));
}

constexpr const char* kSite =
    "output: out.gpkg\n"
    "work: w\n"
    "recordings:\n"
    "  - {name: a, rig: rig.yaml, up: a.mp4, stamps: a.csv, odometry: wheels.csv,\n"
    "     options: [--tilt, fused, --settings=a.csv]}\n"
    "  - {name: b, rig: rig.yaml, up: b.mp4, priority: 5}\n"
    "maps: [old.gpkg]\n"
    "options: {map: [--tilt, none, --gap], match: [--m], solve: [--resolution, '0.02']}\n"
    "control_points: points.csv\n"
    "crs: EPSG:25832\n";

TEST(MakePlan, HasAMapOfEachRecordingAMatchOfEachPairAndTheSite) {
  const SiteFolder site;
  const Plan plan = site.PlanOf(kSite);
  EXPECT_THAT(
      JobNames(plan),
      ElementsAre(
          "map-b", "map-a", "match-b--old", "match-b--a", "match-old--a", "solve", "align"));
  EXPECT_EQ(plan.maps, 2U);
  EXPECT_EQ(plan.matches, 3U);
  EXPECT_EQ(plan.jobs[1].log, "w/logs/map-a.log");
}

TEST(MakePlan, WordsAreThoseOfTheCommands) {
  const SiteFolder site;
  const Plan plan = site.PlanOf(kSite);
  // The recording's own --tilt replaces the one of all maps, with its value.
  EXPECT_THAT(AllWords(plan, 1),
              ElementsAre("map",
                          "--rig=rig.yaml",
                          "--up=a.mp4",
                          "--stamps=a.csv",
                          "--odometry=wheels.csv",
                          "-o",
                          "w/maps/a.gpkg",
                          "--force",
                          "--gap",
                          "--tilt",
                          "fused",
                          "--settings=a.csv"));
  EXPECT_THAT(
      AllWords(plan, 2),
      ElementsAre(
          "match", "w/maps/b.gpkg", "old.gpkg", "-o", "w/matches/b--old.edges", "--force", "--m"));
  EXPECT_THAT(AllWords(plan, 5),
              ElementsAre("solve",
                          "w/maps/b.gpkg",
                          "old.gpkg",
                          "w/maps/a.gpkg",
                          "--edges=w/matches/b--old.edges",
                          "--edges=w/matches/b--a.edges",
                          "--edges=w/matches/old--a.edges",
                          "-o",
                          "w/solved.gpkg",
                          "--force",
                          "--resolution",
                          "0.02"));
  EXPECT_THAT(AllWords(plan, 6),
              ElementsAre("align",
                          "w/solved.gpkg",
                          "--points=points.csv",
                          "--crs=EPSG:25832",
                          "-o",
                          "out.gpkg",
                          "--force"));
}

TEST(MakePlan, JobsComeAfterWhatTheyRead) {
  const SiteFolder site;
  const Plan plan = site.PlanOf(kSite);
  EXPECT_THAT(plan.jobs[0].needs, IsEmpty());
  EXPECT_THAT(plan.jobs[1].inputs,
              ElementsAre("rig.yaml", "a.mp4", "a.csv", "wheels.csv", "a.csv"));
  EXPECT_THAT(plan.jobs[2].needs, ElementsAre(0));
  EXPECT_THAT(plan.jobs[2].inputs, ElementsAre("old.gpkg"));
  EXPECT_THAT(plan.jobs[3].needs, ElementsAre(0, 1));
  EXPECT_THAT(plan.jobs[5].needs, IsEmpty());
  EXPECT_THAT(plan.jobs[5].uses, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(plan.jobs[6].needs, ElementsAre(5));
}

TEST(MakePlan, TheSolutionIsTheSiteWithoutControlPoints) {
  const SiteFolder site;
  const Plan plan = site.PlanOf(kTwoRecordings);
  EXPECT_THAT(JobNames(plan), ElementsAre("map-a", "map-b", "match-a--b", "solve"));
  EXPECT_EQ(plan.jobs[3].output, "site.gpkg");
}

TEST(MakePlan, TheSolutionLeavesOutWhatFailed) {
  const SiteFolder site;
  const Plan plan = site.PlanOf(kTwoRecordings);
  EXPECT_THAT(WordsOf(plan.jobs[3], {true, false, false, false}),
              ElementsAre("solve", "site.work/maps/a.gpkg", "-o", "site.gpkg", "--force"));
}

TEST(MakePlan, JobsDrawTheMosaicInParts) {
  const SiteFolder site;
  const Plan plan =
      site.PlanOf(std::string(kTwoRecordings) + "options: {mosaic_parts: 2, solve: [--x]}\n");
  EXPECT_THAT(
      JobNames(plan),
      ElementsAre("map-a", "map-b", "match-a--b", "solve", "mosaic-1", "mosaic-2", "mosaic"));
  EXPECT_EQ(plan.parts, 2U);
  EXPECT_THAT(AllWords(plan, 3),
              ElementsAre("solve",
                          "site.work/maps/a.gpkg",
                          "site.work/maps/b.gpkg",
                          "--edges=site.work/matches/a--b.edges",
                          "--no-mosaic",
                          "-o",
                          "site.work/solved.gpkg",
                          "--force",
                          "--x"));
  EXPECT_THAT(AllWords(plan, 5),
              ElementsAre("mosaic",
                          "site.work/solved.gpkg",
                          "--part=2/2",
                          "-o",
                          "site.work/mosaic/2.gpkg",
                          "--force"));
  EXPECT_THAT(plan.jobs[5].needs, ElementsAre(3));
  EXPECT_THAT(AllWords(plan, 6),
              ElementsAre("mosaic",
                          "site.work/solved.gpkg",
                          "--assemble",
                          "site.work/mosaic/1.gpkg",
                          "site.work/mosaic/2.gpkg",
                          "-o",
                          "site.gpkg",
                          "--force"));
  EXPECT_THAT(plan.jobs[6].needs, ElementsAre(3, 4, 5));
}

TEST(MakePlan, AMosaicOfPartsIsAlignedAfterwards) {
  const SiteFolder site;
  const Plan plan = site.PlanOf(std::string(kTwoRecordings) +
                                "options: {mosaic_parts: 3}\ncontrol_points: points.csv\n");
  ASSERT_EQ(plan.jobs.size(), 9U);
  EXPECT_EQ(plan.jobs[7].output, "site.work/drawn.gpkg");
  EXPECT_THAT(
      AllWords(plan, 8),
      ElementsAre(
          "align", "site.work/drawn.gpkg", "--points=points.csv", "-o", "site.gpkg", "--force"));
  EXPECT_THAT(plan.jobs[8].needs, ElementsAre(7));
}

TEST(MakePlan, LargeSitesAreDrawnInParts) {
  const SiteFolder site;
  std::string text = "output: site.gpkg\nrecordings:\n";
  for (int i = 1; i <= 100; ++i) {
    text += "  - {name: r" + std::to_string(i) + ", rig: rig.yaml, up: a.mp4}\n";
    if (i == 99) EXPECT_EQ(site.PlanOf(text).parts, 0U);
  }
  EXPECT_EQ(site.PlanOf(text).parts, 2U);
  EXPECT_EQ(site.PlanOf(text + "options: {mosaic_parts: 1}\n").parts, 0U);
}

TEST(MakePlan, APatternReadsItsFolder) {
  const SiteFolder site;
  Plan plan = site.PlanOf(
      "output: site.gpkg\n"
      "recordings:\n"
      "  - {rig: rig.yaml, up: 'frames/%04d.png'}\n"
      "  - {name: b, rig: rig.yaml, up: '%04d.png'}\n");
  EXPECT_THAT(plan.jobs[0].inputs, ElementsAre("rig.yaml", "frames/%04d.png", "frames"));
  EXPECT_THAT(plan.jobs[1].inputs, ElementsAre("rig.yaml", "%04d.png"));
  std::filesystem::create_directory(site.folder / "frames");
  plan = WithExistingInputs(std::move(plan));
  EXPECT_THAT(plan.jobs[0].inputs, ElementsAre("rig.yaml", "frames"));
}

TEST(ResultDates, AreThoseOfTheNewestInput) {
  const SiteFolder site;
  site.Touch("rig.yaml", 1000);
  site.Touch("a.mp4", 3000);
  site.Touch("b.mp4", 2000);
  EXPECT_THAT(ResultDates(site.PlanOf(kTwoRecordings)), ElementsAre(3000, 2000, 3000, 3000));
}

}  // namespace
}  // namespace ceilmap::site
