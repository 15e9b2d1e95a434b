#include "app/python/arrays.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>
#include <string>

#include "calib/base/error.hpp"

namespace ceilmap::python {
namespace {

constexpr int kColours = 3;
constexpr py::ssize_t kTumColumns = 8;
constexpr py::ssize_t kPlanarColumns = 4;
constexpr double kUnitLengthTolerance = 1e-3;

std::string ShapeOf(const py::array& array) {
  return fmt::format("({})", fmt::join(array.shape(), array.shape() + array.ndim(), ", "));
}

// A row of the trajectory. The order of the columns is that of the documentation.
struct FrameRow {
  double stamp;
  std::int64_t frame;
  Word status;
  double x, y, yaw;
  double pitch, roll, lift;
  std::array<double, 9> covariance;
  std::int64_t keyframe;
};

struct KeyframeRow {
  std::int64_t id;
  FrameRow frame;
  bool ambiguous;
};

FrameRow ToRow(const graph::FramePose& frame) {
  FrameRow row{};
  row.stamp = frame.stamp_s;
  row.frame = frame.frame_index;
  row.status = ToWord(graph::ToString(frame.status));
  row.x = frame.T_map_base.x;
  row.y = frame.T_map_base.y;
  row.yaw = frame.T_map_base.yaw;
  row.pitch = frame.tilt.pitch_rad;
  row.roll = frame.tilt.roll_rad;
  row.lift = frame.tilt.lift_m;
  Eigen::Map<Eigen::Matrix3d>(row.covariance.data()) = frame.covariance;  // symmetric
  row.keyframe = frame.keyframe_id;
  return row;
}

// @param offset  of the FrameRow in the row.
std::vector<Column> FrameColumns(std::size_t offset) {
  std::vector<Column> columns = {{"stamp", "f8", offsetof(FrameRow, stamp)},
                                 {"frame", "i8", offsetof(FrameRow, frame)},
                                 {"status", "U12", offsetof(FrameRow, status)},
                                 {"x", "f8", offsetof(FrameRow, x)},
                                 {"y", "f8", offsetof(FrameRow, y)},
                                 {"yaw", "f8", offsetof(FrameRow, yaw)},
                                 {"pitch", "f8", offsetof(FrameRow, pitch)},
                                 {"roll", "f8", offsetof(FrameRow, roll)},
                                 {"lift", "f8", offsetof(FrameRow, lift)},
                                 {"covariance", "f8", offsetof(FrameRow, covariance), 3},
                                 {"keyframe", "i8", offsetof(FrameRow, keyframe)}};
  for (Column& column : columns) column.offset += offset;
  return columns;
}

StampedPose ToStamped(const double* row, py::ssize_t columns) {
  if (columns == kPlanarColumns) return ToStampedPose(row[0], {row[1], row[2], WrapAngle(row[3])});
  return {row[0], {row[1], row[2], row[3]}, Eigen::Quaterniond(row[7], row[4], row[5], row[6])};
}

}  // namespace

std::tuple<double, double, double> ToTuple(const Pose2& pose) {
  return {pose.x, pose.y, pose.yaw};
}

Pose2 ToPose(const PoseNumbers& pose, const char* name) {
  if (!std::isfinite(pose[0]) || !std::isfinite(pose[1]) || !std::isfinite(pose[2])) {
    throw InputError(fmt::format("{}: ({}) is not finite; give (x, y, yaw) in metres and radians",
                                 name,
                                 fmt::join(pose, ", ")));
  }
  return {pose[0], pose[1], WrapAngle(pose[2])};
}

cv::Mat ImageView(const py::array& array, const char* name, bool colour) {
  if (array.dtype().kind() != 'u' || array.dtype().itemsize() != 1) {
    throw InputError(fmt::format("{}: dtype is {}, must be uint8; convert it to 0..255 first",
                                 name,
                                 std::string(py::str(array.dtype()))));
  }
  const bool three = colour && array.ndim() == 3 && array.shape(2) == kColours;
  if (array.ndim() != 2 && !three) {
    throw InputError(fmt::format("{}: shape is {}, must be (height, width){}",
                                 name,
                                 ShapeOf(array),
                                 colour ? " or (height, width, 3), BGR"
                                        : "; convert colours to grey, e.g. by cv2.cvtColor"));
  }
  const py::ssize_t height = array.shape(0);
  const py::ssize_t width = array.shape(1);
  constexpr py::ssize_t kMaxSide = 1 << 20;
  if (height < 1 || width < 1 || height > kMaxSide || width > kMaxSide) {
    throw InputError(fmt::format("{}: shape is {}, must not be empty", name, ShapeOf(array)));
  }
  const py::ssize_t pixel = three ? kColours : 1;
  const bool packed =
      (width == 1 || array.strides(1) == pixel) && (!three || array.strides(2) == 1);
  if (!packed) {
    throw InputError(fmt::format(
        "{}: the pixels of a row are not contiguous; pass numpy.ascontiguousarray(...)", name));
  }
  if (height > 1 && array.strides(0) < width * pixel) {
    throw InputError(fmt::format(
        "{}: the rows do not follow each other; pass numpy.ascontiguousarray(...)", name));
  }
  return {static_cast<int>(height),
          static_cast<int>(width),
          three ? CV_8UC3 : CV_8UC1,
          const_cast<void*>(array.data()),  // NOLINT: not written to
          static_cast<std::size_t>(height > 1 ? array.strides(0) : width * pixel)};
}

py::array ToArray(const cv::Mat& image) {
  auto kept = std::make_unique<cv::Mat>(image);
  const py::capsule owner(kept.get(), [](void* mat) { delete static_cast<cv::Mat*>(mat); });
  const cv::Mat& pixels = *kept.release();
  std::vector<py::ssize_t> shape = {pixels.rows, pixels.cols};
  std::vector<py::ssize_t> strides = {static_cast<py::ssize_t>(pixels.step[0]),
                                      static_cast<py::ssize_t>(pixels.elemSize())};
  if (pixels.channels() > 1) {
    shape.push_back(pixels.channels());
    strides.push_back(1);
  }
  return {py::dtype::of<std::uint8_t>(), shape, strides, pixels.data, owner};
}

py::array ToArray(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  py::array_t<double> array({matrix.rows(), matrix.cols()});
  auto values = array.mutable_unchecked<2>();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) values(i, j) = matrix(i, j);
  }
  return array;
}

