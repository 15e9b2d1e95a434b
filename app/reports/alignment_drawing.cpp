#include "app/reports/alignment_drawing.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "app/page/base64.hpp"
#include "app/page/html_text.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::reports {
namespace {

using Eigen::Vector2d;

constexpr double kPicturePx = 1000;  // longer side of the drawing
constexpr double kBorderPx = 40;
constexpr double kFooterPx = 30;
constexpr double kArrowPx = 40;  // length of the largest residual of a used point
constexpr const char* kUsedColour = "#06c";
constexpr const char* kUnusedColour = "#c00";

/// From the site to pixels of the drawing.
class SiteView {
 public:
  explicit SiteView(const Eigen::AlignedBox2d& box) {
    const double side = std::max(box.sizes().maxCoeff(), 1e-3);
    px_per_m_ = (kPicturePx - 2 * kBorderPx) / side;
    left_top_ = {box.min().x(), box.max().y()};
    size_ = px_per_m_ * box.sizes() + Vector2d::Constant(2 * kBorderPx);
  }

  [[nodiscard]] double PxPerMetre() const { return px_per_m_; }
  [[nodiscard]] Vector2d Size() const { return size_; }
  [[nodiscard]] Vector2d operator()(const Vector2d& p_site) const {
    return Vector2d::Constant(kBorderPx) +
           px_per_m_ * Vector2d(p_site.x() - left_top_.x(), left_top_.y() - p_site.y());
  }

 private:
  double px_per_m_ = 1;
  Vector2d left_top_ = Vector2d::Zero();
  Vector2d size_ = Vector2d::Zero();
};

/// An image whose upper left, upper right and lower left corners lie at these pixels. PNG, because
/// few programs beside browsers read WebP in a drawing.
std::string Image(const cv::Mat& image,
                  const Vector2d& left_top,
                  const Vector2d& right_top,
                  const Vector2d& left_bottom,
                  double opacity) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", image, bytes)) throw RunError("the picture cannot be encoded");
  const Vector2d u = right_top - left_top;
  const Vector2d v = left_bottom - left_top;
  return fmt::format(R"svg(<image width="1" height="1" preserveAspectRatio="none" opacity="{}" )svg"
                     R"svg(transform="matrix({:.6f} {:.6f} {:.6f} {:.6f} {:.3f} {:.3f})" )svg"
                     R"svg(href="data:image/png;base64,{}"/>)svg"
                     "\n",
                     opacity,
                     u.x(),
                     u.y(),
                     v.x(),
                     v.y(),
                     left_top.x(),
                     left_top.y(),
                     page::Base64(bytes));
}

/// The map's mosaic, small enough for a drawing.
struct Overview {
  store::MosaicGrid grid;  ///< of 0 x 0 pixels: the map has none
  cv::Mat image;           ///< CV_8UC4

  /// A corner in the map: 0 or 1 from the left, and from the top.
  [[nodiscard]] Vector2d Corner(int right, int down) const {
    return {grid.min_x + right * grid.width_px * grid.resolution,
            grid.max_y - down * grid.height_px * grid.resolution};
  }
};

Overview OverviewOf(const store::MapReader& map) {
  constexpr int kMaxPx = 2000;
  Overview overview;
  cv::Mat grey;
  cv::Mat alpha;
  overview.grid = map.ReadOverview(kMaxPx, grey, alpha);
  if (grey.empty()) return overview;
  const std::array<cv::Mat, 4> bands = {grey, grey, grey, alpha};
  cv::merge(bands.data(), bands.size(), overview.image);
  return overview;
}

std::string DrawMosaic(const Overview& overview,
                       const survey::SiteFrame& site,
                       const SiteView& view) {
  if (overview.image.empty()) return {};
  const auto at = [&](int right, int down) {
    return view(site.S_site_map * overview.Corner(right, down));
  };
  return Image(overview.image, at(0, 0), at(1, 0), at(0, 1), 0.8);
}

