// How well two images agree under a motion that is known, and what they show at all; see
// fine_stage.hpp.

#include <utility>
#include <vector>

#include "mapping/registration/fine_stage.hpp"

namespace ceilmap::registration {
namespace {

// ReferenceBlock::content of a fine block that shows something. Those of plain ceilings have 0.23,
// and a quarter of them up to 0.3.
constexpr double kNoiseContent = 0.26;

// A block tells where it is if it is less similar to its surroundings, this many pixels of the fine
// level away, by this many nats. Plain ceilings rise by 0.02 in the mean and 0.2 at most.
constexpr double kTellingShiftPx = 24;
constexpr float kTellingNats = 0.3F;

}  // namespace

void FineStage::Compare(const FrameSpectrum::Data& reference,
                        const FrameSpectrum::Data& current,
                        Finalist& finalist) {
  if (finalist.dissimilarity.blocks > 0) return;
  finalist.dissimilarity = Compare(reference, current, finalist.result.motion);
}

Dissimilarity FineStage::Compare(const FrameSpectrum::Data& reference,
                                 const FrameSpectrum::Data& current,
                                 const ImageMotion& motion) {
  return CompareRough(
      reference, current, motion, WhitePower(reference.rough.noise, current.rough.noise));
}

double FineStage::TexturedRatio(FrameSpectrum::Data& data) {
  PrepareFine(data);
  int textured = 0;
  int blocks = 0;
  for (const ReferenceBlock& block : data.fine.blocks) {
    if (block.blank) continue;
    ++blocks;
    textured += block.content > kNoiseContent ? 1 : 0;
  }
  return blocks > 0 ? static_cast<double>(textured) / blocks : 0;
}

double FineStage::TellingRatio(const FrameSpectrum::Data& reference,
                               const FrameSpectrum::Data& current,
                               const ImageMotion& motion) {
  const Dissimilarity there = Compare(reference, current, motion);
  const double away_px = kTellingShiftPx * fine_frame_.factor;
  std::vector<float> rise(there.by_block.size(), 0);
  std::vector<int> compared(there.by_block.size(), 0);
  for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    ImageMotion other = motion;
    other.tx_px += x * away_px;
    other.ty_px += y * away_px;
    const Dissimilarity away = Compare(reference, current, other);
    for (std::size_t i = 0; i < rise.size(); ++i) {
      if (away.by_block[i] < 0 || there.by_block[i] < 0) continue;
      rise[i] += away.by_block[i] - there.by_block[i];
      ++compared[i];
    }
  }
  int telling = 0;
  int blocks = 0;
  for (std::size_t i = 0; i < rise.size(); ++i) {
    if (compared[i] == 0) continue;
    ++blocks;
    telling += rise[i] > kTellingNats * static_cast<float>(compared[i]) ? 1 : 0;
  }
  return blocks > 0 ? static_cast<double>(telling) / blocks : 0;
}

Dissimilarity FineStage::CompareRough(const FrameSpectrum::Data& reference,
                                      const FrameSpectrum::Data& current,
                                      const ImageMotion& motion,
                                      double noise_power) {
  const ImageMotion rough = rough_frame_.FromFull(fine_frame_.FromFull(motion));
  return rough_.Compare(reference.rough, current.rough, rough, noise_power);
}

}  // namespace ceilmap::registration
