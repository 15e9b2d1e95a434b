// What commands report about rigs, and a map without one.

#include <nlohmann/json.hpp>

#include "app/files/tum.hpp"
#include "mapping/store/map_file.hpp"
#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

// 320 px at f = 200 px: 2 atan(0.8) = 77.3 deg, 3.2 x 2.4 m at 2 m.
TEST(InfoOfARig, SaysWhatItMeans) {
  const Recordings test;
  const support::ProcessResult result = test.Run({"info", "@rig.yaml", "--svg=rig.svg"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out,
            "robot             test robot\n"
            "ceiling           2.400 m above the floor\n"
            "axle              0.100 m behind the origin of base (a > 0)\n"
            "upward camera     320 x 240 px at x, y, z = 0.000, 0.000, 0.400 m\n"
            "  field of view   77.3 x 61.9 deg, diagonal 90.0 deg\n"
            "  sees            3.20 x 2.40 m of the ceiling, 2.00 m above it, at 10 mm per pixel\n"
            "  top of image    the robot's front\n"
            "  right of image  the robot's left\n"
            "  tilt            0.0 deg from the vertical\n"
            "written rig.svg\n");
  EXPECT_THAT(ReadAll(test.out / "rig.svg"), StartsWith("<svg "));
}

TEST(InfoOfARig, AsJson) {
  const Recordings test;
  const support::ProcessResult result = test.Run({"info", "@rig.yaml", "--json"});
  EXPECT_EQ(result.exit_code, 0);
  const auto info = nlohmann::json::parse(result.out);
  EXPECT_EQ(info["robot"], "test robot");
  EXPECT_NEAR(info["cameras"]["up"]["m_per_px"].get<double>(), 0.01, 1e-12);
  EXPECT_NEAR(info["cameras"]["up"]["image_top_yaw_deg"].get<double>(), 0, 1e-9);
  EXPECT_THAT(info["warnings"], IsEmpty());
  EXPECT_THAT(info["assumed"], IsEmpty());
}

TEST(RigWarnings, ArePrintedByTheCommands) {
  const Recordings test;
  std::string rig = kRig;
  test.in.Write("slip.yaml", rig.replace(rig.find("a: 0.1"), 6, "a: 140"));
  const std::string warning = "ceilmap: warning: " + (test.in / "slip.yaml").string() +
                              ": a = 140: millimetres? lengths are in metres: a = 0.14\n";
  EXPECT_EQ(test.Run({"info", "@slip.yaml"}).err, warning);
  ASSERT_EQ(test.Run({"map", "--quiet", "--rig=@slip.yaml", "--up=@run.avi", "-o", "m.gpkg"}).err,
            warning);
  EXPECT_THAT(
      test.Run({"localize", "m.gpkg", "--rig=@slip.yaml", "--up=@run.avi", "-o", "t.tum"}).err,
      StartsWith(warning));
}

// The field of view and the heights of the rig: the same map.
TEST(MapByFieldOfView, IsInMetres) {
  const Recordings test;
  const support::ProcessResult result = test.Run({"map",
                                                  "--fov=77.3196165",
                                                  "--ceiling-height=2.4",
                                                  "--camera-height=0.4",
                                                  "--up=@run.avi",
                                                  "-o",
                                                  "m.gpkg",
                                                  "--trajectory=t.tum"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err,
              HasSubstr("ceilmap: --fov 77.3196: lengths in metres are as exact as this angle and "
                        "the 2 m from the camera to the ceiling; the lens is taken to be without "
                        "distortion\n"));
  const store::MapMetadata metadata = store::MapReader(test.out / "m.gpkg").Metadata();
  EXPECT_EQ(metadata.unit, "m");
  EXPECT_NEAR(metadata.view_units_per_px, 0.01, 1e-8);
  EXPECT_THAT(metadata.rig_yaml, StartsWith("# made from a horizontal field of view of "));
  const StampedPose last = files::ReadTum(test.out / "t.tum").back();
  EXPECT_NEAR(last.position.x(), -0.01 * kStep.y * (kFrames - 1), 0.002);
  EXPECT_NEAR(last.position.y(), 0.01 * kStep.x * (kFrames - 1), 0.002);
  // The same robot needs no rig, another one its own.
  const support::ProcessResult same =
      test.Run({"localize", "m.gpkg", "--up=@run.avi", "-o", "same.tum"});
  EXPECT_EQ(same.exit_code, 0);
  EXPECT_THAT(same.err,
              HasSubstr("ceilmap: no --rig: the camera is taken to be that of the robot that made "
                        "the map\n"));
  EXPECT_EQ(
      test.Run({"localize", "m.gpkg", "--rig=@rig.yaml", "--up=@run.avi", "-o", "l.tum"}).exit_code,
      0);
}

}  // namespace
}  // namespace ceilmap::integration
