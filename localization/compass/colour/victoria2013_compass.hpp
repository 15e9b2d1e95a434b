#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "calib/rig.hpp"
#include "localization/compass/colour/colour_compass.hpp"
#include "localization/compass/colour/colour_model.hpp"
#include "localization/compass/colour/colour_query.hpp"

namespace ceilmap::colour {

/// What the query takes as the "previous orientation".
enum class PreviousHeading {
  /// Nothing: the factor 1 / diff(alpha) is left out, and each frame is answered by itself.
  kNone,
  /// The last result plus the turn since then, as measured on the images (StripTurn). The robot of
  /// the paper has odometry for that.
  kTurned,
  /// The last result itself. The factor then pulls towards a heading that has passed; in rendered
  /// rooms it holds the first one (README).
  kHeld,
};

/// The answer of one cell: "orientations are computed for grid cells containing at least 20% of the
/// hypotheses".
struct CellOrientation {
  int cell = 0;
  double heading_rad = 0;  ///< in (-pi, pi]
  double score = 0;        ///< sum of similarities; comparable between the cells of a frame
};

/// Absolute heading from colours, as the paper prints it: Methenitis, de Kok, Nugteren, Visser,
/// "Orientation finding using a grid based visual compass" (ViCTORiA), BNAIC 2013, section 3.4.
/// ColourCompass is this project's own query of the same models; its results are better (README).
///
/// Of each asked cell, the heading psi is returned that maximises
///
///     score(psi) = sum over lines i of sim(f_i, g_b),    b: the bin that contains psi + azimuth_i
///     sim(f, g)  = 1 / diff(l_f, l_g) * 1 / diff(alpha_f, alpha_g) * 1 / diff(f, g) * m(f) * m(g)
///     m(g)       = e^(-(t - t_g) / fading_s) * p(l_g) * p(alpha_g)
///
/// over psi = 0, 1, ... bins - 1 times the width of a bin. The heading of the frame is that of the
/// cell with the largest score.
///
/// The paper leaves open, and here is:
/// - How similarities of lines give an orientation. "A collection of features obtained from one
///   image" is compared; their similarities are added. A bin without an observation adds 0, which a
///   product could not express.
/// - alpha_f, the direction of a line before its heading is known. The paper queries with the
///   "previous orientation"; alpha_f is the previous heading plus the azimuth. For all lines,
///   diff(alpha_f, alpha_g) is then |psi - previous heading|. PreviousHeading has the choices; in
///   the first frame, and after a turn that could not be measured, there is none, and the factor
///   is 1.
/// - Differences of zero: SimilarityLimits. diff(f, g): FeatureDifference.
/// - m(f) of the asking frame: its age is 0; p(l_f) is the ratio of the position hypotheses in the
///   cell ("certainty about the robot's position can be expressed as the number of hypotheses, in a
///   grid cell"); p(alpha_f) is the same for all psi and therefore 1.
/// - p(l_g), p(alpha_g) and the sign and unit of time in m: Replace, FadedCertainty. The age is
///   counted from the newest observation of the model: a common factor, and a model that is days
///   old does not vanish in rounding.
/// - Without position hypotheses all cells that have learned are asked, with equal p(l), and the
///   factor of distance is 1.
/// - "When similar enough matches have been found" the model is updated: left to the caller, who
///   calls Learn; see `confidence` below.
/// - Colours of no class, and exposure: not in the paper. A line's transitions with colours of no
///   class are not counted; exposure is not compensated.
///
/// The paper has neither variance nor confidence. Both are of the frame alone, without the factor
/// of the previous heading. `confidence` is 1 - (s_2 / s_1)^5: s_1 is the score of the heading, s_2
/// the largest one more than 20 deg away from it in any asked cell, 5 the number of independent
/// lines that ten lines are worth. `variance_rad2` is that of the headings around it whose scores
/// are above half of s_1, plus a bin's width squared over 12.
class Victoria2013Compass final : public ColourQuery {
 public:
  /// @param model  Of ModelKind::kVictoria2013 or kVictoria.
  /// @param params  Its lines, and the position of the camera; the rest is not in the paper.
  /// @throws InputError on another or an empty model, or invalid parameters.
  Victoria2013Compass(ColourModel model,
                      const calib::MountedCamera& forward,
                      const ColourCompassParams& params = {},
                      PreviousHeading previous = PreviousHeading::kTurned);
  ~Victoria2013Compass() override;
  Victoria2013Compass(Victoria2013Compass&&) noexcept;
  Victoria2013Compass& operator=(Victoria2013Compass&&) noexcept;

  std::optional<ColourHeading> Next(const ColourFrame& frame) override;
  /// By Replace.
  void Learn(const LearnedPose& pose) override;
  void Reset() override;
  [[nodiscard]] const ColourModel& Model() const override;
  [[nodiscard]] const ColourCounts& Counts() const override;

  /// The answers of all cells that were asked by the last Next; the best one first.
  [[nodiscard]] std::span<const CellOrientation> Orientations() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::colour
