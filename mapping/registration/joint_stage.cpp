#include "mapping/registration/joint_stage.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calib/base/pose2.hpp"
#include "mapping/registration/content_centres.hpp"

namespace ceilmap::registration {
namespace {

constexpr int kBlockPx = 32;
constexpr int kBlocks = 90;
// A block says nothing of shifts that leave it with less than half of its content.
constexpr int kSurfaceReach = kBlockPx / 2 - 1;
constexpr int kSurfaceSide = 2 * kSurfaceReach + 1;
constexpr std::size_t kSurfaceArea = std::size_t{kSurfaceSide} * kSurfaceSide;
constexpr int kMinBlocks = 8;
// The search covers so many standard deviations of the prior, within these limits, level px and
// rad.
constexpr double kPriorSigmas = 3;
constexpr int kMinReach = 4;
constexpr int kMaxReach = 12;
constexpr double kMinTurn = 0.015;
constexpr double kMaxTurn = 0.1;
// One measurement of the surfaces serves for all turns of a search: the next round measures anew.
constexpr double kAllTurns = 2 * kMaxTurn;
// Reach of the second round, level px, and its turns, steps.
constexpr int kCloseReach = 5;
constexpr int kCloseTurns = 5;
// Motions further than this from the best one are others, level px at the image's corner.
constexpr double kOtherPx = 3;
// ... unless a maximum of this curvature loses no more than this on the way there, nats.
constexpr double kNeighbourNats = 10;
// Less evidence of a block is chance, nats.
constexpr float kSomeNats = 5;
// The best motion must exceed all others by this evidence, nats, ...
constexpr double kMinLead = 12;
// ... and chance by this.
constexpr double kMinNats = 40;
// Standard deviation of the height of what is seen, ratio: where it is known, and where not.
constexpr double kKnownHeightSigma = 0.03;
constexpr double kHeightSigma = 0.08;

/// Catmull-Rom weights of four samples, for a position between the second and the third.
std::array<float, 4> CubicTaps(double part) {
  const auto t = static_cast<float>(part);
  return {0.5F * t * (-1 + t * (2 - t)),
          1 + 0.5F * t * t * (-5 + 3 * t),
          0.5F * t * (1 + t * (4 - 3 * t)),
          0.5F * t * t * (t - 1)};
}

/// 255 where all rough pixels of a pixel have content; empty: everywhere.
cv::Mat ContentOf(const cv::Mat& rough_blank, cv::Size size) {
  if (rough_blank.empty()) return {};
  cv::Mat content(size, CV_8UC1);
  for (int y = 0; y < content.rows; ++y) {
    const int* above = rough_blank.ptr<int>(2 * y);
    const int* below = rough_blank.ptr<int>(2 * y + 2);
    auto* row = content.ptr<unsigned char>(y);
    for (int x = 0; x < content.cols; ++x) {
      const int left = 2 * x;
      const int count = below[left + 2] - below[left] - above[left + 2] + above[left];
      row[x] = count == 0 ? 255 : 0;
    }
  }
  return content;
}

}  // namespace

JointStage::JointStage(cv::Size size, const RegistrarParams& params)
    : frame_(size, 4 * FineFactor(size)),
      rough_size_(LevelFrame(size, 2 * FineFactor(size)).size),
      either_contrast_(!params.same_recording),
      half_diagonal_px_(0.5 * std::hypot(frame_.size.width, frame_.size.height)),
      blocks_(frame_.size,
              LevelMask(params.mask, frame_.size),
              {kBlockPx, kBlocks, &Level::blocks},
              params.same_recording),
      principal_px_(frame_.CameraOf(params.camera).principal_px) {}

void JointStage::Prepare(FrameSpectrum::Data& data) {
  const std::scoped_lock lock(data.mutex);
  if (data.broad_ready) return;
  Level& broad = data.broad;
  broad.grey.Resize(static_cast<std::size_t>(frame_.size.area()));
  broad.noise = data.rough.noise.Reduced(2);
  const cv::Mat rough(rough_size_, CV_32FC1, data.rough.grey.data());
  const cv::Rect even(0, 0, 2 * frame_.size.width, 2 * frame_.size.height);
  cv::Mat reduced(frame_.size, CV_32FC1, broad.grey.data());
  cv::resize(rough(even), reduced, frame_.size, 0, 0, cv::INTER_AREA);
  broad.blank.release();
  const cv::Mat mask = ContentOf(data.rough.blank, frame_.size);
  if (!mask.empty()) blocks_.TakeMask(mask, broad);
  blocks_.PrepareReference(broad);
  data.broad_ready = true;
}

/// The start's motion of the block's content, which is nearer or farther than the reference plane.
ImageMotion JointStage::MotionOf(int block,
                                 const heights::HeightField* known,
                                 const ImageMotion& start) const {
  if (known == nullptr) return start;
  const Eigen::Vector2d at = frame_.factor * blocks_.Centre(block) + frame_.offset;
  const double rho = known->Around(at).rho;
  const Eigen::Vector2d turned =
      principal_px_ - Eigen::Rotation2Dd(start.theta_rad) * principal_px_;
  ImageMotion motion = start;
  motion.tx_px = turned.x() + rho * (start.tx_px - turned.x());
  motion.ty_px = turned.y() + rho * (start.ty_px - turned.y());
  return motion;
}

/// @return false where too few blocks can be compared.
bool JointStage::MeasureSurfaces(const Images& images,
                                 const ImageMotion& start,
                                 Surfaces& surfaces) {
  const Level& reference = images.reference.broad;
  const Level& current = images.current.broad;
  const auto chosen = blocks_.Select(reference, current, start, blocks_.GridSize());
  grey_.create(frame_.size, CV_32FC1);
  std::copy_n(reference.grey.data(), reference.grey.size(), grey_.ptr<float>());
  const ContentCentres content(grey_);
  surfaces.blocks.clear();
  surfaces.centres.clear();
  surfaces.values.resize(kSurfaceArea * chosen.size());
  for (const int block : chosen) {
    float* surface = surfaces.values.data() + kSurfaceArea * surfaces.blocks.size();
    const ImageMotion motion = MotionOf(block, images.heights, start);
    if (!blocks_.Correlate(reference, current, motion, block, kSurfaceReach, surface)) continue;
    surfaces.blocks.push_back(block);
    surfaces.centres.push_back(content.Of(blocks_.Area(block)));
  }
  return static_cast<int>(surfaces.blocks.size()) >= kMinBlocks;
}

/// Largest value of a surface that is evidence, at least 0.
float JointStage::Largest(const float* surface) const {
  const auto [low, high] = std::minmax_element(surface, surface + kSurfaceArea);
  return std::max({0.0F, *high, either_contrast_ ? -*low : 0.0F});
}

/// A block's evidence is limited by its largest value under all turns: with a limit for each turn,
/// wrong turns would have as much evidence as the right one.
void JointStage::LimitBlocks(const Surfaces& surfaces) {
  for (std::size_t i = 0; i < surfaces.blocks.size(); ++i) {
    const float* surface = surfaces.values.data() + i * kSurfaceArea;
    float& most = most_[static_cast<std::size_t>(surfaces.blocks[i])];
    most = std::max(most, Largest(surface));
  }
}

/// Adds the evidence of one block under a turn, which moves the block so that its surface is read
/// beside the shift. The surface is band-limited and interpolated before it is squared.
void JointStage::AddBlock(const Surfaces& surfaces, std::size_t block, int turn, Lattice& lattice) {
  const double theta = (turn - surfaces.measured_at) * lattice.turn_step;
  const Eigen::Vector2d& centre = surfaces.centres[block];
  const Eigen::Vector2d moved(-theta * centre.y(), theta * centre.x());
  const float most = most_[static_cast<std::size_t>(surfaces.blocks[block])];
  const float weight = 0.5F * kMaxBlockNats / std::max(kMaxBlockNats, 0.5F * most * most);
  const int left = static_cast<int>(std::floor(moved.x()));
  const int top = static_cast<int>(std::floor(moved.y()));
  const std::array<float, 4> across = CubicTaps(moved.x() - left);
  const std::array<float, 4> down = CubicTaps(moved.y() - top);
  const int side = kSurfaceSide;
  const float* surface = surfaces.values.data() + block * kSurfaceArea;
  // The part of the lattice for which all samples are on the surface.
  const int first_x = std::max(-lattice.reach, 1 - left - kSurfaceReach);
  const int last_x = std::min(lattice.reach, kSurfaceReach - 2 - left);
  const int first_y = std::max(-lattice.reach, 1 - top - kSurfaceReach);
  const int last_y = std::min(lattice.reach, kSurfaceReach - 2 - top);
  row_.resize(static_cast<std::size_t>(side));
  for (int y = first_y; y <= last_y; ++y) {
    const float* rows = surface + (y + top + kSurfaceReach - 1) * side;
    for (int column = 0; column < side; ++column) {
      row_[static_cast<std::size_t>(column)] =
          down[0] * rows[column] + down[1] * rows[column + side] +
          down[2] * rows[column + 2 * side] + down[3] * rows[column + 3 * side];
    }
    float* sum = lattice.nats.data() + lattice.Index(turn, y, 0);
    const float* samples = row_.data() + left + kSurfaceReach - 1;
    for (int x = first_x; x <= last_x; ++x) {
      const float z = across[0] * samples[x] + across[1] * samples[x + 1] +
                      across[2] * samples[x + 2] + across[3] * samples[x + 3];
      sum[x] += z > 0 || either_contrast_ ? weight * z * z : 0.0F;
    }
  }
}

/// Adds the evidence of all blocks under a turn, of each where it was measured nearest to that
/// turn. A block that a turn takes out of the image still counts there: otherwise the turn under
/// which most of the image is compared would have most evidence.
void JointStage::AddBlocks(int turn, Lattice& lattice) {
  const auto off = [turn](const Surfaces& s) { return std::abs(turn - s.measured_at); };
  by_distance_ = {&middle_};
  for (const Surfaces& surfaces : turned_) by_distance_.push_back(&surfaces);
  std::sort(by_distance_.begin(), by_distance_.end(), [&](const auto* a, const auto* b) {
    return off(*a) < off(*b);
  });
  added_.assign(most_.size(), 0);
  for (const Surfaces* surfaces : by_distance_) {
    for (std::size_t i = 0; i < surfaces->blocks.size(); ++i) {
      const auto block = static_cast<std::size_t>(surfaces->blocks[i]);
      if (added_[block] == 0) AddBlock(*surfaces, i, turn, lattice);
      added_[block] = 1;
    }
  }
  compared_ = static_cast<int>(std::count(added_.begin(), added_.end(), 1));
}

/// Fills the lattice.
/// @param same_turn  The surfaces are measured anew for turns that are further than this away, rad:
/// a block's content turns with it. Measured at one turn only, the arcs of a round thing stay where
/// they are under every other one, and confirm the turn that was expected.
/// @return false where the images cannot be compared at the start: no evidence. Otherwise the
/// measured blocks are those of the start.
bool JointStage::MeasureEvidence(const Images& images,
                                 const ImageMotion& start,
                                 double same_turn,
                                 Lattice& lattice) {
  const auto side = static_cast<std::size_t>(lattice.Side());
  lattice.nats.assign(side * side * static_cast<std::size_t>(2 * lattice.turns + 1), 0);
  const int reach = static_cast<int>(same_turn / lattice.turn_step);
  middle_.measured_at = 0;
  if (!MeasureSurfaces(images, start, middle_)) {
    middle_.blocks.clear();
    return false;
  }
  const int width = 2 * reach + 1;
  const int strips = (lattice.turns + reach) / width;  // on each side
  turned_.resize(static_cast<std::size_t>(2 * strips));
  std::size_t strip = 0;
  for (int at = -strips; at <= strips; ++at) {
    if (at == 0) continue;
    Surfaces& surfaces = turned_[strip++];
    surfaces.measured_at = at * width;
    const ImageMotion motion = MotionAt(lattice, start, {0, 0, 1.0 * surfaces.measured_at});
    if (!MeasureSurfaces(images, motion, surfaces)) surfaces.blocks.clear();
  }
  most_.assign(static_cast<std::size_t>(blocks_.GridSize()), 0);
  LimitBlocks(middle_);
  for (const Surfaces& surfaces : turned_) LimitBlocks(surfaces);
  for (int turn = -lattice.turns; turn <= lattice.turns; ++turn) AddBlocks(turn, lattice);
  return true;
}

/// @param at  A shift that is made before the turn, and the turn, lattice steps.
ImageMotion JointStage::MotionAt(const Lattice& lattice,
                                 const ImageMotion& start,
                                 const Eigen::Vector3d& at) {
  const ImageMotion turned = Compose(start, {0, 0, at.z() * lattice.turn_step, 1});
  return Compose(turned, {at.x(), at.y(), 0, 1});
}

double JointStage::LogPrior(const MotionPrior& prior, const ImageMotion& motion) const {
  const double sigma_px = prior.sigma_px / frame_.factor;
  const ImageMotion expected = frame_.FromFull(prior.motion);
  const double shift =
      std::hypot(motion.tx_px - expected.tx_px, motion.ty_px - expected.ty_px) / sigma_px;
  const double turn = WrapAngle(motion.theta_rad - expected.theta_rad) / prior.sigma_theta_rad;
  return -0.5 * (shift * shift + turn * turn);
}

/// @param best  If given, the best motion that is none of its neighbours: those that the curvature
/// of the evidence there, `information`, explains.
JointStage::Peak JointStage::FindPeak(const Lattice& lattice,
                                      const ImageMotion& start,
                                      const MotionPrior& prior,
                                      const Peak* best,
                                      const Eigen::Matrix3d& information) const {
  Peak peak;
  peak.score = -1e9;
  for (int turn = -lattice.turns; turn <= lattice.turns; ++turn) {
    for (int y = -lattice.reach; y <= lattice.reach; ++y) {
      for (int x = -lattice.reach; x <= lattice.reach; ++x) {
        const double nats = lattice.At(turn, y, x);
        if (nats < peak.score) continue;
        if (best != nullptr) {
          const Eigen::Vector3d d(x - best->x, y - best->y, turn - best->turn);
          const double corner_px =
              d.head<2>().norm() + std::abs(d.z()) * lattice.turn_step * half_diagonal_px_;
          if (corner_px < kOtherPx || 0.5 * d.dot(information * d) < kNeighbourNats) continue;
        }
        const Eigen::Vector3d at(x, y, turn);
        const double score = nats + LogPrior(prior, MotionAt(lattice, start, at));
        if (score > peak.score) peak = {turn, y, x, nats, score};
      }
    }
  }
  return peak;
}

/// Blocks of whose evidence the motion has at least half, and of which there is some.
int JointStage::CountAgreeing(const Lattice& lattice, const Peak& peak) const {
  const int side = kSurfaceSide;
  const double theta = peak.turn * lattice.turn_step;
  int agreeing = 0;
  for (std::size_t block = 0; block < middle_.blocks.size(); ++block) {
    const Eigen::Vector2d& centre = middle_.centres[block];
    const long column = std::lround(peak.x - theta * centre.y()) + kSurfaceReach;
    const long row = std::lround(peak.y + theta * centre.x()) + kSurfaceReach;
    if (column < 0 || row < 0 || column >= side || row >= side) continue;
    const float* surface = middle_.values.data() + block * kSurfaceArea;
    const float most = Largest(surface);
    const float value = surface[row * side + column];
    const float here = either_contrast_ ? std::abs(value) : std::max(0.0F, value);
    if (0.5F * here * here > kSomeNats && 2 * here * here > most * most) ++agreeing;
  }
  return agreeing;
}

/// The lattice that covers a prior.
JointStage::Lattice JointStage::LatticeFor(double sigma_px, double sigma_rad) const {
  Lattice lattice;
  lattice.turn_step = 1 / half_diagonal_px_;
  const double reach = std::ceil(kPriorSigmas * sigma_px / frame_.factor) + 1;
  lattice.reach = static_cast<int>(std::clamp<double>(reach, kMinReach, kMaxReach));
  const double most_turn = std::clamp(kPriorSigmas * sigma_rad, kMinTurn, kMaxTurn);
  lattice.turns = static_cast<int>(std::ceil(most_turn / lattice.turn_step));
  return lattice;
}

/// From lattice steps in the axes of the reference to full pixels and radians in those of the
/// current image.
Eigen::Matrix3d JointStage::FullAxes(const Lattice& lattice, const ImageMotion& start) const {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  axes.topLeftCorner<2, 2>() =
      frame_.factor * Eigen::Rotation2Dd(start.theta_rad).toRotationMatrix();
  axes(2, 2) = lattice.turn_step;
  return axes;
}

Registration JointStage::Match(const Images& images, const MotionPrior& prior) {
  Registration result;
  result.jointly = true;
  ImageMotion start = frame_.FromFull(prior.motion);
  start.scale = 1;
  Lattice wide = LatticeFor(prior.sigma_px, prior.sigma_theta_rad);
  if (!MeasureEvidence(images, start, kAllTurns, wide)) return result;
  const Peak first = FindPeak(wide, start, prior, nullptr, {});
  Eigen::Vector3d offset;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  (void)Settle(wide, first, offset, information);
  const double first_lead = first.score - FindPeak(wide, start, prior, &first, information).score;
  // Again from there: a block that had moved far had only a part of its content.
  start = MotionAt(wide, start, Eigen::Vector3d(first.x, first.y, first.turn));
  Lattice close;
  close.turn_step = 0.5 * wide.turn_step;
  close.reach = kCloseReach;
  close.turns = kCloseTurns;
  if (!MeasureEvidence(images, start, kAllTurns, close)) return result;
  const Peak best = FindPeak(close, start, prior, nullptr, {});
  if (!Settle(close, best, offset, information)) return result;
  const Eigen::Vector3d at = Eigen::Vector3d(best.x, best.y, best.turn) + offset;
  const ImageMotion found = MotionAt(close, start, at);
  result.motion = frame_.ToFull(found);
  const Eigen::Matrix3d axes = FullAxes(close, start);
  const Eigen::Matrix3d steps = CovarianceOf(information, middle_.blocks.size());
  result.covariance.topLeftCorner<3, 3>() = axes * steps * axes.transpose();
  // What little is seen may hang below the ceiling.
  const Eigen::Vector2d travel(result.motion.tx_px, result.motion.ty_px);
  const double height_sigma = images.heights != nullptr ? kKnownHeightSigma : kHeightSigma;
  result.covariance.topLeftCorner<2, 2>() +=
      height_sigma * height_sigma * travel * travel.transpose();
  result.overlap = OverlapOf(found, frame_.size);
  result.blocks = static_cast<int>(middle_.blocks.size());
  result.inliers = CountAgreeing(close, best);
  const double all = kMaxBlockNats * static_cast<double>(middle_.blocks.size());
  result.peak = best.nats / all;
  const Peak other = FindPeak(close, start, prior, &best, information);
  const double lead = std::min(best.score - other.score, first_lead);
  result.runner_up = std::max(0.0, best.nats - lead) / all;
  if (best.nats < kMinNats) return result;
  result.verdict = lead < kMinLead ? Verdict::kAmbiguous : Verdict::kOk;
  return result;
}

}  // namespace ceilmap::registration
