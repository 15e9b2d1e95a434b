#include "calib/wheels/wheels_report.hpp"

namespace ceilmap::wheels {

WheelsReport::WheelsReport(const DeadReckoning& reckoning,
                           const WheelCalibrator& calibrator,
                           std::int64_t missing_frames)
    : samples(reckoning.Samples()),
      gyro(reckoning.HasGyro()),
      gyro_stuck_s(reckoning.StuckSeconds()),
      missing(missing_frames),
      model(calibrator.Model()),
      pieces(calibrator.Pieces()),
      slips(calibrator.Slips()),
      fault(calibrator.Fault()),
      travel_ratio(calibrator.TravelRatio()),
      turn_ratio(calibrator.TurnRatio()) {}

}  // namespace ceilmap::wheels
