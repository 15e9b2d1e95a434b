#include "mapping/registration/block_stage.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mapping/registration/kernels.hpp"
#include "mapping/registration/plane_projection.hpp"

namespace ceilmap::registration {
namespace {

// Whitening stops where the signal falls below this many noise powers.
constexpr double kBlockNoiseFactor = 4;

kernels::Affine SamplingMap(const ImageMotion& motion, cv::Size size, cv::Point corner) {
  // Block pixel (x, y) is reference pixel corner + (x, y); its image is s R (p - c) + t + c.
  const double cx = 0.5 * (size.width - 1);
  const double cy = 0.5 * (size.height - 1);
  const double c = motion.scale * std::cos(motion.theta_rad);
  const double s = motion.scale * std::sin(motion.theta_rad);
  const double px = corner.x - cx;
  const double py = corner.y - cy;
  return {static_cast<float>(c),
          static_cast<float>(-s),
          static_cast<float>(c * px - s * py + motion.tx_px + cx),
          static_cast<float>(s),
          static_cast<float>(c),
          static_cast<float>(s * px + c * py + motion.ty_px + cy)};
}

}  // namespace

std::vector<int> Without(std::vector<int> blocks, const std::vector<int>& chosen) {
  std::erase_if(blocks, [&chosen](int block) {
    return std::find(chosen.begin(), chosen.end(), block) != chosen.end();
  });
  return blocks;
}

BlockStage::BlockStage(cv::Size size,
                       const cv::Mat& mask,
                       const BlockGrid& grid,
                       bool same_recording)
    : blocks_(grid.of_level),
      block_px_(grid.block_px),
      removes_slope_(grid.removes_slope),
      same_recording_(same_recording),
      size_(size),
      poc_({grid.block_px, grid.block_px}),
      sampling_error_(poc_.WindowX()),
      samples_(poc_.Area()),
      spectrum_(poc_.SpectrumSize()) {
  if (!mask.empty()) {
    any_blank_ = mask < 255;
    blank_ = IntegralOf(any_blank_);
  }
  LayOutGrid(grid.blocks);
}

cv::Mat BlockStage::IntegralOf(const cv::Mat& blank) {
  cv::Mat integral;
  cv::integral(blank / 255, integral, CV_32S);
  return integral;
}

void BlockStage::TakeMask(const cv::Mat& mask, Level& level) const {
  level.blank.release();
  if (mask.empty()) return;
  cv::Mat blank = mask < 255;
  if (!any_blank_.empty()) cv::bitwise_or(blank, any_blank_, blank);
  level.blank = IntegralOf(blank);
}

void BlockStage::LayOutGrid(int blocks) {
  const int block = block_px_;
  // Two pixels of margin for bicubic sampling.
  const int room_x = size_.width - block - 4;
  const int room_y = size_.height - block - 4;
  if (room_x < 0 || room_y < 0) return;
  const double area = static_cast<double>(room_x + block) * (room_y + block);
  const double step = std::max(block / 2.0, std::sqrt(area / blocks));
  grid_ = {1 + static_cast<int>(room_x / step), 1 + static_cast<int>(room_y / step)};
  for (int j = 0; j < grid_.height; ++j) {
    for (int i = 0; i < grid_.width; ++i) {
      const double fx = grid_.width > 1 ? static_cast<double>(i) / (grid_.width - 1) : 0.5;
      const double fy = grid_.height > 1 ? static_cast<double>(j) / (grid_.height - 1) : 0.5;
      corners_.emplace_back(2 + static_cast<int>(std::lround(fx * room_x)),
                            2 + static_cast<int>(std::lround(fy * room_y)));
    }
  }
}

void BlockStage::PrepareReference(Level& level) {
  const int block = block_px_;
  const int half = block / 2 + 1;
  const double noise =
      kBlockNoiseFactor * level.noise.coded * level.noise.coded * poc_.WindowPower();
  RealArray samples(poc_.Area());
  std::vector<ReferenceBlock>& blocks = level.*blocks_;
  blocks.resize(corners_.size());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    CopyBlock(level, corners_[i], samples);
    ReferenceBlock& out = blocks[i];
    out.spectrum.Resize(poc_.SpectrumSize());
    out.blank = IsBlank(samples);
    poc_.Transform(samples, out.spectrum);
    // The sharpness of the block's correlation peak.
    double xx = 0;
    double yy = 0;
    double xy = 0;
    double signal = 0;
    double all = 0;
    std::size_t k = 0;
    for (int row = 0; row < block; ++row) {
      const double ky = row <= block / 2 ? row : row - block;
      for (int col = 0; col < half; ++col, ++k) {
        const double power = std::norm(out.spectrum[k]);
        const double weight = poc_.Band()[k] * power / (power + noise);
        signal += weight;
        all += poc_.Band()[k];
        xx += weight * col * col;
        yy += weight * ky * ky;
        xy += weight * col * ky;
      }
    }
    // Smaller eigenvalue of the sharpness: the information of the block in its worst direction.
    out.content = all > 0 ? signal / all : 0;
    out.texture = 0.5 * (xx + yy - std::hypot(xx - yy, 2 * xy));
  }
}

