#include "app/reports/rig_drawing.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "calib/rig_facts.hpp"

namespace ceilmap::reports {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPanelPx = 400;
constexpr double kMarginPx = 30;
constexpr double kTitlePx = 30;

constexpr const char* kRed = "#c00";
constexpr const char* kGreen = "#080";
constexpr const char* kBlue = "#00c";
constexpr const char* kGrey = "#777";
constexpr const char* kUpColour = "#06c";
constexpr const char* kForwardColour = "#c60";
constexpr const char* kOmniColour = "#909";

/// One view of the robot: points in metres, the first coordinate to the right, the second upwards.
class Panel {
 public:
  /// @param left_px  of the panel. @param points  that must be inside.
  Panel(double left_px, const std::vector<Vector2d>& points) {
    Eigen::AlignedBox2d box;
    for (const Vector2d& point : points) box.extend(point);
    size_m_ = std::max(box.sizes().maxCoeff(), 0.1);
    px_per_m_ = (kPanelPx - 2 * kMarginPx) / size_m_;
    origin_px_ = Vector2d(left_px + kPanelPx / 2, kTitlePx + kPanelPx / 2) -
                 px_per_m_ * Vector2d(box.center().x(), -box.center().y());
  }

  [[nodiscard]] double Size() const { return size_m_; }
  [[nodiscard]] double PxPerMetre() const { return px_per_m_; }
  [[nodiscard]] const std::string& Svg() const { return svg_; }

  void Line(const Vector2d& from, const Vector2d& to, const char* colour, const char* more = "") {
    const Vector2d a = Px(from);
    const Vector2d b = Px(to);
    svg_ += fmt::format(R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" stroke="{}" {}/>)"
                        "\n",
                        a.x(),
                        a.y(),
                        b.x(),
                        b.y(),
                        colour,
                        more);
  }
  void Arrow(const Vector2d& from, const Vector2d& to, const char* colour) {
    Line(from, to, colour, R"(stroke-width="2")");
    const Vector2d ahead = (Px(to) - Px(from)).normalized();
    const Vector2d aside(-ahead.y(), ahead.x());
    const Vector2d tip = Px(to);
    const Vector2d a = tip - 9 * ahead + 4 * aside;
    const Vector2d b = tip - 9 * ahead - 4 * aside;
    svg_ += fmt::format(R"(<polygon points="{:.1f},{:.1f} {:.1f},{:.1f} {:.1f},{:.1f}" fill="{}"/>)"
                        "\n",
                        tip.x(),
                        tip.y(),
                        a.x(),
                        a.y(),
                        b.x(),
                        b.y(),
                        colour);
  }
  void Area(const std::vector<Vector2d>& points, const char* colour) {
    std::string list;
    for (const Vector2d& point : points) {
      list += fmt::format("{:.1f},{:.1f} ", Px(point).x(), Px(point).y());
    }
    svg_ += fmt::format(R"(<polygon points="{}" fill="{}" fill-opacity="0.12" stroke="{}"/>)"
                        "\n",
                        list,
                        colour,
                        colour);
  }
  void Dot(const Vector2d& point, const char* colour) {
    svg_ += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="4" fill="{}"/>)"
                        "\n",
                        Px(point).x(),
                        Px(point).y(),
                        colour);
  }
  /// @param right_px, up_px  offset of the text from the point.
  void Text(const Vector2d& point,
            double right_px,
            double up_px,
            const std::string& text,
            const char* colour) {
    svg_ += fmt::format(R"(<text x="{:.1f}" y="{:.1f}" fill="{}">{}</text>)"
                        "\n",
                        Px(point).x() + right_px,
                        Px(point).y() - up_px,
                        colour,
                        text);
  }

 private:
  [[nodiscard]] Vector2d Px(const Vector2d& point) const {
    return origin_px_ + px_per_m_ * Vector2d(point.x(), -point.y());
  }

  double size_m_ = 1;
  double px_per_m_ = 1;
  Vector2d origin_px_;
  std::string svg_;
};

/// Seen from above with the front upwards: base x is up, base y is to the left.
Vector2d FromAbove(const Vector2d& p_base) {
  return {-p_base.y(), p_base.x()};
}

/// Seen from the right side: base x is to the right, base z is up.
Vector2d FromSide(const Vector3d& p_base) {
  return {p_base.x(), p_base.z()};
}

struct DrawnCamera {
  const calib::MountedCamera* camera;
  const char* name;
  const char* colour;
};

