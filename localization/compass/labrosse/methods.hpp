#pragma once

#include <cstdint>
#include <memory>

#include "localization/compass/compass.hpp"
#include "localization/compass/fft_compass.hpp"
#include "localization/compass/labrosse/labrosse2004.hpp"
#include "localization/compass/labrosse/labrosse2006.hpp"

namespace ceilmap::labrosse {

enum class Method : std::uint8_t {
  kFft,           ///< recommended: least drift, least time
  kLabrosse2006,  ///< as published
  kLabrosse2004
};

struct CompassParams {
  Method method = Method::kFft;
  // Only the parameters of the selected method are used.
  compass::FftCompassParams fft = {};
  Labrosse2006Params labrosse2006 = {};
};

/// @throws InputError on parameters of the method outside their range.
std::unique_ptr<compass::Compass> MakeCompass(const CompassParams& params);

}  // namespace ceilmap::labrosse
