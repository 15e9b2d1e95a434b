// Covariances of registrations compared with the truth, on random pairs of synthetic ceilings:
//   ceilmap_covariance_bench [motion|tilt|depth] [PAIRS [SEED]]
// motion (default): the motion of a level camera below a plane. tilt: that of a camera that tilts,
// against a level reference. depth: that of a level camera below several heights. PAIRS of each
// scene and condition (default 112: of motion 10,080 in all). For each the mean of e' C^-1 e / n (1
// for an honest covariance), and the share within the 95 % bound. Exits with 1 when a bound is
// exceeded.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/statistics.hpp"
#include "mapping/registration/registrar.hpp"
#include "tests/bench/consistency.hpp"
#include "tests/bench/deep_pairs.hpp"
#include "tests/bench/registration_pairs.hpp"
#include "tests/bench/tilted_pairs.hpp"
#include "tests/support/command_line.hpp"

namespace ceilmap::bench {
namespace {

using heights::HeightField;
using registration::PlaneFit;
using registration::PlaneMotion;
using registration::Registrar;
using registration::RegistrarParams;
using registration::Registration;

/// How many pairs, and from which seed.
struct Draw {
  int pairs = 112;
  std::uint32_t seed = 1;
};

template <typename Items>
std::vector<std::string> NamesOf(const Items& items) {
  std::vector<std::string> names;
  names.reserve(items.size());
  for (const auto& item : items) names.emplace_back(item.name);
  return names;
}

Consistency Check(const Registration& found, const ImagePair& pair, bool fits_scale) {
  constexpr double kWrongPx = 5;
  Consistency one;
  one.pairs = 1;
  if (!found.ok()) return one;
  const Eigen::Vector4d error = MotionError(found.motion, pair.motion);
  if (error.head<2>().norm() > kWrongPx) {
    one.wrong = 1;
    return one;
  }
  const int n = fits_scale ? 4 : 3;
  one = ConsistencyOf(error.head(n), found.covariance.topLeftCorner(n, n), {{0, 1}, {2}});
  one.error2 = error.head<2>().squaredNorm();
  return one;
}

Registration Register(Registrar& registrar, const ImagePair& pair, bool tracked) {
  const auto reference = registrar.Analyze(pair.reference);
  const auto current = registrar.Analyze(pair.current);
  if (!tracked) return registrar.Register(reference, current);
  registration::MotionPrior prior{pair.motion, 4, 0.02};
  prior.motion.tx_px += 2;
  prior.motion.ty_px -= 2;
  prior.motion.theta_rad += 0.005;
  return registrar.Register(reference, current, prior, registration::Effort::kTracking);
}

bool RunMotions(const Draw& draw) {
  const auto scenes = PairScenes();
  const auto conditions = PairConditions();
  ConsistencyTable table{NamesOf(scenes), NamesOf(conditions), {"shift", "yaw"}, "RMSE px", {}};
  // Without noise images are taken for encoded ones, whose errors are larger.
  table.may_be_low = [](const std::string& condition) { return condition.ends_with("noise 0"); };
  return RunTable(table, [&](std::size_t s, std::size_t c) {
    const PairCondition& condition = conditions[c];
    RegistrarParams params;
    params.estimate_scale = condition.fits_scale;
    Registrar registrar(condition.size, params);
    Consistency cell;
    for (int i = 0; i < draw.pairs; ++i) {
      const ImagePair pair =
          MakePair(scenes[s], condition, PairSeed(draw.seed, condition.name, scenes[s].name, i));
      cell.Add(Check(Register(registrar, pair, condition.tracked), pair, condition.fits_scale));
    }
    return cell;
  });
}

/// As accepted for a tilt of the robot.
bool IsSound(const PlaneFit& fit) {
  return fit.ok && fit.inliers >= 10 && fit.inliers >= 0.4 * fit.blocks && fit.sigma_px <= 0.4;
}

Consistency CheckTilt(const PlaneFit& fit, const TiltedPair& pair) {
  constexpr double kWrongRad = 3 * kRadPerDeg;
  Consistency one;
  one.pairs = 1;
  if (!IsSound(fit)) return one;
  const auto error = PlaneMotionError(fit.motion, pair.motion);
  if (error.tail<2>().norm() > kWrongRad) {
    one.wrong = 1;
    return one;
  }
  one = ConsistencyOf(error, fit.covariance, {{0, 1}, {2}, {3}, {4, 5}});
  one.error2 = error.tail<2>().squaredNorm() / (kRadPerDeg * kRadPerDeg);
  return one;
}

bool RunTilts(const Draw& draw) {
  const auto scenes = PairScenes();
  const auto conditions = TiltConditions();
  ConsistencyTable table{
      NamesOf(scenes), NamesOf(conditions), {"shift", "height", "yaw", "tilt"}, "tilt deg", {}};
  table.may_be_low = [](const std::string&) { return false; };
  return RunTable(table, [&](std::size_t s, std::size_t c) {
    const TiltCondition& condition = conditions[c];
    Registrar registrar(condition.size);
    Consistency cell;
    for (int i = 0; i < draw.pairs; ++i) {
      const TiltedPair pair = MakeTiltedPair(
          scenes[s], condition, PairSeed(draw.seed, condition.name, scenes[s].name, i));
      const auto reference = registrar.Analyze(pair.reference);
      const auto current = registrar.Analyze(pair.current);
      const auto effort =
          condition.tracked ? registration::Effort::kTracking : registration::Effort::kFull;
      cell.Add(CheckTilt(
          registrar.RefinePlane(reference, current, pair.camera, pair.start, {}, effort), pair));
    }
    return cell;
  });
}

/// Heights with the true scale. Which of the heights is the reference plane is a convention, and
/// its error is the same in all registrations with one reference: the pairs cannot show it.
std::shared_ptr<const HeightField> WithTrueScale(const HeightField& field,
                                                 const DeepImages& images) {
  constexpr float kMeasured = 0.02F;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < field.cells.size(); ++i) {
    if (field.cells[i].sigma > kMeasured) continue;
    ratios.push_back(field.cells[i].rho / images.rho(field.Centre(i)));
  }
  auto scaled = std::make_shared<HeightField>(field);
  if (!ratios.empty()) scaled->Scale(1 / Median(ratios));
  scaled->scale_sigma = 5e-4;
  return scaled;
}

/// @param scale_known  False: the error along the travel is left out.
Consistency CheckDepth(const Registration& found,
                       const registration::ImageMotion& truth,
                       bool scale_known) {
  constexpr double kWrongPx = 8;
  Consistency one;
  one.pairs = 1;
  if (!found.ok()) return one;
  const Eigen::Vector4d error = MotionError(found.motion, truth);
  if (error.head<2>().norm() > kWrongPx) {
    one.wrong = 1;
    return one;
  }
  // Along the travel, across it, yaw.
  const double direction = std::atan2(truth.ty_px, truth.tx_px);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() << std::cos(direction), std::sin(direction), -std::sin(direction),
      std::cos(direction);
  const Eigen::Vector3d e = turn * error.head<3>();
  const Eigen::Matrix3d covariance =
      turn * found.covariance.topLeftCorner<3, 3>() * turn.transpose();
  one = scale_known ? ConsistencyOf(e, covariance, {{1}, {2}, {0}})
                    : ConsistencyOf(e.tail<2>(), covariance.bottomRightCorner<2, 2>(), {{0}, {1}});
  one.error2 = e[1] * e[1];
  return one;
}

bool RunDepths(const Draw& draw) {
  const auto scenes = DepthScenes();
  const auto conditions = DepthConditions();
  ConsistencyTable table{
      NamesOf(scenes), NamesOf(conditions), {"across", "yaw", "along"}, "across px", {}};
  table.may_be_low = [](const std::string&) { return false; };
  return RunTable(table, [&](std::size_t s, std::size_t c) {
    const DepthCondition& condition = conditions[c];
    Registrar registrar(condition.size);
    Consistency cell;
    for (int i = 0; i < draw.pairs; ++i) {
      const DeepImages images = MakeDeepImages(
          scenes[s], condition, PairSeed(draw.seed, condition.name, scenes[s].name, i));
      auto reference = registrar.Analyze(images.reference);
      Consistency missed;
      missed.pairs = 1;
      bool learned = true;
      const auto match = [&](const DeepImage& image) {
        const auto seen = registrar.Analyze(image.image);
        return reference.Heights() != nullptr
                   ? registrar.Register(reference, seen, image.Expected())
                   : registrar.RegisterWithDepth(reference, seen, image.Expected());
      };
      for (const DeepImage& earlier : images.earlier) {
        const Registration found = match(earlier);
        learned = learned && found.ok() && found.heights;
        if (learned) reference.SetHeights(found.heights);
      }
      const bool knows = reference.Heights() != nullptr;
      if (knows) reference.SetHeights(WithTrueScale(*reference.Heights(), images));
      if (!learned) {
        cell.Add(missed);
        continue;
      }
      cell.Add(CheckDepth(match(images.current), images.current.motion, knows));
    }
    return cell;
  });
}

bool Run(const std::vector<std::string>& arguments) {
  constexpr const char* kUsage = "ceilmap_covariance_bench [motion|tilt|depth] [PAIRS [SEED]]";
  std::vector<std::string> rest = arguments;
  std::string mode = "motion";
  if (!rest.empty() && std::isalpha(static_cast<unsigned char>(rest.front().front())) != 0) {
    mode = rest.front();
    rest.erase(rest.begin());
  }
  const bool numbers = std::all_of(rest.begin(), rest.end(), [](const std::string& text) {
    return !text.empty() && text.size() < 9 &&
           text.find_first_not_of("0123456789") == std::string::npos;
  });
  if (rest.size() > 2 || !numbers) throw InputError(kUsage);
  Draw draw;
  if (!rest.empty()) draw.pairs = std::stoi(rest[0]);
  if (rest.size() > 1) draw.seed = static_cast<std::uint32_t>(std::stoi(rest[1]));
  cv::setNumThreads(1);
  if (mode == "motion") return RunMotions(draw);
  if (mode == "tilt") return RunTilts(draw);
  if (mode == "depth") return RunDepths(draw);
  throw InputError(kUsage);
}

}  // namespace
}  // namespace ceilmap::bench

int main(int argc, char** argv) {
  return ceilmap::support::RunBenchmark(
      "ceilmap_covariance_bench", argc, argv, ceilmap::bench::Run);
}
