// Sessions of a scene: what changes on its ceiling, and what only seems to.

#include "samples/simulator/sessions.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/base/error.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/renderer.hpp"
#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// 12 x 8 m of tiles with lamps; the camera sees 2.4 x 1.8 m of it, 10 mm a pixel.
const std::string kHall = R"(seed: 9
room: {length_m: 12, width_m: 8, height_m: 2.4}
ceiling: {lamp_every_x: 3, lamp_every_y: 3, lamps_off_share: 0.2}
camera: {width_px: 240, height_px: 180, focal_px: 200}
picture: {motion_blur: false}
path: {area_m: [2, 2, 10, 6], row_spacing_m: 2}
)";

Scene Hall(int session, const std::string& sessions = "{changed_share_per_session: 0.05}") {
  return ParseScene(kHall + "sessions: " + sessions, "s.yaml", {{}, session});
}

double AreaOf(const std::vector<CeilingChange>& changes) {
  double sum = 0;
  for (const CeilingChange& change : changes) sum += change.area_m.volume();
  return sum;
}

std::string SessionErrorOf(const std::string& text, const SceneChoice& choice = {}) {
  try {
    (void)ParseScene(text, "s.yaml", choice);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

/// Places of the camera that together see the ceiling up to 0.3 m from the walls.
std::vector<Eigen::Isometry3d> Places() {
  std::vector<Eigen::Isometry3d> places;
  for (double x = 1.2; x < 12; x += 1.6) {
    for (double y = 1.2; y < 8; y += 1.4) places.push_back(Level(x, y, 90));
  }
  return places;
}

TEST(Sessions, SessionZeroIsTheSceneWithoutTheKeys) {
  const Scene plain = ParseScene(kHall, "s.yaml");
  const Scene zero =
      Hall(0, "{path_jitter_m: 0.3, exposure_spread: 0.2, sun_patches: 5, people: 3}");
  EXPECT_FALSE(plain.session);
  ASSERT_TRUE(zero.session);
  const std::vector<Frame> plain_frames = MakePath(plain);
  const std::vector<Frame> frames = MakePath(zero);
  ASSERT_EQ(frames.size(), plain_frames.size());
  const Renderer plain_renderer(plain);
  const Renderer renderer(zero);
  for (const std::size_t i : {std::size_t{0}, frames.size() / 2}) {
    EXPECT_EQ(frames[i].stamp_s, plain_frames[i].stamp_s);
    const cv::Mat expected = plain_renderer.Render(plain_frames[i]);
    EXPECT_EQ(cv::norm(renderer.Render(frames[i]), expected, cv::NORM_INF), 0);
  }
  EXPECT_EQ(ChangesCsv(plain), "");
  EXPECT_EQ(ChangesCsv(zero), "id,kind,detail,session,x_min,y_min,x_max,y_max,visible_share\n");
}

TEST(Sessions, EachAddsToTheOneBefore) {
  const std::vector<CeilingChange> three = Hall(3).ceiling.changes;
  const std::vector<CeilingChange> five = Hall(5).ceiling.changes;
  ASSERT_GT(five.size(), three.size());
  for (std::size_t i = 0; i < five.size(); ++i) {
    EXPECT_EQ(five[i].id, static_cast<int>(i) + 1);
    EXPECT_EQ(five[i].session <= 3, i < three.size());
    if (i >= three.size()) continue;
    EXPECT_EQ(five[i].look, three[i].look);
    EXPECT_EQ(five[i].area_m.min(), three[i].area_m.min());
    EXPECT_EQ(five[i].area_m.max(), three[i].area_m.max());
  }
  const Scene other = ParseScene(kHall + "sessions: {}\nsession: 3", "s.yaml", {10, {}});
  EXPECT_EQ(other.session, 3);
  EXPECT_NE(other.ceiling.changes.front().look, three.front().look);
}

TEST(Sessions, ChangeTheirShareOfTheArea) {
  // One tile of each kind and half of a banner may be owed, or too many.
  const double tolerance = 3 * 0.18 + 0.25 * 3;
  for (const int session : {1, 4, 12}) {
    EXPECT_NEAR(AreaOf(Hall(session).ceiling.changes), session * 0.05 * 96, tolerance) << session;
  }
  std::map<ChangeKind, double> by_kind;
  const std::vector<CeilingChange> changes = Hall(12).ceiling.changes;
  for (const CeilingChange& change : changes) by_kind[change.kind] += change.area_m.volume();
  const double all = 12 * 0.05 * 96;
  EXPECT_NEAR(by_kind[ChangeKind::kPanel], 0.5 * all, 0.19);
  EXPECT_NEAR(by_kind[ChangeKind::kOpening], 0.1 * all, 0.19);
  EXPECT_NEAR(by_kind[ChangeKind::kLamp], 0.1 * all, 0.19);
  EXPECT_NEAR(by_kind[ChangeKind::kBanner], 0.3 * all, 0.76);
}

TEST(Sessions, ChangesOfOneDoNotOverlap) {
  const std::vector<CeilingChange> changes = Hall(8).ceiling.changes;
  const AlignedBox2d room(Vector2d(0, 0), Vector2d(12, 8));
  for (std::size_t i = 0; i < changes.size(); ++i) {
    EXPECT_TRUE(room.contains(changes[i].area_m)) << i;
    for (std::size_t j = i + 1; j < changes.size(); ++j) {
      if (changes[i].session != changes[j].session) continue;
      const AlignedBox2d both = changes[i].area_m.intersection(changes[j].area_m);
      EXPECT_TRUE(both.isEmpty() || both.volume() < 1e-9) << i << " and " << j;
    }
  }
}

/// The pixels of a rectangle of the ceiling, `more` on each side, within the image. For a robot
/// along an axis of map.
cv::Rect PixelsOf(const Renderer& renderer,
                  const Eigen::Isometry3d& place,
                  const AlignedBox2d& area,
                  int more) {
  const double height = renderer.GetScene().room.height_m;
  const Vector2d a = Pixel(renderer, place, {area.min().x(), area.min().y(), height});
  const Vector2d b = Pixel(renderer, place, {area.max().x(), area.max().y(), height});
  const Vector2d low = a.cwiseMin(b);
  const Vector2d high = a.cwiseMax(b);
  const Camera& camera = renderer.GetScene().camera;
  const cv::Point from(static_cast<int>(std::ceil(low.x())) - more,
                       static_cast<int>(std::ceil(low.y())) - more);
  const cv::Point to(static_cast<int>(std::floor(high.x())) + more + 1,
                     static_cast<int>(std::floor(high.y())) + more + 1);
  return cv::Rect(from, to) & cv::Rect(0, 0, camera.width_px, camera.height_px);
}

// By the light on the camera, without noise: all that differs is in the schedule, and all of the
// schedule differs.
TEST(Sessions, TheTruthIsWhatTheImagesShow) {
  const Scene now = Hall(6);
  const std::vector<CeilingChange>& changes = now.ceiling.changes;
  const Renderer before(Hall(0));
  const Renderer after(now);
  std::vector<int> seen(changes.size());
  std::vector<int> differs(changes.size());
  for (const Eigen::Isometry3d& place : Places()) {
    cv::Mat difference = cv::abs(after.RenderLight(place) - before.RenderLight(place));
    for (std::size_t i = 0; i < changes.size(); ++i) {
      const cv::Rect inside = PixelsOf(after, place, changes[i].area_m, -1);
      if (inside.empty()) continue;
      seen[i] += inside.area();
      differs[i] += cv::countNonZero(difference(inside) > 1e-3);
    }
    for (const CeilingChange& change : changes) {
      const cv::Rect around = PixelsOf(after, place, change.area_m, 2);
      if (!around.empty()) difference(around).setTo(0);
    }
    EXPECT_EQ(cv::countNonZero(difference > 1e-4), 0);
  }
  int judged = 0;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (seen[i] < 200 || VisibleShare(changes, i) < 0.999) continue;
    ++judged;
    EXPECT_GT(differs[i], 0.7 * seen[i]) << NameOf(changes[i].kind) << " " << changes[i].id;
  }
  EXPECT_GT(judged, 25);
}

TEST(Sessions, LaterChangesCoverEarlierOnes) {
  const auto at = [](double x0, double y0, double x1, double y1) {
    CeilingChange change;
    change.area_m = {Vector2d(x0, y0), Vector2d(x1, y1)};
    return change;
  };
  const std::vector<CeilingChange> changes{
      at(0, 0, 2, 2), at(1, 1, 3, 3), at(0, 0, 1, 0.5), at(2.5, 1, 3, 3)};
  EXPECT_NEAR(VisibleShare(changes, 0), 1 - 0.25 - 0.125, 1e-12);
  EXPECT_NEAR(VisibleShare(changes, 1), 0.75, 1e-12);
  EXPECT_EQ(VisibleShare(changes, 2), 1);
  EXPECT_EQ(VisibleShare(changes, 3), 1);
}

TEST(Sessions, TheTableHasALineForEachChange) {
  Scene scene = Hall(1);
  scene.ceiling.changes.resize(2);
  scene.ceiling.changes[0].kind = ChangeKind::kLamp;
  scene.ceiling.changes[0].detail = ChangeDetail::kTakenAway;
  scene.ceiling.changes[0].area_m = {Vector2d(1.8, 3), Vector2d(2.4, 3.6)};
  scene.ceiling.changes[1] = scene.ceiling.changes[0];
  scene.ceiling.changes[1].id = 2;
  scene.ceiling.changes[1].session = 7;
  EXPECT_EQ(ChangesCsv(scene),
            "id,kind,detail,session,x_min,y_min,x_max,y_max,visible_share\n"
            "1,lamp,taken_away,1,1.800000,3.000000,2.400000,3.600000,0.000000\n"
            "2,lamp,taken_away,7,1.800000,3.000000,2.400000,3.600000,1.000000\n");
}

TEST(Sessions, TheTableOfDisturbancesHasSunAndMovers) {
  Scene scene = Hall(0);
  scene.ceiling.sun.push_back({1, 2, 3, 0.5, std::numbers::pi / 2, 0.6});
  scene.movers.push_back({4, 5, 0.3, 0.5, 0, 1.75, 30, 1, 1, 1, 0.5, -1, 7, 9});
  EXPECT_EQ(DisturbancesCsv(scene),
            "kind,x,y,length,width,bottom,top,yaw_deg,velocity_x,velocity_y,from_s,to_s\n"
            "sun,1.000000,2.000000,3.000000,0.500000,,,90.000000,,,,\n"
            "mover,4.000000,5.000000,0.300000,0.500000,0.000000,1.750000,30.000000,0.500000,"
            "-1.000000,7.000000,9.000000\n");
}

TEST(Sessions, AreDifferentDrives) {
  const Scene before = Hall(1, "{changed_share_per_session: 0}");
  const Scene after = Hall(2, "{changed_share_per_session: 0, path_jitter_m: 0.2}");
  const std::vector<Frame> frames = MakePath(after);
  EXPECT_NEAR(frames.front().stamp_s, MakePath(before).front().stamp_s + 86400, 1e-6);
  double moved = 0;
  for (const Frame& frame : {MakePath(before).front(), frames.front()}) {
    const Vector2d from_start = frame.T_map_base.translation().head<2>() - Vector2d(2, 2);
    moved = from_start.cwiseAbs().maxCoeff();
    EXPECT_LE(moved, 0.2 + 1e-9);
  }
  EXPECT_GT(moved, 1e-3);
  // The same place: no change, but another noise.
  const Frame still = StillFrame(0, {5, 4, 0}, 100);
  const cv::Mat a = Renderer(before).Render(still);
  const cv::Mat b = Renderer(Hall(3, "{changed_share_per_session: 0}")).Render(still);
  EXPECT_GT(cv::norm(a, b, cv::NORM_INF), 0);
  EXPECT_LT(cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total()), 4);
  EXPECT_EQ(Hall(2, "{exposure_spread: 0}").image.exposure_gain, 1);
  EXPECT_NE(Hall(2, "{exposure_spread: 0.1}").image.exposure_gain, 1);
}

