#include "tests/calib/solve/board_camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace ceilmap::calibration {
namespace {

using std::numbers::pi;

constexpr double kBlack = 35;
constexpr double kWhite = 215;
constexpr double kBehind = 90;   // mean grey value beside the board
constexpr double kBorder = 0.6;  // white border of the board, in squares

cv::Matx33d RotationBy(const cv::Vec3d& vector) {
  cv::Matx33d R;
  cv::Rodrigues(vector, R);
  return R;
}

// Direction at an angle from the axis.
cv::Vec3d Direction(double angle_rad, double azimuth_rad) {
  return {std::sin(angle_rad) * std::cos(azimuth_rad),
          std::sin(angle_rad) * std::sin(azimuth_rad),
          std::cos(angle_rad)};
}

// A board whose centre is at a point, which faces the camera except for tilts.
BoardPose FacingPose(const Board& board, const cv::Vec3d& centre, const cv::Vec3d& tilts_rad) {
  const cv::Vec3d z = cv::normalize(centre);
  const double angle = std::acos(std::clamp(z[2], -1.0, 1.0));
  cv::Vec3d axis(-z[1], z[0], 0);
  if (cv::norm(axis) > 1e-9) axis = cv::normalize(axis);
  const cv::Matx33d R = RotationBy(angle * axis) * RotationBy({0, 0, tilts_rad[2]}) *
                        RotationBy({tilts_rad[0], 0, 0}) * RotationBy({0, tilts_rad[1], 0});
  const cv::Vec3d middle(
      (board.columns - 1) * board.square_m / 2, (board.rows - 1) * board.square_m / 2, 0);
  BoardPose pose;
  cv::Rodrigues(R, pose.rotation);
  pose.translation = centre - R * middle;
  return pose;
}

}  // namespace

BoardCamera::BoardCamera(const Board& board, const Lens& lens, const ImageFaults& faults)
    : board_(board), lens_(lens), faults_(faults), rays_(lens.Size()) {
  for (int v = 0; v < rays_.rows; ++v) {
    for (int u = 0; u < rays_.cols; ++u) {
      const auto ray = lens.Ray({u, v});
      rays_(v, u) = ray ? cv::Vec3d(ray->x(), ray->y(), ray->z()) : cv::Vec3d(0, 0, 0);
    }
  }
}

// Squares have the indices -1 to columns and rows - 1.
double BoardCamera::Shade(double x_m, double y_m) const {
  const double x = x_m / board_.square_m;
  const double y = y_m / board_.square_m;
  if (x < -1 - kBorder || x > board_.columns + kBorder || y < -1 - kBorder ||
      y > board_.rows + kBorder) {
    return kBehind;
  }
  if (x < -1 || x > board_.columns || y < -1 || y > board_.rows) return kWhite;
  const int parity = static_cast<int>(std::floor(x)) + static_cast<int>(std::floor(y));
  return parity % 2 == 0 ? kBlack : kWhite;
}

cv::Mat BoardCamera::Take(const BoardPose& pose, std::uint64_t seed) const {
  const cv::Matx33d R = RotationBy(pose.rotation);
  const cv::Vec3d normal(R(0, 2), R(1, 2), R(2, 2));
  const double distance = normal.dot(pose.translation);
  // Where the board's plane is met; far away where it is not.
  const cv::Vec3d from = R.t() * pose.translation;
  const auto meet = [&](const cv::Vec3d& ray) {
    const double depth = distance / normal.dot(ray);
    if (!(depth > 0)) return cv::Vec2d(1e6, 1e6);
    const cv::Vec3d p = R.t() * ray * depth - from;
    return cv::Vec2d(p[0], p[1]);
  };
  cv::Mat_<cv::Vec2d> places(rays_.size());
  for (int v = 0; v < rays_.rows; ++v) {
    for (int u = 0; u < rays_.cols; ++u) places(v, u) = meet(rays_(v, u));
  }
  cv::Mat1f light(rays_.size(), 0.F);
  for (int v = 1; v + 1 < rays_.rows; ++v) {
    for (int u = 1; u + 1 < rays_.cols; ++u) {
      if (rays_(v, u) == cv::Vec3d(0, 0, 0)) continue;
      const cv::Vec2d& at = places(v, u);
      const cv::Vec2d across = 0.5 * (places(v, u + 1) - places(v, u - 1));
      const cv::Vec2d down = 0.5 * (places(v + 1, u) - places(v - 1, u));
      const auto shade = [&](double du, double dv) {
        const cv::Vec2d p = at + du * across + dv * down;
        return Shade(p[0], p[1]);
      };
      const double middle = shade(0, 0);
      const bool even = shade(-0.5, -0.5) == middle && shade(0.5, -0.5) == middle &&
                        shade(-0.5, 0.5) == middle && shade(0.5, 0.5) == middle;
      double sum = 0;
      constexpr int kParts = 8;
      for (int i = 0; !even && i < kParts * kParts; ++i) {
        sum += shade((i % kParts + 0.5) / kParts - 0.5, (i / kParts + 0.5) / kParts - 0.5);
      }
      light(v, u) = static_cast<float>(even ? middle : sum / (kParts * kParts));
    }
  }
  return Develop(light, seed);
}

