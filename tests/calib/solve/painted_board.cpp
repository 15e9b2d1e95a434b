#include "tests/calib/solve/painted_board.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/solve/board_drawing.hpp"

namespace ceilmap::calibration {
namespace {

constexpr double kSheetPxPerMm = 4;
constexpr int kParts = 4;  // of a pixel, in each direction

cv::Mat1f Draw(const BoardDrawing& drawing) {
  cv::Mat sheet(cvRound(drawing.height_mm * kSheetPxPerMm),
                cvRound(drawing.width_mm * kSheetPxPerMm),
                CV_8U,
                cv::Scalar(255));
  for (const BoardDrawing::Rectangle& r : drawing.rectangles) {
    const cv::Rect pixels(
        cv::Point(cvRound(r.x_mm * kSheetPxPerMm), cvRound(r.y_mm * kSheetPxPerMm)),
        cv::Point(cvRound((r.x_mm + r.width_mm) * kSheetPxPerMm),
                  cvRound((r.y_mm + r.height_mm) * kSheetPxPerMm)));
    sheet(pixels).setTo(r.white ? 255 : 0);
  }
  cv::Mat1f result;
  sheet.convertTo(result, CV_32F);
  return result;
}

cv::Matx33d RotationOf(const BoardPose& pose) {
  cv::Matx33d R;
  cv::Rodrigues(pose.rotation, R);
  return R;
}

cv::Vec3d RayOf(const Lens& lens, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = lens.Ray(pixel).value();
  return {ray.x(), ray.y(), ray.z()};
}

}  // namespace

BoardPainter::BoardPainter(const Board& board, const Lens& lens) : board_(board), lens_(lens) {
  const BoardDrawing drawing = DrawBoard(board, ParsePaper("a3"));
  sheet_ = Draw(drawing);
  const BoardDrawing::Rectangle& r = drawing.rectangles.front();  // in the upper row
  const double square_mm = 1e3 * board.square_m;
  const double left_mm = (drawing.width_mm - square_mm * (board.columns + 1)) / 2;
  first_corner_px_ = {(left_mm + square_mm) * kSheetPxPerMm, (r.y_mm + square_mm) * kSheetPxPerMm};
  for (int v = 0; v < lens.Size().height * kParts; ++v) {
    for (int u = 0; u < lens.Size().width * kParts; ++u) {
      rays_.push_back(RayOf(lens, {(u + 0.5) / kParts - 0.5, (v + 0.5) / kParts - 0.5}));
    }
  }
}

cv::Mat BoardPainter::Paint(const BoardPose& pose) const {
  const cv::Matx33d R = RotationOf(pose);
  const cv::Vec3d normal(R(0, 2), R(1, 2), R(2, 2));
  const double distance = normal.dot(pose.translation);
  cv::Mat1f fine(lens_.Size().height * kParts, lens_.Size().width * kParts);
  std::size_t i = 0;
  for (float& value : fine) {
    const cv::Vec3d& direction = rays_[i++];
    const double depth = distance / normal.dot(direction);
    const cv::Vec3d p = R.t() * (depth * direction - pose.translation);
    const double x = first_corner_px_.x + 1e3 * p[0] * kSheetPxPerMm;
    const double y = first_corner_px_.y + 1e3 * p[1] * kSheetPxPerMm;
    const bool on_sheet = depth > 0 && x >= 0 && y >= 0 && x < sheet_.cols && y < sheet_.rows;
    value =
        on_sheet
            ? 40 + 0.7F * sheet_(static_cast<int>(y), static_cast<int>(x))
            : 60 + 20 * static_cast<float>(std::sin(3 * direction[0]) * std::cos(4 * direction[1]));
  }
  cv::Mat small;
  cv::resize(fine, small, lens_.Size(), 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(small, small, {}, 0.6);  // a lens's
  cv::Mat image;
  small.convertTo(image, CV_8U);
  return image;
}

std::vector<cv::Point2d> BoardPainter::Corners(const BoardPose& pose) const {
  std::vector<cv::Point3d> points;
  for (int id = 0; id < board_.CornerCount(); ++id) points.push_back(board_.Corner(id));
  return Project(lens_, pose, points);
}

BoardPose PoseAt(const Board& board,
                 const Lens& lens,
                 cv::Point2d at,
                 double across_rad,
                 double along_rad,
                 double turn_rad,
                 double width_ratio) {
  cv::Matx33d across;
  cv::Matx33d along;
  cv::Matx33d turn;
  cv::Rodrigues(cv::Vec3d(across_rad, 0, 0), across);
  cv::Rodrigues(cv::Vec3d(0, along_rad, 0), along);
  cv::Rodrigues(cv::Vec3d(0, 0, turn_rad), turn);
  const cv::Matx33d R = turn * across * along;
  BoardPose pose;
  cv::Rodrigues(R, pose.rotation);
  const double width_m = (board.columns + 1) * board.square_m;
  const double depth_m = lens.fx * width_m / (width_ratio * lens.Size().width);
  const cv::Vec3d ray = RayOf(lens, {at.x * lens.Size().width, at.y * lens.Size().height});
  const cv::Vec3d centre(
      (board.columns - 1) * board.square_m / 2, (board.rows - 1) * board.square_m / 2, 0);
  pose.translation = depth_m / ray[2] * ray - R * centre;
  return pose;
}

Board TestBoard() {
  Board board;
  board.square_m = 0.025;
  return board;
}

std::vector<BoardPose> GoodPoses(const Board& board, const Lens& lens) {
  const auto at = [&](double x, double y, double across, double along, double turn, double part) {
    return PoseAt(board, lens, {x, y}, across, along, turn, part);
  };
  return {at(0.50, 0.50, 0.0, 0.0, 0.0, 0.75),
          at(0.50, 0.50, 0.6, 0.0, 0.1, 0.70),
          at(0.50, 0.50, -0.6, 0.0, -0.1, 0.70),
          at(0.50, 0.50, 0.0, 0.6, 0.0, 0.80),
          at(0.50, 0.50, 0.0, -0.6, 0.2, 0.80),
          at(0.28, 0.30, 0.3, 0.4, 0.0, 0.50),
          at(0.72, 0.30, 0.3, -0.4, 0.1, 0.50),
          at(0.28, 0.70, -0.4, 0.3, 0.0, 0.50),
          at(0.72, 0.70, -0.4, -0.3, -0.2, 0.50),
          at(0.45, 0.55, 0.5, 0.3, 1.5, 0.50),
          at(0.55, 0.45, -0.5, -0.3, 1.6, 0.50),
          at(0.27, 0.50, 0.0, 0.5, 0.3, 0.50),
          at(0.73, 0.50, 0.0, -0.5, -0.3, 0.50),
          at(0.50, 0.30, 0.5, 0.0, 3.1, 0.50),
          at(0.50, 0.70, -0.5, 0.0, 0.0, 0.50)};
}

Lens TestLens() {
  return {480, 360, 380, 381, 243, 176, {-0.25, 0.06}};
}

}  // namespace ceilmap::calibration