double Brightest(const Scene& scene, const std::vector<Eigen::Isometry3d>& places) {
  const Renderer renderer(scene);
  double lit = 0;
  for (const Eigen::Isometry3d& place : places) {
    lit += cv::countNonZero(renderer.RenderLight(place) > 1);
  }
  return lit;
}

TEST(Sessions, AreByDayOrAtNight) {
  const std::string kNights =
      "{changed_share_per_session: 0, night_every: 3, night_sessions: [4], ";
  const std::vector<Eigen::Isometry3d> places{Level(3, 4, 90), Level(8, 4, 90)};
  for (int session = 0; session < 6; ++session) {
    const Scene scene = Hall(session, kNights + "night_gain: 9}");
    const bool is_night = session == 2 || session == 4 || session == 5;
    EXPECT_EQ(scene.ceiling.is_night, is_night) << session;
    EXPECT_NEAR(scene.image.shot_noise, is_night ? 0.024 : 0.008, 1e-12);
    EXPECT_NEAR(scene.image.read_noise, is_night ? 0.0045 : 0.0005, 1e-12);
  }
  EXPECT_GT(Brightest(Hall(1, kNights + "night_lamps_on_share: 0}"), places), 1000);
  EXPECT_EQ(Brightest(Hall(2, kNights + "night_lamps_on_share: 0}"), places), 0);
}

