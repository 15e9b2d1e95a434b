#pragma once

#include <optional>
#include <vector>

#include "mapping/registration/fine_stage.hpp"
#include "mapping/registration/registrar.hpp"
#include "mapping/registration/registration.hpp"

/// The choice among several motions that explain two images. Internal to the registrar.
namespace ceilmap::registration {

/// Whether two motions are different hypotheses, and not one motion measured twice.
bool Differ(const ImageMotion& a, const ImageMotion& b);

/// The candidates that explain the images about as well as the best one, best first. Blocks of
/// tiles agree with many motions at low resolution, so the limit is wide. @param ratio  Of the best
/// one's agreement.
std::vector<Candidate> NearlyBest(std::vector<Candidate> candidates, double ratio);

/// Accepted finalists that agree about as well as the best one; at least the best one itself.
/// @param finalists  not empty.
std::vector<Finalist> Rivals(std::vector<Finalist> finalists, double ratio);

/// Squared distance of a motion from the prior, in standard deviations.
double PriorDistance2(const MotionPrior& prior, const ImageMotion& motion);

/// Moves the rival that the prior prefers to the front. @param rivals  at least two if there is a
/// prior. @return whether the prior determines the choice.
bool ChooseByPrior(const std::optional<MotionPrior>& prior, std::vector<Finalist>& rivals);

/// For encoded or rectified images (SmoothingCounts): the finalist that agrees best among those
/// that the prior predicts, although its verdict is kNoMatch (mapping/registration/README.md,
/// "Encoded images"); nothing where none agrees sufficiently. @param encoded  CodecCounts:
/// agreement is sufficient; otherwise the images must be alike but for the errors of drawing.
std::optional<Registration> FindExpected(const std::vector<Finalist>& finalists,
                                         const MotionPrior& prior,
                                         bool encoded);

}  // namespace ceilmap::registration
