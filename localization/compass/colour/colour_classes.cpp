#include "localization/compass/colour/colour_classes.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/ml.hpp>
#include <unordered_set>
#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap::colour {
namespace {

// Number of samples clustered, evenly chosen from those given, > 0.
constexpr int kMaxSamples = 40000;

constexpr int kSteps = 64;           // per channel in the table
constexpr int kStep = 256 / kSteps;  // grey levels
constexpr float kMinVariance = 4;    // of a class in each channel: noise of any camera

/// Y, U and V of evenly chosen samples, one row each.
cv::Mat ToYuv(const cv::Mat& bgr, int most) {
  const cv::Mat line = bgr.isContinuous() ? bgr.reshape(3, 1) : bgr.clone().reshape(3, 1);
  const int step = std::max(1, (line.cols + most - 1) / most);
  cv::Mat chosen(1, (line.cols + step - 1) / step, CV_8UC3);
  for (int i = 0; i < chosen.cols; ++i) {
    chosen.at<cv::Vec3b>(i) = line.at<cv::Vec3b>(i * step);
  }
  cv::Mat yuv;
  cv::cvtColor(chosen, yuv, cv::COLOR_BGR2YUV);
  cv::Mat samples;
  yuv.reshape(1, chosen.cols).convertTo(samples, CV_32F);
  return samples;
}

void RequireColours(const cv::Mat& samples, int classes) {
  std::unordered_set<int> different;
  double chroma = 0;
  for (int i = 0; i < samples.rows; ++i) {
    const auto* yuv = samples.ptr<float>(i);
    different.insert(static_cast<int>(yuv[0]) << 16 | static_cast<int>(yuv[1]) << 8 |
                     static_cast<int>(yuv[2]));
    constexpr float kGrey = 128;
    chroma += std::abs(yuv[1] - kGrey) + std::abs(yuv[2] - kGrey);
  }
  if (different.size() < static_cast<std::size_t>(classes)) {
    throw InputError(
        fmt::format("the images show {} different colours, must be at least {}; is the lens "
                    "covered, or the light off?",
                    different.size(),
                    classes));
  }
  constexpr double kNoChroma = 2;  // grey levels
  if (chroma < kNoChroma * samples.rows) {
    throw InputError(
        "the images are grey, and this compass needs colours; give a colour "
        "camera");
  }
}

/// Equal colours get equal class numbers, independent of the initialization of the clustering.
void SortByBrightness(std::vector<ColourClass>& classes) {
  std::sort(classes.begin(), classes.end(), [](const ColourClass& a, const ColourClass& b) {
    return a.mean < b.mean;
  });
}

std::vector<ColourClass> ByKMeans(const cv::Mat& samples, const ColourClassParams& params) {
  cv::theRNG().state = params.seed;
  cv::Mat labels;
  cv::Mat centres;
  const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 0.2);
  constexpr int kAttempts = 3;
  cv::kmeans(samples, params.classes, labels, until, kAttempts, cv::KMEANS_PP_CENTERS, centres);
  std::vector<ColourClass> classes(static_cast<std::size_t>(params.classes));
  for (int i = 0; i < params.classes; ++i) {
    ColourClass& one = classes[static_cast<std::size_t>(i)];
    std::copy_n(centres.ptr<float>(i), 3, one.mean.begin());
    one.weight = std::max(
        1e-6F,
        static_cast<float>(cv::countNonZero(labels == i)) / static_cast<float>(samples.rows));
  }
  return classes;
}

std::vector<ColourClass> ByMixture(const cv::Mat& samples, const ColourClassParams& params) {
  // EM is initialized with the classes of k-means; other initial values often converge to poor
  // solutions.
  const std::vector<ColourClass> first = ByKMeans(samples, params);
  cv::Mat means(params.classes, 3, CV_64F);
  for (int i = 0; i < params.classes; ++i) {
    for (int j = 0; j < 3; ++j) {
      means.at<double>(i, j) =
          double{first[static_cast<std::size_t>(i)].mean[static_cast<std::size_t>(j)]};
    }
  }
  const cv::Ptr<cv::ml::EM> mixture = cv::ml::EM::create();
  mixture->setClustersNumber(params.classes);
  mixture->setCovarianceMatrixType(cv::ml::EM::COV_MAT_GENERIC);
  mixture->setTermCriteria({cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 1e-3});
  mixture->trainE(samples, means);
  std::vector<cv::Mat> covariances;
  mixture->getCovs(covariances);
  const cv::Mat found = mixture->getMeans();
  const cv::Mat weights = mixture->getWeights();
  std::vector<ColourClass> classes(static_cast<std::size_t>(params.classes));
  for (int i = 0; i < params.classes; ++i) {
    ColourClass& one = classes[static_cast<std::size_t>(i)];
    one.weight = std::max(1e-6F, static_cast<float>(weights.at<double>(i)));
    for (int j = 0; j < 3; ++j) {
      const auto row = static_cast<std::size_t>(j);
      one.mean[row] = static_cast<float>(found.at<double>(i, j));
      for (int l = 0; l < 3; ++l) {
        one.covariance[3 * row + static_cast<std::size_t>(l)] =
            static_cast<float>(covariances[static_cast<std::size_t>(i)].at<double>(j, l)) +
            (j == l ? kMinVariance : 0);
      }
    }
  }
  return classes;
}