TEST(Sessions, SunIsNoChange) {
  const std::string kSun = "{changed_share_per_session: 0, night_every: 2, sun_patches: 6}";
  EXPECT_TRUE(Hall(1, kSun).ceiling.sun.empty());  // at night
  const Scene scene = Hall(2, kSun);
  ASSERT_EQ(scene.ceiling.sun.size(), 6U);
  EXPECT_NE(Hall(4, kSun).ceiling.sun.front().x_m, scene.ceiling.sun.front().x_m);
  EXPECT_THAT(ChangesCsv(scene), testing::EndsWith("visible_share\n"));
  const SunPatch& sun = scene.ceiling.sun.front();
  const Eigen::Isometry3d place = Level(sun.x_m, sun.y_m, 0);
  const Renderer renderer(scene);
  const Renderer built(Hall(0, kSun));
  const Vector2d pixel = Pixel(renderer, place, {sun.x_m, sun.y_m, 2.4});
  const cv::Point at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
  EXPECT_GT(renderer.RenderLight(place).at<float>(at),
            (1 + 0.9 * sun.gain) * built.RenderLight(place).at<float>(at));
}

TEST(Sessions, HaveTheirOwnMovers) {
  const std::string kMovers = "{movers: [3, 2, 2, 1, 1, 0, 1, 0, 1, 1, 1, 0, 0, 0, 9]";
  EXPECT_EQ(Hall(2, kMovers + "}").movers.size(), 0U);
  ASSERT_EQ(Hall(3, kMovers + "}").movers.size(), 1U);
  EXPECT_EQ(Hall(3, kMovers + "}").movers[0].to_s, 9);
  const Scene scene = Hall(3, kMovers + ", people: 2, masts: 1}");
  ASSERT_EQ(scene.movers.size(), 4U);
  EXPECT_NE(scene.movers[1].x_m, Hall(4, "{people: 2}").movers[0].x_m);
  for (const Frame& frame : MakePath(scene)) {
    for (std::size_t i = 1; i < scene.movers.size(); ++i) {
      const Mover& mover = scene.movers[i];
      const double now_s = frame.stamp_s - StartStamp(scene);
      if (now_s < mover.from_s || now_s > mover.to_s) continue;
      const Vector2d at(mover.x_m + (now_s - mover.from_s) * mover.velocity_x_m_s,
                        mover.y_m + (now_s - mover.from_s) * mover.velocity_y_m_s);
      EXPECT_GT((at - frame.T_map_base.translation().head<2>()).norm(),
                std::hypot(mover.length_m, mover.width_m) / 2);
    }
  }
}