Eigen::Matrix3d ToCovariance(const py::array& array, const char* name) {
  const py::array_t<double, py::array::c_style | py::array::forcecast> values(array);
  if (values.ndim() != 2 || values.shape(0) != 3 || values.shape(1) != 3) {
    throw InputError(
        fmt::format("{}: shape is {}, must be (3, 3), of (x, y, yaw)", name, ShapeOf(array)));
  }
  Eigen::Matrix3d covariance =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
  if (!covariance.allFinite() || !covariance.isApprox(covariance.transpose()) ||
      !(covariance.diagonal().minCoeff() > 0)) {
    throw InputError(
        fmt::format("{}: must be finite and symmetric, with variances > 0 on its diagonal", name));
  }
  return covariance;
}

py::array ToArray(const std::vector<StampedPose>& poses) {
  py::array_t<double> array({static_cast<py::ssize_t>(poses.size()), kTumColumns});
  double* value = array.mutable_data();
  for (const StampedPose& pose : poses) {
    const Eigen::Vector3d& p = pose.position;
    const Eigen::Quaterniond& q = pose.orientation;
    for (const double number : {pose.stamp_s, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}) {
      *value++ = number;
    }
  }
  return array;
}

std::vector<StampedPose> ToPoses(const py::array& array, const char* name) {
  const py::array_t<double, py::array::c_style | py::array::forcecast> values(array);
  const py::ssize_t columns = values.ndim() == 2 ? values.shape(1) : 0;
  if ((columns != kTumColumns && columns != kPlanarColumns) || values.shape(0) < 1) {
    throw InputError(fmt::format(
        "{}: shape is {}, must be (N, 8): stamp, x, y, z, qx, qy, qz, qw, or (N, 4): stamp, x, y, "
        "yaw; N >= 1",
        name,
        ShapeOf(array)));
  }
  std::vector<StampedPose> poses;
  poses.reserve(static_cast<std::size_t>(values.shape(0)));
  for (py::ssize_t i = 0; i < values.shape(0); ++i) {
    const double* const row = values.data(i, 0);
    for (py::ssize_t j = 0; j < columns; ++j) {
      if (!std::isfinite(row[j])) {
        throw InputError(fmt::format("{}: row {} has a number that is not finite", name, i));
      }
    }
    poses.push_back(ToStamped(row, columns));
    const double length = poses.back().orientation.norm();
    if (std::abs(length - 1) > kUnitLengthTolerance) {
      throw InputError(
          fmt::format("{}: row {}: the quaternion's length is {:.6g}, must be 1", name, i, length));
    }
    if (i > 0 && !(row[0] > poses[poses.size() - 2].stamp_s)) {
      throw InputError(
          fmt::format("{}: row {}: the stamp is not later than the one before", name, i));
    }
  }
  return poses;
}