/// Distance of a colour from a class: -2 log of its likelihood, weighted with the class, up to a
/// constant.
class Distance {
 public:
  explicit Distance(const ColourClass& one) : mean_(one.mean[0], one.mean[1], one.mean[2]) {
    Eigen::Matrix3f covariance;
    for (int i = 0; i < 9; ++i)
      covariance(i / 3, i % 3) = one.covariance[static_cast<std::size_t>(i)];
    const float determinant = covariance.determinant();
    if (!covariance.allFinite() || !mean_.allFinite() || !(determinant > 0) ||
        !(one.weight > 0 && one.weight <= 1)) {
      throw InputError("a colour class has numbers that cannot be");
    }
    if (covariance.isIdentity()) return;  // k-means: the weights of classes are not used
    inverse_ = covariance.inverse();
    reach_ = kSigmas * kSigmas;
    offset_ = std::log(determinant) - 2 * std::log(one.weight);
  }
  float operator()(const Eigen::Vector3f& yuv) const { return Away(yuv) + offset_; }
  /// Whether the colour is similar to those of the class.
  [[nodiscard]] bool Reaches(const Eigen::Vector3f& yuv) const { return Away(yuv) <= reach_; }
  /// @param nearest  Mean of the class that is nearest to this one.
  void SetReach(const Eigen::Vector3f& nearest) {
    constexpr float kPart = 0.5F;
    reach_ = std::max(reach_, kPart * kPart * Away(nearest));
  }
  [[nodiscard]] const Eigen::Vector3f& Mean() const { return mean_; }

 private:
  static constexpr float kLevels = 40;
  static constexpr float kSigmas = 5;

  [[nodiscard]] float Away(const Eigen::Vector3f& yuv) const {
    const Eigen::Vector3f off = yuv - mean_;
    return off.dot(inverse_ * off);
  }

  Eigen::Vector3f mean_;
  Eigen::Matrix3f inverse_ = Eigen::Matrix3f::Identity();
  float offset_ = 0;
  float reach_ = kLevels * kLevels;
};

std::vector<Distance> DistancesOf(const std::vector<ColourClass>& classes) {
  std::vector<Distance> distances;
  distances.reserve(classes.size());
  for (const ColourClass& one : classes) distances.emplace_back(one);
  for (Distance& one : distances) {
    float least = std::numeric_limits<float>::infinity();
    Eigen::Vector3f nearest = one.Mean();
    for (const Distance& other : distances) {
      const float away = (other.Mean() - one.Mean()).squaredNorm();
      if (&other == &one || away >= least) continue;
      least = away;
      nearest = other.Mean();
    }
    one.SetReach(nearest);
  }
  return distances;
}

}  // namespace

void ColourClassParams::Validate() const {
  if (classes < 2 || classes > kMaxClasses) {
    throw InputError(fmt::format("classes = {}, must be 2 to {}", classes, kMaxClasses));
  }
}

ColourClasses::ColourClasses(std::vector<ColourClass> classes)
    : classes_(std::move(classes)), table_(std::size_t{kSteps} * kSteps * kSteps) {
  if (classes_.size() < 2 || classes_.size() > kMaxClasses) {
    throw InputError(
        fmt::format("{} colour classes, must be 2 to {}", classes_.size(), kMaxClasses));
  }
  const std::vector<Distance> distances = DistancesOf(classes_);
  cv::Mat colours(1, static_cast<int>(table_.size()), CV_8UC3);
  for (int i = 0; i < colours.cols; ++i) {
    const auto level = [](int step) { return cv::saturate_cast<uchar>(step * kStep + kStep / 2); };
    colours.at<cv::Vec3b>(i) = {level(i >> 12), level(i >> 6 & 63), level(i & 63)};
  }
  cv::cvtColor(colours, colours, cv::COLOR_BGR2YUV);
  for (int i = 0; i < colours.cols; ++i) {
    const cv::Vec3b& yuv = colours.at<cv::Vec3b>(i);
    const Eigen::Vector3f colour(yuv[0], yuv[1], yuv[2]);
    float least = std::numeric_limits<float>::infinity();
    std::size_t nearest = 0;
    for (std::size_t c = 0; c < distances.size(); ++c) {
      const float distance = distances[c](colour);
      if (distance >= least) continue;
      least = distance;
      nearest = c;
    }
    table_[static_cast<std::size_t>(i)] =
        distances[nearest].Reaches(colour) ? static_cast<std::uint8_t>(nearest) : kNoClass;
  }
}

ColourClasses ColourClasses::Learn(const cv::Mat& bgr, const ColourClassParams& params) {
  params.Validate();
  const cv::Mat samples = ToYuv(bgr, kMaxSamples);
  RequireColours(samples, params.classes);
  std::vector<ColourClass> classes = params.clustering == Clustering::kMixture
                                         ? ByMixture(samples, params)
                                         : ByKMeans(samples, params);
  SortByBrightness(classes);
  return ColourClasses(std::move(classes));
}

}  // namespace ceilmap::colour