TEST(Sessions, BannersMayHangBelowTheCeiling) {
  const std::string kBanners =
      "{panel_share: 0, opening_share: 0, lamp_share: 0, banner_share: 1, "
      "changed_share_per_session: 0.04, ";
  const Scene flat = Hall(1, kBanners + "banner_drop_m: 0}");
  const Scene hung = Hall(1, kBanners + "banner_drop_m: 0.4}");
  ASSERT_FALSE(hung.ceiling.changes.empty());
  const AlignedBox2d area = hung.ceiling.changes[0].area_m;
  EXPECT_EQ(area.min(), flat.ceiling.changes[0].area_m.min());
  // An edge from the side: where it is by its height.
  const Eigen::Isometry3d place = Level(area.center().x() - 0.5, area.center().y(), 0);
  const Renderer renderer(hung);
  const cv::Mat change =
      cv::abs(renderer.RenderLight(place) - Renderer(Hall(0)).RenderLight(place));
  const auto differs = [&](const Eigen::Vector3d& p_map) {
    const Vector2d pixel = Pixel(renderer, place, p_map);
    if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > 239 || pixel.y() > 179) return false;
    return change.at<float>(static_cast<int>(std::lround(pixel.y())),
                            static_cast<int>(std::lround(pixel.x()))) > 0.03F;
  };
  EXPECT_TRUE(differs({area.center().x(), area.min().y() + 0.02, 2.0}));
  EXPECT_FALSE(differs({area.center().x(), area.min().y() - 0.03, 2.0}));
}

