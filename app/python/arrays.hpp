#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <tuple>
#include <type_traits>
#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/base/stamped_pose.hpp"
#include "mapping/graph/keyframe.hpp"

/// Images, matrices and tables as numpy arrays, and back.
namespace ceilmap::python {

namespace py = pybind11;

/// (x, y, yaw) as Python's tuple.
std::tuple<double, double, double> ToTuple(const Pose2& pose);
/// (x, y, yaw) from a tuple, list or array.
using PoseNumbers = std::array<double, 3>;
/// @throws InputError when a number is not finite. @param name  of the argument, for messages.
Pose2 ToPose(const PoseNumbers& pose, const char* name);

/// The pixels of an array, not copied: valid as long as the array. Rows may have a distance, as
/// those of a part of an image; the pixels of a row may not.
/// @param name  of the argument, for messages. @param colour  whether (height, width, 3) is valid
///   besides (height, width).
/// @throws InputError on another dtype than uint8, another shape or another layout.
cv::Mat ImageView(const py::array& array, const char* name, bool colour = false);

/// An image of one or three channels of 8 bits. The array shares its pixels and keeps them.
py::array ToArray(const cv::Mat& image);

py::array ToArray(const Eigen::Ref<const Eigen::MatrixXd>& matrix);
/// @throws InputError unless the array is 3 x 3, symmetric and finite, with a positive diagonal.
Eigen::Matrix3d ToCovariance(const py::array& array, const char* name);

/// Poses as the lines of a trajectory file: (N, 8), stamp, x, y, z, qx, qy, qz, qw.
py::array ToArray(const std::vector<StampedPose>& poses);
/// Such poses, or (N, 4): stamp, x, y, yaw of a level robot.
/// @throws InputError unless there is at least one, stamps strictly increase, all numbers are
///   finite, and quaternions have unit length (to 1e-3).
std::vector<StampedPose> ToPoses(const py::array& array, const char* name);

/// A word of up to 11 characters, as numpy's U12 holds it.
using Word = std::array<char32_t, 12>;
Word ToWord(const char* text);

/// A column of a structured array.
struct Column {
  const char* name;
  const char* format;  ///< as numpy's dtype, e.g. "f8"
  std::size_t offset;  ///< in the row
  int side = 0;        ///< > 0: a square matrix
};

/// A structured array without rows' types: `size` bytes each.
py::array MakeTable(const void* rows,
                    std::size_t count,
                    std::size_t size,
                    const std::vector<Column>& columns);
template <typename Row>
py::array MakeTable(const std::vector<Row>& rows, const std::vector<Column>& columns) {
  static_assert(std::is_trivially_copyable_v<Row> && std::is_standard_layout_v<Row>);
  return MakeTable(rows.data(), rows.size(), sizeof(Row), columns);
}

/// Frames as a structured array: stamp, frame, status, x, y, yaw, pitch, roll, lift, covariance,
/// keyframe.
py::array ToTable(const std::vector<graph::FramePose>& frames);
py::array ToTable(const std::vector<graph::Keyframe>& keyframes);  ///< and id, ambiguous

/// The poses of frames as lines of a trajectory file.
std::vector<StampedPose> ToStampedPoses(const std::vector<graph::FramePose>& frames);

}  // namespace ceilmap::python
