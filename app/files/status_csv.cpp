#include "app/files/status_csv.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::files {
namespace {

// Columns of a status file that are read.
class StatusColumns {
 public:
  explicit StatusColumns(const CsvTable& table)
      : table_(table),
        stamp_(table.Column("timestamp")),
        status_(table.Column("status")),
        x_(table.Column("x")),
        y_(table.Column("y")),
        yaw_(table.Column("yaw_deg")),
        pitch_(table.Column("pitch_deg")),
        roll_(table.Column("roll_deg")),
        sigma_x_(table.Column("sigma_x")),
        sigma_y_(table.Column("sigma_y")),
        sigma_yaw_(table.Column("sigma_yaw_deg")) {}

  [[nodiscard]] double Stamp(const CsvTable::Row& row) const { return table_.Number(row, stamp_); }
  [[nodiscard]] const std::string& Status(const CsvTable::Row& row) const {
    return row.fields[status_];
  }
  [[nodiscard]] bool HasPose(const CsvTable::Row& row) const { return !row.fields[x_].empty(); }

  [[nodiscard]] StampedPose Pose(const CsvTable::Row& row) const {
    Tilt tilt;
    tilt.pitch_rad = Angle(row, pitch_);
    tilt.roll_rad = Angle(row, roll_);
    return ToStampedPose(
        Stamp(row), {table_.Number(row, x_), table_.Number(row, y_), Angle(row, yaw_)}, tilt);
  }

  [[nodiscard]] Eigen::Matrix3d Covariance(const CsvTable::Row& row) const {
    const Eigen::Vector3d sigmas(
        table_.Number(row, sigma_x_), table_.Number(row, sigma_y_), Angle(row, sigma_yaw_));
    if (!(sigmas.minCoeff() >= 0)) {
      throw InputError(fmt::format("{}: a standard deviation is negative", table_.Place(row)));
    }
    return sigmas.cwiseAbs2().asDiagonal();
  }

 private:
  [[nodiscard]] double Angle(const CsvTable::Row& row, std::size_t column) const {
    return kRadPerDeg * table_.Number(row, column);
  }

  const CsvTable& table_;
  std::size_t stamp_, status_, x_, y_, yaw_, pitch_, roll_, sigma_x_, sigma_y_, sigma_yaw_;
};

}  // namespace

graph::TrackingStatus StatusNamed(const std::string& word, bool placed) {
  using Status = graph::TrackingStatus;
  for (const Status status : {Status::kTracking,
                              Status::kRelocalized,
                              Status::kPredicted,
                              Status::kAmbiguous,
                              Status::kLost}) {
    if (word == graph::ToString(status)) return status;
  }
  return placed ? Status::kTracking : Status::kLost;
}

std::string_view StatusHeader() {
  return "timestamp,status,x,y,yaw_deg,pitch_deg,roll_deg,sigma_x,sigma_y,sigma_yaw_deg,peak,"
         "inliers\n";
}

std::string FormatStatusLine(const robot::Estimate& estimate) {
  const char* const status = graph::ToString(estimate.status);
  if (!estimate.HasPose() && estimate.status != graph::TrackingStatus::kPredicted)
    return fmt::format("{:.6f},{},,,,,,,,,,\n", estimate.stamp_s, status);
  const Pose2& pose = estimate.pose.pose;
  const auto sigma = [&](int i) { return std::sqrt(estimate.pose.covariance(i, i)); };
  // The pitch and roll of a level robot are exactly 0.
  const auto tilt = [](double rad) {
    return rad == 0 ? std::string("0") : fmt::format("{:.5f}", kDegPerRad * rad);
  };
  return fmt::format("{:.6f},{},{:.6f},{:.6f},{:.5f},{},{},{:.6f},{:.6f},{:.5f},{:.3f},{}\n",
                     estimate.stamp_s,
                     status,
                     pose.x,
                     pose.y,
                     kDegPerRad * pose.yaw,
                     tilt(estimate.tilt.pitch_rad),
                     tilt(estimate.tilt.roll_rad),
                     sigma(0),
                     sigma(1),
                     kDegPerRad * sigma(2),
                     estimate.peak,
                     estimate.inliers);
}

StatusRecord ReadStatus(const std::filesystem::path& file) {
  return StatusIn(ReadCsv(file));
}

StatusRecord StatusIn(const CsvTable& table) {
  const StatusColumns columns(table);
  StatusRecord record;
  std::optional<double> last_s;
  for (const CsvTable::Row& row : table.rows) {
    const double stamp_s = columns.Stamp(row);
    if (last_s && stamp_s <= *last_s) {
      throw InputError(fmt::format(
          "{}: timestamp {} is not later than {} before it", table.Place(row), stamp_s, *last_s));
    }
    last_s = stamp_s;
    ++record.frames[columns.Status(row)];
    const graph::TrackingStatus status = StatusNamed(columns.Status(row), columns.HasPose(row));
    const bool placed = columns.HasPose(row) && status != graph::TrackingStatus::kPredicted;
    (placed ? record.placed : record.unplaced).push_back({stamp_s, status});
    if (!placed) continue;
    record.poses.push_back(columns.Pose(row));
    record.covariances.push_back(columns.Covariance(row));
  }
  return record;
}

}  // namespace ceilmap::files
