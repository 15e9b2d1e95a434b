#include "localization/compass/methods.hpp"

namespace ceilmap::compass {

std::unique_ptr<Compass> MakeCompass(const CompassParams& params) {
  switch (params.method) {
    case Method::kLabrosse2004:
      return std::make_unique<Labrosse2004>(params.labrosse2004);
    case Method::kLabrosse2006:
      return std::make_unique<Labrosse2006>(params.labrosse2006);
    case Method::kFft:
      break;
  }
  return std::make_unique<FftCompass>(params.fft);
}

}  // namespace ceilmap::compass