/// Sensors have noise, so a block of one constant grey level was not measured. It would match any
/// other constant block exactly.
bool BlockStage::IsBlank(const RealArray& samples) const {
  constexpr float kVariance = 1e-3F;  // grey levels squared
  const Eigen::Map<const Eigen::VectorXf> values(samples.data(),
                                                 static_cast<Eigen::Index>(samples.size()));
  return values.squaredNorm() < kVariance * static_cast<float>(poc_.WindowPower());
}

bool BlockStage::Usable(const Level& reference, int block) const {
  return !(reference.*blocks_)[static_cast<std::size_t>(block)].blank &&
         Inside(SamplingMap({}, size_, corners_[static_cast<std::size_t>(block)]), reference);
}

bool BlockStage::Inside(const kernels::Affine& m, const Level& level) const {
  const auto last = static_cast<float>(block_px_ - 1);
  for (const float x : {0.0F, last}) {
    for (const float y : {0.0F, last}) {
      const float sx = m.xx * x + m.xy * y + m.x0;
      const float sy = m.yx * x + m.yy * y + m.y0;
      if (!(sx >= 1.01F && sy >= 1.01F && sx < static_cast<float>(size_.width) - 2.01F &&
            sy < static_cast<float>(size_.height) - 2.01F)) {
        return false;
      }
    }
  }
  const cv::Mat& blank = BlankOf(level);
  if (blank.empty()) return true;
  // A block with any blank pixel in its image is left out.
  const float x0 = m.x0 + std::min(0.0F, m.xx * last) + std::min(0.0F, m.xy * last);
  const float y0 = m.y0 + std::min(0.0F, m.yx * last) + std::min(0.0F, m.yy * last);
  const float x1 = m.x0 + std::max(0.0F, m.xx * last) + std::max(0.0F, m.xy * last);
  const float y1 = m.y0 + std::max(0.0F, m.yx * last) + std::max(0.0F, m.yy * last);
  const auto column = [&](float x) { return std::clamp(static_cast<int>(x), 0, size_.width); };
  const auto row = [&](float y) { return std::clamp(static_cast<int>(y), 0, size_.height); };
  const int left = column(x0 - 1);
  const int right = column(x1 + 3);
  const int top = row(y0 - 1);
  const int bottom = row(y1 + 3);
  return blank.at<int>(bottom, right) - blank.at<int>(top, right) - blank.at<int>(bottom, left) +
             blank.at<int>(top, left) ==
         0;
}

std::vector<int> BlockStage::Select(const Level& reference,
                                    const Level& current,
                                    const ImageMotion& motion,
                                    int count) const {
  std::vector<int> inside;
  for (int i = 0; i < GridSize(); ++i) {
    const kernels::Affine map = SamplingMap(motion, size_, corners_[static_cast<std::size_t>(i)]);
    if (Usable(reference, i) && Inside(map, current)) inside.push_back(i);
  }
  if (static_cast<int>(inside.size()) <= count) return inside;
  const auto texture = [&](int i) {
    return (reference.*blocks_)[static_cast<std::size_t>(i)].texture;
  };
  // Neighbourhoods of 2x2 grid positions; first the best of each, then the second best of each, ...
  std::vector<std::vector<int>> cells(
      static_cast<std::size_t>((grid_.width + 1) / 2 * ((grid_.height + 1) / 2)));
  for (const int i : inside) {
    const int cell = (i / grid_.width) / 2 * ((grid_.width + 1) / 2) + (i % grid_.width) / 2;
    cells[static_cast<std::size_t>(cell)].push_back(i);
  }
  std::vector<int> chosen;
  for (auto& cell : cells) {
    std::sort(cell.begin(), cell.end(), [&](int a, int b) { return texture(a) > texture(b); });
  }
  for (std::size_t rank = 0; rank < 4; ++rank) {
    std::vector<int> layer;
    for (const auto& cell : cells) {
      if (rank < cell.size()) layer.push_back(cell[rank]);
    }
    std::sort(layer.begin(), layer.end(), [&](int a, int b) { return texture(a) > texture(b); });
    for (const int i : layer) {
      if (static_cast<int>(chosen.size()) < count) chosen.push_back(i);
    }
  }
  return chosen;
}

