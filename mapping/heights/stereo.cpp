#include "mapping/heights/stereo.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace ceilmap::heights {
namespace {

constexpr int kReduction = 2;  // of the images
static_assert(static_cast<int>(kStereoStepPx) % kReduction == 0);
constexpr int kCellPixels = static_cast<int>(kStereoStepPx) / kReduction;

// Range of rho that is searched, beyond that of the known heights.
constexpr float kMargin = 0.06F;
constexpr float kFarthest = 0.7F;
constexpr float kNearest = 3.0F;

// Estimates of one point by several partners agree within this part of rho.
constexpr float kAgree = 0.02F;
constexpr double kDisparitySigmaPx = 0.25;  // reduced pixels
constexpr float kMinSigma = 0.004F;
// A height that only one of several partners shows is not used; one of a single partner is less
// certain.
constexpr float kAloneSigma = 0.02F;

struct Range {
  float low = 0.97F;
  float high = 1.3F;
};

Range RangeOf(const HeightField& known) {
  std::vector<float> rho;
  for (const HeightCell& cell : known.cells) {
    if (cell.sigma < kMeasuredSigma) rho.push_back(cell.rho);
  }
  if (rho.empty()) return {};
  std::sort(rho.begin(), rho.end());
  const auto at = [&](double part) {
    return rho[static_cast<std::size_t>(part * static_cast<double>(rho.size() - 1))];
  };
  constexpr double kOutliers = 0.01;
  return {std::clamp(at(kOutliers) - kMargin, kFarthest, 1 - kMargin),
          std::clamp(at(1 - kOutliers) + kMargin, 1 + kMargin, kNearest)};
}

cv::Mat Reduced(const cv::Mat& grey) {
  cv::Mat small;
  cv::resize(grey, small, grey.size() / kReduction, 0, 0, cv::INTER_AREA);
  return small;
}

/// The local mean becomes 128: exposure and vignetting differ from image to image, and weak texture
/// has few grey levels.
cv::Mat Normalized(const cv::Mat& grey) {
  constexpr int kBox = 41;
  constexpr double kGain = 3;
  cv::Mat mean;
  cv::boxFilter(grey, mean, CV_32F, {kBox, kBox});
  cv::Mat detail;
  cv::subtract(grey, mean, detail, {}, CV_32F);
  cv::Mat result;
  detail.convertTo(result, CV_8U, kGain, 128);
  return result;
}

Eigen::Matrix2d Rotation(double angle) {
  return Eigen::Rotation2Dd(angle).toRotationMatrix();
}

/// Rotation about the principal point, to the middle of an image of another size.
cv::Matx23d Turn(const Eigen::Matrix2d& R, const Eigen::Vector2d& principal, cv::Size to) {
  const Eigen::Vector2d middle(0.5 * (to.width - 1), 0.5 * (to.height - 1));
  const Eigen::Vector2d t = middle - R * principal;
  return {R(0, 0), R(0, 1), t.x(), R(1, 0), R(1, 1), t.y()};
}

cv::Mat Warp(const cv::Mat& image, const cv::Matx23d& turn, cv::Size size) {
  cv::Mat turned;
  cv::warpAffine(image, turned, turn, size, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return turned;
}

/// rho of the reference's reduced pixels by one partner, CV_32FC1; 0: not found.
/// @param principal  reduced pixel.
cv::Mat MatchPair(const cv::Mat& reference,
                  const StereoPartner& partner,
                  const Eigen::Vector2d& principal,
                  const Range& range) {
  const Eigen::Vector2d shift =
      Rotation(-partner.rotation_rad) * partner.shift_px / static_cast<double>(kReduction);
  const double baseline = shift.norm();
  // Both images are turned so that points move to smaller columns by rho times the baseline.
  const Eigen::Matrix2d to_left = Rotation(std::numbers::pi - std::atan2(shift.y(), shift.x()));
  const Eigen::Vector2d extent =
      to_left.cwiseAbs() * Eigen::Vector2d(reference.cols, reference.rows);
  const cv::Size size(static_cast<int>(extent.x()) + 2, static_cast<int>(extent.y()) + 2);
  const cv::Matx23d turn = Turn(to_left, principal, size);
  const cv::Mat left = Warp(reference, turn, size);
  const cv::Mat right =
      Warp(partner.image, Turn(to_left * Rotation(-partner.rotation_rad), principal, size), size);
  constexpr int kBlock = 5;
  constexpr int kSmall = 8 * kBlock * kBlock;  // penalties of the smoothness of disparities
  constexpr int kLarge = 32 * kBlock * kBlock;
  constexpr int kMaxDifference = 1;  // of the matches from left to right and back
  constexpr int kPreFilter = 63;
  constexpr int kUniqueness = 10;  // per cent
  constexpr int kSpecklePixels = 60;
  constexpr int kSixteenths = 16;
  const int least = static_cast<int>(std::floor(range.low * baseline));
  const int most = static_cast<int>(std::ceil(range.high * baseline));
  const int count = kSixteenths * ((most - least) / kSixteenths + 1);
  const auto matcher = cv::StereoSGBM::create(least,
                                              count,
                                              kBlock,
                                              kSmall,
                                              kLarge,
                                              kMaxDifference,
                                              kPreFilter,
                                              kUniqueness,
                                              kSpecklePixels,
                                              1,
                                              cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat disparities;  // sixteenths of a pixel
  matcher->compute(left, right, disparities);
  cv::Mat ratios;
  disparities.convertTo(ratios, CV_32F, 1 / (kSixteenths * baseline));
  ratios.setTo(0, disparities < kSixteenths * least);
  cv::Mat result;
  cv::warpAffine(ratios,
                 result,
                 turn,
                 reference.size(),
                 cv::INTER_NEAREST | cv::WARP_INVERSE_MAP,
                 cv::BORDER_CONSTANT,
                 cv::Scalar(0));
  return result;
}

/// The ratio on which most estimates of one point agree; 0: none. @param values  sorted here.
float Agreed(std::vector<float>& values, std::size_t needed) {
  std::sort(values.begin(), values.end());
  std::size_t best = 0;
  std::size_t best_count = 0;
  std::size_t end = 0;
  for (std::size_t first = 0; first < values.size(); ++first) {
    while (end < values.size() && values[end] <= (1 + kAgree) * values[first]) ++end;
    if (end - first <= best_count) continue;
    best = first;
    best_count = end - first;
  }
  return best_count >= needed ? values[best + best_count / 2] : 0;
}

/// One map of ratios of those by all partners, CV_32FC1; 0: not known.
cv::Mat Merge(const std::vector<cv::Mat>& by_partner) {
  if (by_partner.size() == 1) return by_partner.front();
  cv::Mat merged(by_partner.front().size(), CV_32FC1);
  std::vector<float> values;
  for (int v = 0; v < merged.rows; ++v) {
    for (int u = 0; u < merged.cols; ++u) {
      values.clear();
      for (const cv::Mat& ratios : by_partner) {
        if (ratios.at<float>(v, u) > 0) values.push_back(ratios.at<float>(v, u));
      }
      merged.at<float>(v, u) = Agreed(values, 2);
    }
  }
  return merged;
}

/// Cells from the pixels around their centres. Where there is nothing, kUnknown.
void FillCells(const cv::Mat& ratios, float pixel_sigma, HeightField& field) {
  constexpr std::size_t kEnough = kCellPixels * kCellPixels / 2;
  std::vector<float> values;
  for (int row = 0; row < field.grid.height; ++row) {
    for (int col = 0; col < field.grid.width; ++col) {
      values.clear();
      for (int v = row * kCellPixels; v < (row + 1) * kCellPixels; ++v) {
        for (int u = col * kCellPixels; u < (col + 1) * kCellPixels; ++u) {
          if (ratios.at<float>(v, u) > 0) values.push_back(ratios.at<float>(v, u));
        }
      }
      if (values.size() < kEnough) continue;
      std::sort(values.begin(), values.end());
      const float middle = values[values.size() / 2];
      const float spread =
          values[values.size() - 1 - values.size() / 6] - values[values.size() / 6];
      const auto cell = static_cast<std::size_t>(row) * static_cast<std::size_t>(field.grid.width) +
                        static_cast<std::size_t>(col);
      field.cells[cell] = {middle, std::max(kMinSigma, std::hypot(pixel_sigma, 0.5F * spread))};
    }
  }
}

}  // namespace

cv::Mat ForStereo(const cv::Mat& grey) {
  return Normalized(Reduced(grey));
}

HeightField MeasureByStereo(const StereoReference& reference,
                            const std::vector<StereoPartner>& partners,
                            const HeightField& known) {
  const cv::Size size = reference.image.size();
  const Eigen::Vector2d centre(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  const Eigen::Vector2d principal =
      centre + reference.principal_px / static_cast<double>(kReduction);
  const Range range = RangeOf(known);
  std::vector<cv::Mat> by_partner;
  double baselines = 0;
  for (const StereoPartner& partner : partners) {
    by_partner.push_back(MatchPair(reference.image, partner, principal, range));
    baselines += partner.shift_px.norm() / kReduction;
  }
  const double baseline = baselines / static_cast<double>(partners.size());
  cv::Mat ratios = Merge(by_partner);
  if (!reference.mask.empty()) ratios.setTo(0, Reduced(reference.mask) < 255);

  HeightField field;
  field.grid = size / kCellPixels;
  field.first_px = Eigen::Vector2d::Constant(0.5 * (kStereoStepPx - 1)) -
                   0.5 * Eigen::Vector2d(reference.size.width - 1, reference.size.height - 1);
  field.step_px = Eigen::Vector2d::Constant(kStereoStepPx);
  field.cells.assign(static_cast<std::size_t>(field.grid.area()), kUnknown);
  field.scale_sigma = known.scale_sigma;
  const auto sigma = static_cast<float>(kDisparitySigmaPx / baseline);
  FillCells(ratios, partners.size() == 1 ? std::hypot(sigma, kAloneSigma) : sigma, field);
  return field;
}

}  // namespace ceilmap::heights