cv::Mat BoardCamera::Develop(cv::Mat1f light, std::uint64_t seed) const {
  if (faults_.blur_px > 0) cv::GaussianBlur(light, light, {}, faults_.blur_px);
  const double diagonal_px = std::hypot(lens_.width_px, lens_.height_px) / 2;
  cv::RNG random(seed);
  cv::Mat1f noise(light.size());
  random.fill(noise, cv::RNG::NORMAL, 0, faults_.noise);
  for (int v = 0; v < light.rows; ++v) {
    for (int u = 0; u < light.cols; ++u) {
      const double part = std::hypot(u - lens_.cx, v - lens_.cy) / diagonal_px;
      light(v, u) =
          light(v, u) * static_cast<float>(1 - faults_.vignetting * part * part) + noise(v, u);
    }
  }
  cv::Mat image;
  light.convertTo(image, CV_8U);
  return image;
}

std::vector<std::optional<cv::Point2d>> BoardCamera::Corners(const BoardPose& pose) const {
  const cv::Matx33d R = RotationBy(pose.rotation);
  std::vector<std::optional<cv::Point2d>> corners;
  for (int id = 0; id < board_.CornerCount(); ++id) {
    const cv::Vec3d p = R * cv::Vec3d(board_.Corner(id)) + pose.translation;
    const auto pixel = lens_.Project({p[0], p[1], p[2]});
    corners.push_back(pixel ? std::optional(cv::Point2d(pixel->x(), pixel->y())) : std::nullopt);
  }
  return corners;
}

bool BoardCamera::Shows(const BoardPose& pose) const {
  const cv::Matx33d R = RotationBy(pose.rotation);
  constexpr int kSteps = 24;
  for (int i = 0; i <= kSteps; ++i) {
    for (const bool across : {false, true}) {
      for (const double side : {0.0, 1.0}) {
        const double along = static_cast<double>(i) / kSteps;
        const double x =
            -1 - kBorder + (across ? along : side) * (board_.columns + 1 + 2 * kBorder);
        const double y = -1 - kBorder + (across ? side : along) * (board_.rows + 1 + 2 * kBorder);
        const cv::Vec3d p =
            R * cv::Vec3d(x * board_.square_m, y * board_.square_m, 0) + pose.translation;
        const auto pixel = lens_.Project({p[0], p[1], p[2]});
        constexpr double kMarginPx = 2;
        if (!pixel || pixel->minCoeff() < kMarginPx ||
            pixel->x() > lens_.width_px - 1 - kMarginPx ||
            pixel->y() > lens_.height_px - 1 - kMarginPx) {
          return false;
        }
      }
    }
  }
  return true;
}

