// Covariances of registrations compared with the truth, on random pairs of synthetic ceilings:
//   ceilmap_covariance_bench [PAIRS [SEED]]
// PAIRS of each scene and condition (default 112: 10,080 in all). For each the mean of e' C^-1 e /
// n (1 for an honest covariance), and the share within the 95 % bound. Exits with 1 when a bound is
// exceeded.

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/base/error.hpp"
#include "mapping/registration/registrar.hpp"
#include "tests/bench/registration_pairs.hpp"
#include "tests/support/command_line.hpp"

namespace ceilmap::bench {
namespace {

using registration::Registrar;
using registration::RegistrarParams;
using registration::Registration;

/// Sums over the registrations of a cell, a row or a column of the table.
struct Consistency {
  int pairs = 0;
  int found = 0;
  int wrong = 0;  ///< more than 5 px off: no error that a covariance describes
  double nees = 0;
  double shift = 0;  ///< NEES of the shift alone, / 2
  double turn = 0;
  double scale = 0;
  int scales = 0;
  int within = 0;
  double error2 = 0;  ///< of the shift, px^2

  void Add(const Consistency& other) {
    pairs += other.pairs;
    found += other.found;
    wrong += other.wrong;
    nees += other.nees;
    shift += other.shift;
    turn += other.turn;
    scale += other.scale;
    scales += other.scales;
    within += other.within;
    error2 += other.error2;
  }
};

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
  // 95 % of chi squared with three and four degrees of freedom.
  const double bound = fits_scale ? 9.488 : 7.815;
  const Eigen::MatrixXd covariance = found.covariance.topLeftCorner(n, n);
  const Eigen::VectorXd e = error.head(n);
  const double nees = e.dot(covariance.ldlt().solve(e));
  const Eigen::Matrix2d shift = found.covariance.topLeftCorner<2, 2>();
  one.found = 1;
  one.nees = nees / n;
  one.within = nees < bound ? 1 : 0;
  one.shift = 0.5 * error.head<2>().dot(shift.ldlt().solve(error.head<2>()));
  one.turn = error[2] * error[2] / found.covariance(2, 2);
  one.scale = fits_scale ? error[3] * error[3] / found.covariance(3, 3) : 0;
  one.scales = fits_scale ? 1 : 0;
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

/// Another seed for each pair of each cell: what its images show, their motion and noise are its
/// own.
std::uint32_t Mixed(std::uint32_t seed,
                    const std::string& condition,
                    const std::string& scene,
                    int i) {
  const std::string text = fmt::format("{}|{}|{}|{}", seed, condition, scene, i);
  std::uint32_t hash = 2166136261U;  // FNV-1a
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return hash;
}

void PrintHeader() {
  fmt::print("{:<16}{:<18}{:>6}{:>7}{:>7}{:>8}{:>8}{:>8}{:>8}{:>8}{:>9}\n",
             "scene",
             "condition",
             "pairs",
             "found",
             "wrong",
             "NEES/n",
             "in 95%",
             "shift",
             "yaw",
             "scale",
             "RMSE px");
}

void PrintRow(const std::string& scene, const std::string& condition, const Consistency& sum) {
  const double n = std::max(1, sum.found);
  fmt::print("{:<16}{:<18}{:>6}{:>7}{:>7}{:>8.2f}{:>8.3f}{:>8.2f}{:>8.2f}{:>8}{:>9.4f}\n",
             scene,
             condition,
             sum.pairs,
             sum.found,
             sum.wrong,
             sum.nees / n,
             sum.within / n,
             sum.shift / n,
             sum.turn / n,
             sum.scales > 0 ? fmt::format("{:.2f}", sum.scale / sum.scales) : "",
             std::sqrt(sum.error2 / n));
  std::fflush(stdout);
}

bool Run(const std::vector<std::string>& arguments) {
  if (arguments.size() > 2) throw InputError("ceilmap_covariance_bench [PAIRS [SEED]]");
  const int pairs = arguments.empty() ? 112 : std::stoi(arguments[0]);
  const auto seed = static_cast<std::uint32_t>(arguments.size() < 2 ? 1 : std::stoi(arguments[1]));
  cv::setNumThreads(1);
  std::map<std::string, Consistency> by_scene;
  std::map<std::string, Consistency> by_condition;
  Consistency all;
  PrintHeader();
  for (const PairCondition& condition : PairConditions()) {
    RegistrarParams params;
    params.estimate_scale = condition.fits_scale;
    Registrar registrar(condition.size, params);
    for (const PairScene& scene : PairScenes()) {
      Consistency cell;
      for (int i = 0; i < pairs; ++i) {
        const ImagePair pair =
            MakePair(scene, condition, Mixed(seed, condition.name, scene.name, i));
        cell.Add(Check(Register(registrar, pair, condition.tracked), pair, condition.fits_scale));
      }
      PrintRow(scene.name, condition.name, cell);
      by_scene[scene.name].Add(cell);
      by_condition[condition.name].Add(cell);
      all.Add(cell);
    }
  }
  fmt::print("\n");
  PrintHeader();
  bool bounded = true;
  const auto summary =
      [&](const std::string& scene, const std::string& condition, const Consistency& sum) {
        PrintRow(scene, condition, sum);
        const double mean = sum.nees / std::max(1, sum.found);
        // Without noise images are taken for encoded ones, whose errors are larger.
        bounded = bounded && mean < 2 && (mean > 0.5 || condition.ends_with("noise 0"));
      };
  for (const PairScene& scene : PairScenes()) summary(scene.name, "all", by_scene[scene.name]);
  for (const PairCondition& c : PairConditions()) summary("all", c.name, by_condition[c.name]);
  summary("all", "all", all);
  const double n = std::max(1, all.found);
  return bounded && all.nees / n > 0.8 && all.nees / n < 1.25 && all.within / n > 0.92 &&
         all.within / n < 0.98;
}

}  // namespace
}  // namespace ceilmap::bench

int main(int argc, char** argv) {
  return ceilmap::support::RunBenchmark(
      "ceilmap_covariance_bench", argc, argv, ceilmap::bench::Run);
}
