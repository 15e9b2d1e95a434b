#pragma once

#include <optional>

#include "mapping/heights/height_field.hpp"
#include "mapping/registration/depth_stage.hpp"
#include "mapping/registration/plane_search.hpp"

namespace ceilmap::registration {

/// The search for the motion between two images under a ceiling with depth: motions that are
/// expected, else hypotheses of the coarse stage, else of local features. DepthStage matches them;
/// two that agree nearly as well are ambiguous. Internal to the registrar.
class DepthSearch {
 public:
  /// The references must outlive the object.
  DepthSearch(CoarseStage& coarse,
              FineStage& fine,
              DepthStage& depth,
              const RegistrarParams& params)
      : coarse_(coarse), fine_(fine), depth_(depth), params_(params) {}

  /// @param known  Heights of the reference, on any grid. @param start  A motion near which the
  /// true one may be, as the prior's.
  Registration Find(FrameSpectrum::Data& reference,
                    const heights::HeightField& known,
                    FrameSpectrum::Data& current,
                    const std::optional<MotionPrior>& prior,
                    const std::optional<ImageMotion>& start);

 private:
  CoarseStage& coarse_;
  FineStage& fine_;
  DepthStage& depth_;
  const RegistrarParams& params_;
};

}  // namespace ceilmap::registration