std::string DrawPlan(const store::SitePlan& plan, const SiteView& view) {
  std::string svg;
  if (!plan.image.empty()) {
    const auto at = [&](double col, double row) {
      const auto& t = plan.transform;
      return view(Vector2d(t[0] + t[1] * col + t[2] * row, t[3] + t[4] * col + t[5] * row));
    };
    const double cols = plan.image.cols;
    const double rows = plan.image.rows;
    svg += Image(plan.image, at(0, 0), at(cols, 0), at(0, rows), 1);
  }
  std::string path;
  for (const std::vector<Vector2d>& line : plan.lines) {
    const char* move = "M";
    for (const Vector2d& point : line) {
      const Vector2d px = view(point);
      path += fmt::format("{}{:.1f} {:.1f}", move, px.x(), px.y());
      move = "L";
    }
  }
  if (!path.empty())
    svg += fmt::format(R"(<path d="{}" fill="none" stroke="#333"/>)"
                       "\n",
                       path);
  return svg;
}

/// Pixels per metre of a residual: a round number.
double ArrowScale(const survey::SiteFrame& site) {
  double largest = 1e-4;  // smaller ones are not seen
  for (const survey::AlignedPoint& point : site.points) {
    if (point.used) largest = std::max(largest, point.residual_m.norm());
  }
  const double most = kArrowPx / largest;
  const double decade = std::pow(10, std::floor(std::log10(most)));
  return most >= 5 * decade ? 5 * decade : most >= 2 * decade ? 2 * decade : decade;
}

std::string DrawPoint(const survey::AlignedPoint& point, const SiteView& view, double arrow) {
  const Vector2d at = view(point.point.p_site);
  // From the surveyed place to that of the map: against the residual; y is down in the drawing.
  Vector2d tip = arrow * Vector2d(-point.residual_m.x(), point.residual_m.y());
  if (tip.norm() > 4 * kArrowPx) tip *= 4 * kArrowPx / tip.norm();
  const char* colour = point.used ? kUsedColour : kUnusedColour;
  const std::string label = fmt::format("{} {:.1f} mm{}",
                                        page::EscapedForHtml(point.point.name),
                                        1e3 * point.residual_m.norm(),
                                        point.used ? "" : ", not used");
  return fmt::format(
      R"(<circle cx="{0:.1f}" cy="{1:.1f}" r="4" fill="{4}"/>)"
      R"(<line x1="{0:.1f}" y1="{1:.1f}" x2="{2:.1f}" y2="{3:.1f}" stroke="{4}" stroke-width="2"/>)"
      R"(<text x="{5:.1f}" y="{6:.1f}" fill="{4}" stroke="#fff" stroke-width="3" )"
      R"(paint-order="stroke">{7}</text>)"
      "\n",
      at.x(),
      at.y(),
      at.x() + tip.x(),
      at.y() + tip.y(),
      colour,
      at.x() + 7,
      at.y() - 7,
      label);
}

/// The mosaic and the control points, with a border; the plan does not enlarge the drawing.
Eigen::AlignedBox2d Extent(const Overview& overview, const survey::SiteFrame& site) {
  Eigen::AlignedBox2d box;
  for (const survey::AlignedPoint& point : site.points) {
    box.extend(point.point.p_site);
    box.extend(site.S_site_map * point.point.p_map);
  }
  if (overview.image.empty()) return box;
  for (const int right : {0, 1}) {
    for (const int down : {0, 1}) box.extend(site.S_site_map * overview.Corner(right, down));
  }
  return box;
}

}  // namespace

std::string DrawAlignment(const store::MapReader& map,
                          const survey::SiteFrame& site,
                          const std::optional<store::SitePlan>& plan) {
  const Overview overview = OverviewOf(map);
  const SiteView view(Extent(overview, site));
  const double arrow = ArrowScale(site);
  const Vector2d size = view.Size();
  std::string svg =
      fmt::format(R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0:.0f}" height="{1:.0f}" )"
                  R"(viewBox="0 0 {0:.0f} {1:.0f}" font-family="sans-serif" font-size="13">)"
                  R"(<rect width="100%" height="100%" fill="#fff"/>)"
                  "\n",
                  size.x(),
                  size.y() + kFooterPx);
  if (plan) svg += DrawPlan(*plan, view);
  svg += DrawMosaic(overview, site, view);
  for (const survey::AlignedPoint& point : site.points) svg += DrawPoint(point, view, arrow);
  svg += fmt::format(
      R"(<text x="{:.0f}" y="{:.0f}">one metre is {:.3g} px; residuals are enlarged {:.3g} times</text>)"
      "\n</svg>\n",
      kBorderPx,
      size.y() + kFooterPx / 2,
      view.PxPerMetre(),
      arrow / view.PxPerMetre());
  return svg;
}

}  // namespace ceilmap::reports
