#include "localization/compass/labrosse/methods.hpp"

namespace ceilmap::labrosse {

std::unique_ptr<compass::Compass> MakeCompass(const CompassParams& params) {
  switch (params.method) {
    case Method::kLabrosse2004:
      return std::make_unique<Labrosse2004>();
    case Method::kLabrosse2006:
      return std::make_unique<Labrosse2006>(params.labrosse2006);
    case Method::kFft:
      break;
  }
  return std::make_unique<compass::FftCompass>(params.fft);
}

}  // namespace ceilmap::labrosse