std::vector<BoardPose> BoardCamera::Poses(int count) const {
  constexpr double kGoldenRatio = 0.618034;
  const double diagonal = std::atan2(lens_.height_px, lens_.width_px);
  std::vector<BoardPose> poses;
  for (int i = 0; i < count; ++i) {
    const int kind = i % 3;  // 0: in the middle, 1: at the rim, 2: small, in a corner
    const cv::Vec3d tilts(0.6 * std::sin(2.4 * i), 0.6 * std::cos(1.7 * i), 0.5 * pi * (i % 4));
    const double azimuth = kind == 2 ? (i / 3 % 2 == 0 ? diagonal : -diagonal) + pi * (i / 6 % 2)
                                     : 2 * pi * kGoldenRatio * i;
    double distance_m = 0.7 * (board_.columns + 1) * board_.square_m;
    const auto at = [&](double angle) {
      return FacingPose(board_, distance_m * Direction(angle, azimuth), tilts);
    };
    while (!Shows(at(0))) distance_m *= 1.1;
    if (kind > 0) distance_m *= kind == 1 ? 1.3 : 2;
    double inside = 0;
    double outside = lens_.ValidAngle();
    for (int k = 0; k < 30; ++k) {
      const double angle = (inside + outside) / 2;
      (Shows(at(angle)) ? inside : outside) = angle;
    }
    poses.push_back(at(kind > 0 ? inside : 0.5 * inside));
  }
  return poses;
}

Lens WideLens(LensModel model,
              cv::Size size,
              const std::vector<double>& coefficients,
              double half_diagonal_rad) {
  Lens lens = Lens::WithoutDistortion(model, size, 1);
  std::copy(coefficients.begin(), coefficients.end(), lens.distortion.begin());
  lens.fx = std::hypot(size.width, size.height) / 2 / lens.Radius(half_diagonal_rad);
  lens.fy = 1.002 * lens.fx;
  lens.cx += 2;
  lens.cy -= 3;
  return lens;
}

std::vector<NamedLens> WideLenses(cv::Size size) {
  std::vector<NamedLens> lenses;
  const std::string end = " " + std::to_string(size.width) + "x" + std::to_string(size.height);
  for (const int degrees : {120, 150, 180}) {
    lenses.push_back(
        {"equidistant " + std::to_string(degrees) + end,
         WideLens(LensModel::kEquidistant, size, {-0.02, 0.005, -0.001, 0}, degrees * pi / 360)});
  }
  for (const int degrees : {90, 120, 150}) {
    lenses.push_back({"rational " + std::to_string(degrees) + end,
                      WideLens(LensModel::kRational,
                               size,
                               {0.27, 0.002, 0.0004, -0.0003, 0, 0.62, 0.02, 0},
                               degrees * pi / 360)});
  }
  return lenses;
}

void CornerErrors::Add(const BoardView& view,
                       const std::vector<std::optional<cv::Point2d>>& truth,
                       cv::Size size) {
  const auto of = [&](std::size_t i, bool reversed) {
    const auto id = static_cast<std::size_t>(view.ids[i]);
    const auto& exact = truth[reversed ? truth.size() - 1 - id : id];
    return view.corners_px[i] - exact.value_or(cv::Point2d(-1e3, -1e3));
  };
  const bool reversed = cv::norm(of(0, true)) < cv::norm(of(0, false));
  const cv::Point2d middle((size.width - 1) / 2.0, (size.height - 1) / 2.0);
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const double part = cv::norm(view.corners_px[i] - middle) / cv::norm(middle);
    const int ring = std::min(kRings - 1, static_cast<int>(kRings * part));
    Ring& sum = rings[static_cast<std::size_t>(ring)];
    const double error = cv::norm(of(i, reversed));
    sum.squares_px2 += error * error;
    sum.largest_px = std::max(sum.largest_px, error);
    ++sum.count;
  }
  missed += static_cast<int>(truth.size() - view.ids.size());
}

double CornerErrors::Rms() const {
  double squares = 0;
  double count = 0;
  for (const Ring& ring : rings) {
    squares += ring.squares_px2;
    count += ring.count;
  }
  return std::sqrt(squares / count);
}

LensError CompareLenses(const Lens& calibrated, const Lens& truth) {
  constexpr int kStepPx = 8;
  constexpr double kNotShownPx = 10;
  LensError error;
  double squares = 0;
  int count = 0;
  for (int v = 0; v < truth.height_px; v += kStepPx) {
    for (int u = 0; u < truth.width_px; u += kStepPx) {
      const auto ray = truth.Ray({u, v});
      if (!ray) continue;
      const auto pixel = calibrated.Project(*ray);
      const double distance = pixel ? (*pixel - Eigen::Vector2d(u, v)).norm() : kNotShownPx;
      squares += distance * distance;
      error.largest_px = std::max(error.largest_px, distance);
      ++count;
    }
  }
  error.rms_px = std::sqrt(squares / count);
  return error;
}

}  // namespace ceilmap::calibration