Word ToWord(const char* text) {
  Word word{};
  for (std::size_t i = 0; i + 1 < word.size() && text[i] != '\0'; ++i) {
    word[i] = static_cast<char32_t>(text[i]);
  }
  return word;
}

py::array MakeTable(const void* rows,
                    std::size_t count,
                    std::size_t size,
                    const std::vector<Column>& columns) {
  py::list names;
  py::list formats;
  py::list offsets;
  for (const Column& column : columns) {
    names.append(column.name);
    if (column.side > 0) {
      formats.append(py::make_tuple(column.format, py::make_tuple(column.side, column.side)));
    } else {
      formats.append(column.format);
    }
    offsets.append(column.offset);
  }
  const py::dtype type(names, formats, offsets, static_cast<py::ssize_t>(size));
  py::array table(type, std::vector<py::ssize_t>{static_cast<py::ssize_t>(count)});
  if (count > 0) std::memcpy(table.mutable_data(), rows, count * size);
  return table;
}

py::array ToTable(const std::vector<graph::FramePose>& frames) {
  std::vector<FrameRow> rows;
  rows.reserve(frames.size());
  for (const graph::FramePose& frame : frames) rows.push_back(ToRow(frame));
  return MakeTable(rows, FrameColumns(0));
}

py::array ToTable(const std::vector<graph::Keyframe>& keyframes) {
  std::vector<KeyframeRow> rows;
  rows.reserve(keyframes.size());
  for (const graph::Keyframe& keyframe : keyframes) {
    rows.push_back({keyframe.id, ToRow(keyframe.pose), keyframe.ambiguous});
  }
  std::vector<Column> columns = FrameColumns(offsetof(KeyframeRow, frame));
  columns.pop_back();  // of a keyframe it is its own id
  columns.insert(columns.begin(), {"id", "i8", offsetof(KeyframeRow, id)});
  columns.push_back({"ambiguous", "?", offsetof(KeyframeRow, ambiguous)});
  return MakeTable(rows, columns);
}

std::vector<StampedPose> ToStampedPoses(const std::vector<graph::FramePose>& frames) {
  std::vector<StampedPose> poses;
  poses.reserve(frames.size());
  for (const graph::FramePose& frame : frames) {
    poses.push_back(ToStampedPose(frame.stamp_s, frame.T_map_base, frame.tilt));
  }
  return poses;
}

}  // namespace ceilmap::python
