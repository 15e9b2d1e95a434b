#include "mapping/registration/block_stage.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mapping/registration/coarse.hpp"
#include "mapping/registration/kernels.hpp"

namespace ceilmap::registration {
namespace {

kernels::Affine SamplingMap(const ImageMotion& motion, cv::Size size, cv::Point corner) {
  // Block pixel (x, y) is reference pixel corner + (x, y); it is seen at s R (p - c) + t + c.
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

// Gaussian weight over the half spectrum of an n x n block; the mean is left out.
std::vector<float> GaussianBand(int n, double sigma) {
  std::vector<float> band;
  for (int row = 0; row < n; ++row) {
    const double ky = static_cast<double>(row <= n / 2 ? row : row - n) / n;
    for (int col = 0; col <= n / 2; ++col) {
      const double kx = static_cast<double>(col) / n;
      band.push_back(static_cast<float>(std::exp(-(kx * kx + ky * ky) / (2 * sigma * sigma))));
    }
  }
  band[0] = 0;
  return band;
}

}  // namespace

BlockStage::BlockStage(cv::Size size, const BlockParams& params)
    : params_(params),
      size_(size),
      fft_(RealFft::Plane(params.block_px, params.block_px)),
      window_(TukeyWindow(params.block_px, params.taper)) {
  const int block = params.block_px;
  // One pixel of margin on the near sides and two on the far ones: the reach of bicubic sampling.
  const int room_x = size.width - block - 4;
  const int room_y = size.height - block - 4;
  if (room_x >= 0 && room_y >= 0) {
    const double area = static_cast<double>(room_x + block) * (room_y + block);
    const double step = std::max(block / 2.0, std::sqrt(area / params.target_blocks));
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
  double power = 0;
  for (const float w : window_) power += w * w;
  window_power_ = power * power;
  band_ = GaussianBand(block, params.band_sigma);
  samples_ = RealArray(fft_.RealSize());
  surface_ = RealArray(fft_.RealSize());
  spectrum_ = ComplexArray(fft_.SpectrumSize());
  cross_ = ComplexArray(fft_.SpectrumSize());
}

void BlockStage::PrepareReference(Level& level) const {
  RealArray samples(fft_.RealSize());
  const int block = params_.block_px;
  const int half = block / 2 + 1;
  const double noise = params_.noise_factor * level.noise_sigma * level.noise_sigma * window_power_;
  level.blocks.resize(corners_.size());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    kernels::SampleCubicWindowed(level.grey.data(),
                                 size_.width,
                                 SamplingMap({}, size_, corners_[i]),
                                 window_.data(),
                                 window_.data(),
                                 block,
                                 block,
                                 samples.data());
    ReferenceBlock& out = level.blocks[i];
    out.spectrum = ComplexArray(fft_.SpectrumSize());
    fft_.Forward({samples.data(), samples.size()}, {out.spectrum.data(), out.spectrum.size()});
    // What the block can tell: the sharpness that its correlation peak will have in its worst
    // direction.
    Eigen::Matrix2d sharpness = Eigen::Matrix2d::Zero();
    for (int row = 0; row < block; ++row) {
      const double ky = row <= block / 2 ? row : row - block;
      for (int col = 0; col < half; ++col) {
        const auto k = static_cast<std::size_t>(row * half + col);
        const double power = std::norm(out.spectrum[k]);
        const double weight = band_[k] * power / (power + noise);
        sharpness += weight * Eigen::Vector2d(col, ky) * Eigen::RowVector2d(col, ky);
      }
    }
    out.texture = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(sharpness, Eigen::EigenvaluesOnly)
                      .eigenvalues()[0];
  }
}

bool BlockStage::Inside(const ImageMotion& motion, cv::Point corner) const {
  const kernels::Affine m = SamplingMap(motion, size_, corner);
  const auto last = static_cast<float>(params_.block_px - 1);
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
  return true;
}

std::vector<int> BlockStage::Select(const Level& reference,
                                    const ImageMotion& motion,
                                    int count) const {
  std::vector<int> inside;
  for (int i = 0; i < GridSize(); ++i) {
    if (Inside(motion, corners_[static_cast<std::size_t>(i)])) inside.push_back(i);
  }
  if (static_cast<int>(inside.size()) <= count) return inside;
  const auto texture = [&](int i) { return reference.blocks[static_cast<std::size_t>(i)].texture; };
  // Neighbourhoods of 2x2 grid places; the best of each, then the second best of each, ...
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

BlockShift BlockStage::Peak(int search_px, double total) const {
  const int n = params_.block_px;
  const auto at = [&](int x, int y) {
    return surface_[static_cast<std::size_t>(((y + n) % n) * n + (x + n) % n)];
  };
  float best = -1e30F;
  int bx = 0;
  int by = 0;
  for (int y = -search_px; y <= search_px; ++y) {
    const float* row = surface_.data() + static_cast<std::ptrdiff_t>((y + n) % n) * n;
    for (int x = -search_px; x <= search_px; ++x) {
      const float value = row[(x + n) % n];
      if (value > best) {
        best = value;
        bx = x;
        by = y;
      }
    }
  }
  BlockShift shift;
  if (!(best > 0) || !(total > 0)) return shift;
  // Logarithms of the 3x3 neighbourhood: exact for the Gaussian peak of a Gaussian band. Samples
  // that are too low to be part of the peak are held at a twentieth of it.
  std::array<std::array<double, 3>, 3> v{};
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      v[static_cast<std::size_t>(j + 1)][static_cast<std::size_t>(i + 1)] =
          std::log(std::max(at(bx + i, by + j) / best, 0.05F));
    }
  }
  const Eigen::Vector2d gradient(0.5 * (v[1][2] - v[1][0]), 0.5 * (v[2][1] - v[0][1]));
  Eigen::Matrix2d hessian;
  hessian(0, 0) = -(v[1][2] + v[1][0] - 2 * v[1][1]);
  hessian(1, 1) = -(v[2][1] + v[0][1] - 2 * v[1][1]);
  hessian(0, 1) = hessian(1, 0) = -0.25 * (v[2][2] - v[2][0] - v[0][2] + v[0][0]);
  // At a maximum both curvatures are positive; the mixed one is kept from making the form
  // indefinite.
  const double limit = 0.95 * std::sqrt(std::max(hessian(0, 0) * hessian(1, 1), 0.0));
  hessian(0, 1) = hessian(1, 0) = std::clamp(hessian(0, 1), -limit, limit);
  hessian.diagonal().array() += 1e-4;
  const Eigen::Vector2d offset = hessian.inverse() * gradient;
  shift.shift = Eigen::Vector2d(bx, by) + offset.cwiseMax(-1.0).cwiseMin(1.0);
  shift.peak = std::clamp(best / total, 0.0, 1.0);
  const double full_sharpness = std::pow(2 * std::numbers::pi * params_.band_sigma, 2);
  shift.sharpness = hessian / full_sharpness;
  shift.quality = shift.peak * shift.peak / (1.05 - shift.peak * shift.peak);
  return shift;
}

void BlockStage::SampleBlock(const Level& level, const ImageMotion& motion, cv::Point corner) {
  kernels::SampleCubicWindowed(level.grey.data(),
                               size_.width,
                               SamplingMap(motion, size_, corner),
                               window_.data(),
                               window_.data(),
                               params_.block_px,
                               params_.block_px,
                               samples_.data());
}

BlockStage::Dissimilarity BlockStage::Compare(const Level& reference,
                                              const Level& current,
                                              const ImageMotion& motion) {
  // Sampling and compression leave about this part of a block's energy unexplained even under the
  // true motion.
  constexpr double kUnexplained = 0.02;
  const double noise =
      static_cast<double>(reference.noise_sigma) * current.noise_sigma * window_power_;
  Dissimilarity result;
  const auto n = static_cast<Eigen::Index>(samples_.size());
  Eigen::VectorXf wanted(n);
  for (const cv::Point corner : corners_) {
    if (!Inside(motion, corner)) continue;
    SampleBlock(reference, {}, corner);
    wanted = Eigen::Map<const Eigen::VectorXf>(samples_.data(), n);
    SampleBlock(current, motion, corner);
    const Eigen::Map<const Eigen::VectorXf> seen(samples_.data(), n);
    const double energy = std::sqrt(static_cast<double>(wanted.squaredNorm()) * seen.squaredNorm());
    const double common = wanted.dot(seen);
    const double unlike =
        energy > 0 ? energy * (1 - std::pow(std::max(common, 0.0) / energy, 2)) : 0.0;
    result.mean += std::log1p(unlike / (noise + kUnexplained * energy + 1e-9));
    ++result.blocks;
  }
  if (result.blocks > 0) result.mean /= result.blocks;
  return result;
}

void BlockStage::Measure(const Level& reference,
                         const Level& current,
                         const ImageMotion& motion,
                         const std::vector<int>& chosen,
                         int search_px,
                         std::vector<BlockShift>& shifts) {
  const int block = params_.block_px;
  const auto noise = static_cast<float>(params_.noise_factor * reference.noise_sigma *
                                        current.noise_sigma * window_power_);
  shifts.clear();
  for (const int i : chosen) {
    const cv::Point corner = corners_[static_cast<std::size_t>(i)];
    if (!Inside(motion, corner)) continue;
    SampleBlock(current, motion, corner);
    fft_.Forward({samples_.data(), samples_.size()}, {spectrum_.data(), spectrum_.size()});
    const double total =
        kernels::CrossSpectrum(reference.blocks[static_cast<std::size_t>(i)].spectrum.data(),
                               spectrum_.data(),
                               band_.data(),
                               noise,
                               false,
                               block,
                               block / 2 + 1,
                               true,
                               cross_.data());
    fft_.Inverse({cross_.data(), cross_.size()}, {surface_.data(), surface_.size()});
    BlockShift shift = Peak(search_px, total);
    if (shift.peak <= 0) continue;
    shift.point = Eigen::Vector2d(corner.x + 0.5 * (block - 1) - 0.5 * (size_.width - 1),
                                  corner.y + 0.5 * (block - 1) - 0.5 * (size_.height - 1));
    shifts.push_back(shift);
  }
}

}  // namespace ceilmap::registration