kernels::BlockWindow BlockStage::Window() const {
  return {poc_.WindowX().data(), poc_.WindowY().data(), block_px_, block_px_, removes_slope_};
}

void BlockStage::SampleBlock(const Level& level,
                             const kernels::Affine& map,
                             RealArray& samples) const {
  kernels::SampleCubicWindowed(level.grey.data(), size_.width, map, Window(), samples.data());
}

void BlockStage::CopyBlock(const Level& level, cv::Point corner, RealArray& samples) const {
  kernels::CopyWindowed(
      level.grey.data() + static_cast<std::ptrdiff_t>(corner.y) * size_.width + corner.x,
      size_.width,
      Window(),
      samples.data());
}

Dissimilarity BlockStage::Compare(const Level& reference,
                                  const Level& current,
                                  const ImageMotion& motion,
                                  double noise_power) {
  // With sampling and compression about this fraction of a block's energy remains unexplained even
  // under the true motion.
  constexpr double kUnexplained = 0.02;
  const double noise = noise_power * poc_.WindowPower();
  Dissimilarity result;
  result.by_block.assign(corners_.size(), -1);
  const auto n = static_cast<Eigen::Index>(samples_.size());
  Eigen::VectorXf wanted(n);
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const cv::Point corner = corners_[i];
    const kernels::Affine map = SamplingMap(motion, size_, corner);
    const kernels::Affine in_reference = SamplingMap({}, size_, corner);
    if (!Inside(in_reference, reference) || !Inside(map, current)) continue;
    CopyBlock(reference, corner, samples_);
    if (IsBlank(samples_)) continue;
    wanted = Eigen::Map<const Eigen::VectorXf>(samples_.data(), n);
    SampleBlock(current, map, samples_);
    if (IsBlank(samples_)) continue;
    const Eigen::Map<const Eigen::VectorXf> seen(samples_.data(), n);
    const double energy = std::sqrt(static_cast<double>(wanted.squaredNorm()) * seen.squaredNorm());
    const double common = wanted.dot(seen);
    const double dissimilarity =
        energy > 0 ? energy * (1 - std::pow(std::max(common, 0.0) / energy, 2)) : 0.0;
    const double nats = std::log1p(dissimilarity / (noise + kUnexplained * energy + 1e-9));
    result.by_block[i] = static_cast<float>(nats);
    result.mean += nats;
    ++result.blocks;
  }
  if (result.blocks > 0) result.mean /= result.blocks;
  return result;
}

cv::Rect BlockStage::Area(int block) const {
  return {corners_[static_cast<std::size_t>(block)], cv::Size(block_px_, block_px_)};
}

Eigen::Vector2d BlockStage::Centre(int block) const {
  const cv::Point corner = corners_[static_cast<std::size_t>(block)];
  const double middle = 0.5 * (block_px_ - 1);
  return {corner.x + middle - 0.5 * (size_.width - 1),
          corner.y + middle - 0.5 * (size_.height - 1)};
}

/// Leaves the spectrum in `spectrum_`; false where the current image is blank.
bool BlockStage::TransformBlock(const Level& current, const kernels::Affine& map) {
  SampleBlock(current, map, samples_);
  if (IsBlank(samples_)) return false;
  poc_.Transform(samples_, spectrum_);
  return true;
}

double BlockStage::NoisePower(const Level& reference, const Level& current) const {
  const double power = CodedPower(reference.noise, current.noise, same_recording_);
  return kBlockNoiseFactor * poc_.WindowPower() * power;
}

