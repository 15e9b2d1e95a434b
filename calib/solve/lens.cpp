#include "calib/solve/lens.hpp"

#include <fmt/format.h>

#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/base/error.hpp"

namespace ceilmap::calibration {
namespace {

Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> AsEigen(
    const cv::Mat& matrix) {
  return {matrix.ptr<double>(), matrix.rows, matrix.cols};
}

}  // namespace

LensModel ParseLensModel(const std::string& text) {
  if (text == "plumb_bob") return LensModel::kPlumbBob;
  if (text == "rational") return LensModel::kRational;
  if (text == "equidistant") return LensModel::kEquidistant;
  throw InputError(fmt::format("model {}: must be plumb_bob, rational or equidistant", text));
}

std::string RosName(LensModel model) {
  switch (model) {
    case LensModel::kRational:
      return "rational_polynomial";
    case LensModel::kEquidistant:
      return "equidistant";
    default:
      return "plumb_bob";
  }
}

std::vector<std::string> CoefficientNames(LensModel model) {
  switch (model) {
    case LensModel::kRational:
      return {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
    case LensModel::kEquidistant:
      return {"k1", "k2", "k3", "k4"};
    default:
      return {"k1", "k2", "p1", "p2", "k3"};
  }
}

Lens Lens::WithoutDistortion(LensModel model, cv::Size size, double focal_px) {
  Lens lens{model, size, {}};
  const auto coefficients = static_cast<Eigen::Index>(CoefficientNames(model).size());
  lens.values = Eigen::VectorXd::Zero(kPinholeValues + coefficients);
  lens.values.head<kPinholeValues>() << focal_px, focal_px, (size.width - 1) / 2.0,
      (size.height - 1) / 2.0;
  return lens;
}

std::vector<cv::Point2d> Project(const Lens& lens,
                                 const BoardPose& pose,
                                 const std::vector<cv::Point3d>& points,
                                 Eigen::MatrixXd* by_lens,
                                 Eigen::MatrixXd* by_pose) {
  std::vector<cv::Point2d> pixels;
  cv::Mat jacobian;
  const bool fisheye = lens.model == LensModel::kEquidistant;
  const bool wanted = by_lens != nullptr || by_pose != nullptr;
  const cv::OutputArray derivatives =
      wanted ? cv::OutputArray(jacobian) : cv::OutputArray(cv::noArray());
  if (fisheye) {
    cv::fisheye::projectPoints(points,
                               pixels,
                               pose.rotation,
                               pose.translation,
                               lens.Matrix(),
                               lens.Coefficients(),
                               0,
                               derivatives);
  } else {
    cv::projectPoints(points,
                      pose.rotation,
                      pose.translation,
                      lens.Matrix(),
                      lens.Coefficients(),
                      pixels,
                      derivatives);
  }
  if (!wanted) return pixels;
  const auto all = AsEigen(jacobian);  // fisheye: lens, pose, skew; else: pose, lens
  const Eigen::Index lens_values = lens.values.size();
  if (by_lens != nullptr) *by_lens = all.middleCols(fisheye ? 0 : kPoseValues, lens_values);
  if (by_pose != nullptr) *by_pose = all.middleCols(fisheye ? lens_values : 0, kPoseValues);
  return pixels;
}

std::vector<cv::Point2d> Undistort(const Lens& lens, const std::vector<cv::Point2d>& pixels) {
  std::vector<cv::Point2d> plane;
  if (lens.model == LensModel::kEquidistant) {
    cv::fisheye::undistortPoints(pixels, plane, lens.Matrix(), lens.Coefficients());
  } else {
    const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-10);
    cv::undistortPoints(
        pixels, plane, lens.Matrix(), lens.Coefficients(), cv::noArray(), cv::noArray(), criteria);
  }
  return plane;
}

double Reach(const Lens& lens) {
  const std::vector<double> k = lens.Coefficients();
  // Radius in the image, of the tangent of the angle from the axis, or of the angle itself.
  const auto radius = [&](double from_axis) {
    const double s = from_axis * from_axis;
    if (lens.model == LensModel::kEquidistant) {
      return from_axis * (1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))));
    }
    const double above = 1 + s * (k[0] + s * (k[1] + s * k[4]));
    if (lens.model == LensModel::kPlumbBob) return from_axis * above;
    return from_axis * above / (1 + s * (k[5] + s * (k[6] + s * k[7])));
  };
  const double farthest = lens.model == LensModel::kEquidistant ? std::numbers::pi : 10;
  constexpr int kSteps = 4000;
  double reached = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double next = radius(farthest * i / kSteps);
    if (!(next > reached)) return reached;
    reached = next;
  }
  return reached;
}

std::array<double, 4> RectifiedPinhole(const Lens& lens) {
  cv::Mat K;
  if (lens.model == LensModel::kEquidistant) {
    cv::fisheye::estimateNewCameraMatrixForUndistortRectify(
        lens.Matrix(), lens.Coefficients(), lens.size, cv::Matx33d::eye(), K, 0);
  } else {
    K = cv::getOptimalNewCameraMatrix(lens.Matrix(), lens.Coefficients(), lens.size, 0);
  }
  return {K.at<double>(0, 0), K.at<double>(1, 1), K.at<double>(0, 2), K.at<double>(1, 2)};
}

cv::Mat Rectify(const Lens& lens, const cv::Mat& image) {
  const auto [fx, fy, cx, cy] = RectifiedPinhole(lens);
  const cv::Matx33d K(fx, 0, cx, 0, fy, cy, 0, 0, 1);
  cv::Mat x;
  cv::Mat y;
  if (lens.model == LensModel::kEquidistant) {
    cv::fisheye::initUndistortRectifyMap(
        lens.Matrix(), lens.Coefficients(), cv::Matx33d::eye(), K, lens.size, CV_32FC1, x, y);
  } else {
    cv::initUndistortRectifyMap(
        lens.Matrix(), lens.Coefficients(), cv::noArray(), K, lens.size, CV_32FC1, x, y);
  }
  cv::Mat rectified;
  cv::remap(image, rectified, x, y, cv::INTER_LINEAR);
  return rectified;
}

}  // namespace ceilmap::calibration