std::vector<DrawnCamera> CamerasOf(const calib::Rig& rig) {
  std::vector<DrawnCamera> cameras;
  if (rig.up) cameras.push_back({&*rig.up, "up", kUpColour});
  if (rig.forward) cameras.push_back({&*rig.forward, "forward", kForwardColour});
  if (rig.omni) cameras.push_back({&*rig.omni, "omni", kOmniColour});
  return cameras;
}

std::vector<Vector2d> FootprintFromAbove(const calib::RigFacts& facts) {
  std::vector<Vector2d> points;
  if (!facts.up || !facts.up->corners_m) return points;
  for (const Vector2d& corner : *facts.up->corners_m) points.push_back(FromAbove(corner));
  return points;
}

/// The directions at the edges of a field of view about an axis, in a plane.
std::vector<Vector2d> Wedge(const Vector2d& apex,
                            double axis_rad,
                            double angle_rad,
                            double length) {
  std::vector<Vector2d> points{apex};
  constexpr int kSteps = 8;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = axis_rad + angle_rad * (static_cast<double>(i) / kSteps - 0.5);
    points.emplace_back(apex + length * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

std::string DrawFromAbove(const calib::Rig& rig, const calib::RigFacts& facts) {
  constexpr double kHalfAxleM = 0.15;
  const Vector2d axle(-rig.axle_behind_mast_m, 0);
  const std::vector<Vector2d> footprint = FootprintFromAbove(facts);
  std::vector<Vector2d> inside = footprint;
  inside.insert(inside.end(),
                {FromAbove(axle + Vector2d(0, 2 * kHalfAxleM)),
                 FromAbove(axle - Vector2d(0, 2 * kHalfAxleM)),
                 FromAbove({0.5, 0}),
                 FromAbove({-0.5, 0})});
  for (const DrawnCamera& drawn : CamerasOf(rig)) {
    inside.push_back(FromAbove(drawn.camera->T_base_cam.translation().head<2>()));
  }
  Panel panel(0, inside);
  const double axis_m = 0.2 * panel.Size();
  if (!footprint.empty()) {
    panel.Area(footprint, kUpColour);
    const Vector2d top = (footprint[0] + footprint[1]) / 2;
    const Vector2d bottom = (footprint[2] + footprint[3]) / 2;
    panel.Arrow(top + 0.15 * (bottom - top), top, kUpColour);
    panel.Text(top, 8, -14, "top of image", kUpColour);
  }
  if (facts.forward && facts.forward->field_of_view) {
    const Vector2d apex = FromAbove(rig.forward->T_base_cam.translation().head<2>());
    panel.Area(Wedge(apex,
                     facts.forward->yaw_rad + std::numbers::pi / 2,
                     facts.forward->field_of_view->horizontal_rad,
                     0.4 * panel.Size()),
               kForwardColour);
  }
  panel.Line(FromAbove(axle + Vector2d(0, kHalfAxleM)),
             FromAbove(axle - Vector2d(0, kHalfAxleM)),
             kGrey,
             R"(stroke-width="5")");
  panel.Text(FromAbove(axle - Vector2d(0, kHalfAxleM)), 6, -4, "axle", kGrey);
  panel.Arrow({0, 0}, FromAbove({axis_m, 0}), kRed);
  panel.Text(FromAbove({axis_m, 0}), 6, -4, "x: front", kRed);
  panel.Arrow({0, 0}, FromAbove({0, axis_m}), kGreen);
  panel.Text(FromAbove({0, axis_m}), -14, 8, "y: left", kGreen);
  for (const DrawnCamera& drawn : CamerasOf(rig)) {
    panel.Dot(FromAbove(drawn.camera->T_base_cam.translation().head<2>()), drawn.colour);
  }
  return panel.Svg();
}

/// Dots with names that do not cover each other.
void DrawNames(std::vector<DrawnCamera> cameras, Panel& panel) {
  const auto height_m = [](const DrawnCamera& drawn) {
    return drawn.camera->T_base_cam.translation().z();
  };
  std::sort(cameras.begin(), cameras.end(), [&](const DrawnCamera& a, const DrawnCamera& b) {
    return height_m(a) < height_m(b);
  });
  constexpr double kLinePx = 14;
  constexpr double kBelowDotPx = -4;
  double lowest_px = 0;
  for (const DrawnCamera& drawn : cameras) {
    const double height_px = panel.PxPerMetre() * height_m(drawn) + kBelowDotPx;
    const double text_px = std::max(height_px, lowest_px);
    lowest_px = text_px + kLinePx;
    const Vector2d place = FromSide(drawn.camera->T_base_cam.translation());
    panel.Dot(place, drawn.colour);
    panel.Text(place,
               8,
               kBelowDotPx + text_px - height_px,
               fmt::format("{}, {:.3g} m", drawn.name, place.y()),
               drawn.colour);
  }
}

void DrawUpFromSide(const calib::Rig& rig, const calib::UpFacts& up, Panel& panel) {
  if (!up.corners_m) return;
  const auto by_x = [](const Vector2d& a, const Vector2d& b) { return a.x() < b.x(); };
  const auto [back, front] = std::minmax_element(up.corners_m->begin(), up.corners_m->end(), by_x);
  panel.Area({FromSide(rig.up->T_base_cam.translation()),
              {front->x(), rig.ceiling_height_m},
              {back->x(), rig.ceiling_height_m}},
             kUpColour);
}

std::string DrawFromSide(const calib::Rig& rig, const calib::RigFacts& facts) {
  std::vector<Vector2d> inside{
      {-0.5, 0}, {0.5, 0}, {-rig.axle_behind_mast_m, 0}, {0, rig.ceiling_height_m}};
  if (facts.up && facts.up->corners_m) {
    for (const Vector2d& corner : *facts.up->corners_m) inside.emplace_back(corner.x(), 0);
  }
  double top_m = 0;
  for (const DrawnCamera& drawn : CamerasOf(rig)) {
    inside.push_back(FromSide(drawn.camera->T_base_cam.translation()));
    top_m = std::max(top_m, drawn.camera->T_base_cam.translation().z());
  }
  Panel panel(kPanelPx, inside);
  const double axis_m = 0.15 * panel.Size();
  const double side_m = panel.Size() / 2;
  const double middle_m = (facts.up && facts.up->corners_m)
                              ? ((*facts.up->corners_m)[0].x() + (*facts.up->corners_m)[2].x()) / 2
                              : 0;
  panel.Line({middle_m - side_m, 0}, {middle_m + side_m, 0}, kGrey);
  panel.Text({middle_m - side_m, 0}, 0, -14, "floor", kGrey);
  panel.Line(
      {middle_m - side_m, rig.ceiling_height_m}, {middle_m + side_m, rig.ceiling_height_m}, kGrey);
  panel.Text({middle_m - side_m, rig.ceiling_height_m},
             0,
             6,
             fmt::format("ceiling, h = {:g} m", rig.ceiling_height_m),
             kGrey);
  panel.Line({0, 0}, {0, top_m}, kGrey, R"(stroke-width="3")");
  if (facts.up) DrawUpFromSide(rig, *facts.up, panel);
  if (facts.forward && facts.forward->field_of_view) {
    panel.Area(Wedge(FromSide(rig.forward->T_base_cam.translation()),
                     facts.forward->elevation_rad,
                     facts.forward->field_of_view->vertical_rad,
                     0.3 * panel.Size()),
               kForwardColour);
  }
  panel.Dot({-rig.axle_behind_mast_m, 0}, kGrey);
  panel.Text({-rig.axle_behind_mast_m, 0}, -30, 6, "axle", kGrey);
  panel.Arrow({0, 0}, {axis_m, 0}, kRed);
  panel.Text({axis_m, 0}, -4, -14, "x", kRed);
  panel.Arrow({0, 0}, {0, axis_m}, kBlue);
  panel.Text({0, axis_m}, -14, -6, "z", kBlue);
  DrawNames(CamerasOf(rig), panel);
  return panel.Svg();
}

}  // namespace

std::string DrawRig(const calib::Rig& rig) {
  const calib::RigFacts facts = calib::DescribeRig(rig);
  const double width = 2 * kPanelPx;
  const double height = kPanelPx + kTitlePx;
  return fmt::format(
             R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0:g} {1:g}" width="{0:g}" )"
             R"(height="{1:g}" font-family="sans-serif" font-size="12">)"
             "\n"
             R"(<rect width="100%" height="100%" fill="white"/>)"
             "\n"
             R"(<text x="{2:g}" y="20" font-size="14">seen from above</text>)"
             "\n"
             R"(<text x="{3:g}" y="20" font-size="14">seen from its right side</text>)"
             "\n",
             width,
             height,
             kMarginPx,
             kPanelPx + kMarginPx) +
         DrawFromAbove(rig, facts) + DrawFromSide(rig, facts) + "</svg>\n";
}

}  // namespace ceilmap::reports
