#include "mapping/heights/stereo.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
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
constexpr float kMinSigma = 0.004F;
// A height that only one of several partners shows is not used; one of a single partner is less
// certain.
constexpr float kAloneSigma = 0.02F;
// Of what shows nothing itself, and has the height of what is around it, and of the borders of
// saturated areas, which lie where the exposure puts them.
constexpr float kFilledSigma = 0.9F * kMeasuredSigma;

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

// Marks saturated pixels of what ForStereo returns.
constexpr int kSaturated = 255;

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
  cv::min(result, kSaturated - 1, result);
  constexpr int kSaturatedGrey = 250;
  result.setTo(kSaturated, grey >= kSaturatedGrey);
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

constexpr int kRefineBox = 7;    // pixels that determine a disparity
constexpr int kSixteenths = 16;  // of a pixel, the unit of semi-global matching

/// Disparities of pixels and their standard deviations, CV_32FC1.
struct Disparities {
  cv::Mat pixels;
  cv::Mat sigma;
};

/// Disparities by least squares of the grey levels around each pixel (Lucas and Kanade, 1981, along
/// the rows). Those of semi-global matching are drawn towards whole pixels, because their cost
/// compares samples (Birchfield and Tomasi, 1998): by 0.1 to 0.5 px, which made maps 0.2 to 0.4 %
/// too long.
/// @param found  CV_8UC1, not 0 where there is a disparity.
Disparities Refine(const cv::Mat& left,
                   const cv::Mat& right,
                   const cv::Mat& disparities,
                   const cv::Mat& found) {
  constexpr int kRounds = 2;
  constexpr double kMaxOff = 0.6;
  // Variances of what ForStereo returns: of a gradient that is noise alone, of the least noise.
  constexpr double kFlat = 4;
  constexpr double kRounding = 1;
  constexpr double kNoSignal = 0.01;
  cv::Mat columns(left.size(), CV_32F);
  cv::Mat rows(left.size(), CV_32F);
  for (int v = 0; v < left.rows; ++v) {
    for (int u = 0; u < left.cols; ++u) {
      columns.at<float>(v, u) = static_cast<float>(u);
      rows.at<float>(v, u) = static_cast<float>(v);
    }
  }
  cv::Mat known;
  found.convertTo(known, CV_32F, 1.0 / 255);
  const auto mean = [](const cv::Mat& values) {
    cv::Mat result;
    cv::boxFilter(values, result, CV_32F, {kRefineBox, kRefineBox});
    return result;
  };
  Disparities result{disparities.clone(), {}};
  cv::Mat seen;
  cv::Mat sum;
  cv::Mat difference;
  cv::Mat gradient;  // of the mean of both
  cv::Mat squares;
  for (int round = 0; round < kRounds; ++round) {
    cv::remap(right, seen, columns - result.pixels, rows, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    cv::add(left, seen, sum, {}, CV_32F);
    cv::subtract(left, seen, difference, {}, CV_32F);
    cv::Sobel(sum, gradient, CV_32F, 1, 0, 1, 0.25);
    const cv::Mat counted = known.mul(gradient);
    squares = mean(counted.mul(gradient)) + kFlat;
    const cv::Mat step = -mean(counted.mul(difference)) / squares;
    result.pixels += step;
    // Further away it would be something else.
    cv::min(result.pixels, disparities + kMaxOff, result.pixels);
    cv::max(result.pixels, disparities - kMaxOff, result.pixels);
  }
  // The noise of both images has a gradient too, whose variance is an eighth of the difference's.
  const cv::Mat noise = mean(known.mul(difference).mul(difference)) + kRounding;
  cv::sqrt(noise / cv::max(squares - kFlat - noise / 8, kNoSignal), result.sigma);
  result.sigma /= kRefineBox;
  return result;
}

/// The image with columns before it.
cv::Mat WithMargin(const cv::Mat& image, int columns) {
  cv::Mat wide;
  cv::copyMakeBorder(image, wide, 0, 0, columns, 0, cv::BORDER_REPLICATE);
  return wide;
}

/// 255 where a disparity was found that does not lead out of the image. @param sixteenths  CV_16S
cv::Mat IsInside(const cv::Mat& sixteenths, int least) {
  cv::Mat inside(sixteenths.size(), CV_8UC1);
  for (int v = 0; v < inside.rows; ++v) {
    for (int u = 0; u < inside.cols; ++u) {
      const int disparity = sixteenths.at<short>(v, u);
      const bool is = disparity >= kSixteenths * least && disparity <= kSixteenths * u;
      inside.at<uchar>(v, u) = is ? 255 : 0;
    }
  }
  return inside;
}

/// rho of the reference's reduced pixels by one partner, and its standard deviation: CV_32FC2; 0:
/// not found.
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
  // The matcher leaves out columns that do not show the largest disparity. Near things, as walls,
  // make those many; each added column takes time.
  const int margin = std::max(0, least + count - size.width / 3);
  cv::Mat sixteenths;
  matcher->compute(WithMargin(left, margin), WithMargin(right, margin), sixteenths);
  sixteenths = sixteenths.colRange(margin, sixteenths.cols);
  const cv::Mat found = IsInside(sixteenths, least);
  cv::Mat disparities;
  sixteenths.convertTo(disparities, CV_32F, 1.0 / kSixteenths);
  Disparities refined = Refine(left, right, disparities, found);
  cv::Mat saturated = left == kSaturated;
  cv::dilate(saturated, saturated, cv::Mat::ones(kRefineBox, kRefineBox, CV_8U));
  refined.sigma.setTo(kFilledSigma * baseline, saturated);
  cv::Mat ratios;
  cv::merge(std::vector<cv::Mat>{refined.pixels / baseline, refined.sigma / baseline}, ratios);
  ratios.setTo(cv::Scalar::all(0), ~found);
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

/// Weighted mean of the estimates of one point on which most agree; kUnknown: none.
/// @param values  sorted here.
HeightCell Agreed(std::vector<HeightCell>& values, std::size_t needed) {
  std::sort(values.begin(), values.end(), [](const HeightCell& a, const HeightCell& b) {
    return a.rho < b.rho;
  });
  std::size_t best = 0;
  std::size_t best_count = 0;
  std::size_t end = 0;
  for (std::size_t first = 0; first < values.size(); ++first) {
    while (end < values.size() && values[end].rho <= (1 + kAgree) * values[first].rho) ++end;
    if (end - first <= best_count) continue;
    best = first;
    best_count = end - first;
  }
  if (best_count < needed) return kUnknown;
  float sum = 0;
  float weights = 0;
  for (std::size_t i = best; i < best + best_count; ++i) {
    const float weight = 1 / (values[i].sigma * values[i].sigma);
    sum += weight * values[i].rho;
    weights += weight;
  }
  return {sum / weights, 1 / std::sqrt(weights)};
}

/// One map of ratios of those by all partners.
cv::Mat Merge(const std::vector<cv::Mat>& by_partner) {
  if (by_partner.size() == 1) return by_partner.front();
  cv::Mat merged(by_partner.front().size(), CV_32FC2);
  std::vector<HeightCell> values;
  for (int v = 0; v < merged.rows; ++v) {
    for (int u = 0; u < merged.cols; ++u) {
      values.clear();
      for (const cv::Mat& ratios : by_partner) {
        const auto& seen = ratios.at<cv::Vec2f>(v, u);
        if (seen[0] > 0) values.push_back({seen[0], seen[1]});
      }
      const HeightCell agreed = Agreed(values, 2);
      merged.at<cv::Vec2f>(v, u) = {agreed.sigma < kUnknown.sigma ? agreed.rho : 0.F, agreed.sigma};
    }
  }
  return merged;
}

/// Cells from the pixels around their centres. Where there is nothing, kUnknown.
void FillCells(const cv::Mat& ratios, float common_sigma, HeightField& field) {
  constexpr std::size_t kEnough = kCellPixels * kCellPixels / 2;
  std::vector<float> values;
  std::vector<float> sigmas;
  for (int row = 0; row < field.grid.height; ++row) {
    for (int col = 0; col < field.grid.width; ++col) {
      values.clear();
      sigmas.clear();
      for (int v = row * kCellPixels; v < (row + 1) * kCellPixels; ++v) {
        for (int u = col * kCellPixels; u < (col + 1) * kCellPixels; ++u) {
          const auto& seen = ratios.at<cv::Vec2f>(v, u);
          if (!(seen[0] > 0)) continue;
          values.push_back(seen[0]);
          sigmas.push_back(seen[1]);
        }
      }
      if (values.size() < kEnough) continue;
      std::sort(values.begin(), values.end());
      std::sort(sigmas.begin(), sigmas.end());
      const float middle = values[values.size() / 2];
      const float spread =
          values[values.size() - 1 - values.size() / 6] - values[values.size() / 6];
      const float pixels = std::min(kFilledSigma, sigmas[sigmas.size() / 2]);
      const float sigma = std::hypot(common_sigma, pixels, 0.5F * spread);
      const auto cell = static_cast<std::size_t>(row) * static_cast<std::size_t>(field.grid.width) +
                        static_cast<std::size_t>(col);
      field.cells[cell] = {middle, std::max(kMinSigma, sigma)};
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
  by_partner.reserve(partners.size());
  for (const StereoPartner& partner : partners) {
    by_partner.push_back(MatchPair(reference.image, partner, principal, range));
  }
  cv::Mat ratios = Merge(by_partner);
  if (!reference.mask.empty()) ratios.setTo(cv::Scalar::all(0), Reduced(reference.mask) < 255);

  HeightField field;
  field.grid = size / kCellPixels;
  field.first_px = Eigen::Vector2d::Constant(0.5 * (kStereoStepPx - 1)) -
                   0.5 * Eigen::Vector2d(reference.size.width - 1, reference.size.height - 1);
  field.step_px = Eigen::Vector2d::Constant(kStereoStepPx);
  field.cells.assign(static_cast<std::size_t>(field.grid.area()), kUnknown);
  field.scale_sigma = known.scale_sigma;
  FillCells(ratios, partners.size() == 1 ? kAloneSigma : 0.F, field);
  return field;
}

}  // namespace ceilmap::heights
