#include "app/map_quality.hpp"

namespace ceilmap::app {

nlohmann::ordered_json ToJson(const mapping::LoopCounts& loops) {
  return {{"compared", loops.compared},
          {"accepted", loops.accepted - loops.outliers},
          {"no_match", loops.no_match},
          {"ambiguous", loops.ambiguous},
          {"off_prediction", loops.off_prediction},
          {"unconfirmed", loops.unconfirmed},
          {"outliers", loops.outliers}};
}

}  // namespace ceilmap::app