TEST(Sessions, ChangeCeilingsWithoutTiles) {
  for (const char* kind : {"plaster", "uniform", "periodic"}) {
    const std::string text = std::string("ceiling: {kind: ") + kind +
                             "}\ncamera: {width_px: 100, height_px: 80, focal_px: 80}\n"
                             "sessions: {changed_share_per_session: 0.1}\nsession: 1";
    const Renderer renderer(ParseScene(text, "s.yaml"));
    const Renderer built(ParseScene(text, "s.yaml", {{}, 0}));
    const std::vector<CeilingChange>& changes = renderer.GetScene().ceiling.changes;
    ASSERT_GT(changes.size(), 5U) << kind;
    for (const std::size_t i : {std::size_t{0}, changes.size() / 2, changes.size() - 1}) {
      const Vector2d centre = changes[i].area_m.center();
      const Eigen::Isometry3d place = Level(centre.x(), centre.y(), 0);
      const cv::Mat difference = renderer.RenderLight(place) - built.RenderLight(place);
      const cv::Mat middle = difference(cv::Rect(45, 35, 10, 10));
      EXPECT_GT(cv::norm(middle, cv::NORM_INF), 0.005) << kind << " " << changes[i].id;
    }
  }
}

TEST(Sessions, BadValuesAreReportedOnOneLine) {
  EXPECT_THAT(SessionErrorOf("seed: 1\nsession: 3"),
              HasSubstr("s.yaml:2: session = 3, must be absent without the group sessions"));
  EXPECT_THAT(SessionErrorOf("seed: 1", {{}, 2}), StartsWith("s.yaml: has no group sessions"));
  EXPECT_THAT(SessionErrorOf("sessions: {}\nsession: -1"), HasSubstr("s.yaml:2: session = -1"));
  EXPECT_THAT(SessionErrorOf("sessions: {panels: 1}"),
              HasSubstr("sessions.panels = 1 is an unknown key"));
  EXPECT_THAT(SessionErrorOf("sessions:\n  changed_share_per_session: 0.6"),
              HasSubstr("s.yaml:2: sessions.changed_share_per_session = 0.6, must be in [0, 0.5]"));
  EXPECT_THAT(SessionErrorOf("sessions: {night_sessions: [1.5]}"),
              HasSubstr("must be with whole numbers of sessions in [0, 10000]; correct 1.5"));
  EXPECT_THAT(SessionErrorOf("sessions: {movers: [1, 2, 3]}"),
              HasSubstr("must be rows of 15 numbers (session, x_m"));
  EXPECT_THAT(SessionErrorOf(
                  "sessions: {panel_share: 0, opening_share: 0, lamp_share: 0, banner_share: 0}"),
              HasSubstr("must be with a share of panels, openings, lamps or banners above 0"));
  EXPECT_THAT(SessionErrorOf("path: {kind: tum, tum_file: a.tum}\nsessions: {people: 1}"),
              HasSubstr("s.yaml:2: sessions.people = 1, must be absent"));
  EXPECT_THAT(SessionErrorOf("sessions: {banner_drop_m: 3}"),
              HasSubstr("s.yaml: sessions.banner_drop_m = 3, must be less than room.height_m"));
  EXPECT_THAT(SessionErrorOf("sessions: {changed_share_per_session: 0.5}\nsession: 10000"),
              HasSubstr("more than 20000 changes"));
  for (const std::string text : {"sessions: 3", "sessions: [1]", "sessions: {night_every: 1.5}"}) {
    EXPECT_EQ(SessionErrorOf(text).find('\n'), std::string::npos);
    EXPECT_NE(SessionErrorOf(text), "no error");
  }
}

}  // namespace
}  // namespace ceilmap::simulator