bool BlockStage::Correlate(const Level& reference,
                           const Level& current,
                           const ImageMotion& motion,
                           int block,
                           int reach,
                           float* surface) {
  const kernels::Affine map = SamplingMap(motion, size_, corners_[static_cast<std::size_t>(block)]);
  if (!Inside(map, current) || !TransformBlock(current, map)) return false;
  poc_.Correlate((reference.*blocks_)[static_cast<std::size_t>(block)].spectrum,
                 spectrum_,
                 NoisePower(reference, current));
  poc_.Normalized(reach, surface);
  return true;
}

bool BlockStage::MeasureBlock(const Level& reference,
                              const Level& current,
                              int block,
                              const kernels::Affine& map,
                              int search_px,
                              BlockShift& shift) {
  if (!TransformBlock(current, map)) return false;
  const ReferenceBlock& wanted = (reference.*blocks_)[static_cast<std::size_t>(block)];
  poc_.CorrelateNear(wanted.spectrum, spectrum_, NoisePower(reference, current), search_px);
  const PocPeak peak = poc_.PeakWithin(search_px);
  if (peak.height <= 0) return false;
  shift.point = Centre(block);
  shift.shift = peak.shift;
  shift.sharpness = peak.sharpness;
  shift.sampling = sampling_error_.Expected(map, peak.sharpness);
  shift.peak = peak.height;
  shift.content = wanted.content;
  shift.quality = peak.height * peak.height / (1.05 - peak.height * peak.height);
  if (same_recording_ && reference.noise.IsSmooth() && current.noise.IsSmooth()) {
    shift.signal = peak.signal;
    shift.quality *= peak.signal;
  }
  return true;
}

void BlockStage::Measure(const Level& reference,
                         const Level& current,
                         const ImageMotion& motion,
                         const std::vector<int>& chosen,
                         int search_px,
                         std::vector<BlockShift>& shifts) {
  shifts.clear();
  for (const int i : chosen) {
    const kernels::Affine map = SamplingMap(motion, size_, corners_[static_cast<std::size_t>(i)]);
    BlockShift shift;
    if (Inside(map, current) && MeasureBlock(reference, current, i, map, search_px, shift)) {
      shifts.push_back(shift);
    }
  }
}

void BlockStage::MeasurePlane(const Level& reference,
                              const Level& current,
                              const PlaneCamera& camera,
                              const PlaneMotion& motion,
                              const std::vector<int>& chosen,
                              int search_px,
                              std::vector<PlaneShift>& shifts,
                              std::span<const double> rho,
                              int passes) {
  shifts.clear();
  const double middle = 0.5 * (block_px_ - 1);
  const double spread = sampling_error_.WindowSigma();
  const PlaneProjection<double> projection = ProjectionOf(camera, motion);
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const int i = chosen[k];
    const double height = rho.empty() ? 1 : rho[k];
    const Eigen::Vector2d centre = Centre(i);
    const Eigen::Vector2d seen = projection.Apply(centre, height);
    const Eigen::Matrix2d linear = projection.Jacobian(centre, height);
    // Blocks of a ceiling with depth are half as large: a quarter of this, below their errors.
    Eigen::Vector2d bend = Eigen::Vector2d::Zero();
    if (rho.empty()) bend = projection.MeanAround(centre, spread) - seen;
    PlaneShift shift;
    Eigen::Vector2d found = Eigen::Vector2d::Zero();  // by the passes so far
    bool ok = true;
    for (int pass = 0; pass < passes && ok; ++pass) {
      const Eigen::Vector2d corner =
          seen + Eigen::Vector2d(0.5 * (size_.width - 1), 0.5 * (size_.height - 1)) -
          linear * (Eigen::Vector2d(middle, middle) - found);
      const kernels::Affine map{static_cast<float>(linear(0, 0)),
                                static_cast<float>(linear(0, 1)),
                                static_cast<float>(corner.x()),
                                static_cast<float>(linear(1, 0)),
                                static_cast<float>(linear(1, 1)),
                                static_cast<float>(corner.y())};
      ok = Inside(map, current) && MeasureBlock(reference, current, i, map, search_px, shift.block);
      found += shift.block.shift;
    }
    if (!ok) continue;
    shift.block.shift = found;
    shift.seen = seen + linear * shift.block.shift - bend;
    shift.current_from_reference = linear;
    shift.index = i;
    shift.rho = height;
    shifts.push_back(shift);
  }
}

}  // namespace ceilmap::registration
