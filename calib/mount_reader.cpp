#include "calib/mount_reader.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <optional>
#include <vector>

namespace ceilmap::calib {
namespace {

/// Tolerance for values rounded to three or four digits by hand, in rad or m; a larger difference
/// is an error.
constexpr double kRotationTolerance = 1e-3;

/// The nearest rotation to a matrix that is nearly one, in the least-squares sense.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& R) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Eigen::Isometry3d ParsePoseMatrix(const YamlValue& value) {
  const std::vector<double> m = value.Numbers(16);
  const auto rows = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(m.data());
  if (rows.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    value.Fail("a 4 x 4 pose whose last row is 0, 0, 0, 1", "write R and t row by row");
  }
  const Eigen::Matrix3d R = rows.topLeftCorner<3, 3>();
  const double skew = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (skew > kRotationTolerance || R.determinant() < 0) {
    value.Fail("a pose with an orthonormal, right-handed rotation (R R^T = 1, det R = +1)",
               "correct it, or give translation and rotation_xyzw instead");
  }
  Eigen::Isometry3d T_base_cam = Eigen::Isometry3d::Identity();
  T_base_cam.linear() = NearestRotation(R);
  T_base_cam.translation() = rows.topRightCorner<3, 1>();
  return T_base_cam;
}

Eigen::Matrix3d ParseQuaternion(const YamlValue& value) {
  const std::vector<double> q = value.Numbers(4);
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (std::abs(rotation.norm() - 1) > kRotationTolerance) {
    constexpr double kMaxLength = 2;  // a longer one is hardly a rounded or scaled quaternion
    value.Fail("a quaternion [x, y, z, w] of length 1",
               rotation.norm() > kMaxLength ? "angles in degrees must be converted to one"
                                            : "divide it by its length");
  }
  return rotation.normalized().toRotationMatrix();
}

void CheckAgreement(const YamlValue& matrix,
                    const Eigen::Isometry3d& T_base_cam,
                    const std::optional<Eigen::Matrix3d>& R,
                    const std::optional<Eigen::Vector3d>& t) {
  constexpr auto kFix = "remove the one that is wrong";
  if (R) {
    const double angle = Eigen::AngleAxisd(T_base_cam.linear().transpose() * *R).angle();
    if (angle > kRotationTolerance) matrix.Fail("the same rotation as rotation_xyzw", kFix);
  }
  if (t && (T_base_cam.translation() - *t).norm() > kRotationTolerance) {
    matrix.Fail("the same translation as translation", kFix);
  }
}

}  // namespace

Eigen::Isometry3d ParseCameraPose(const YamlValue& pose, const Eigen::Matrix3d& R_default) {
  pose.AllowOnly({"frame", "translation", "rotation_xyzw", "matrix"});
  if (const auto frame = pose.Find("frame")) frame->Text();
  const auto matrix = pose.Find("matrix");
  const auto read_t = [](const YamlValue& v) { return Eigen::Vector3d(v.Numbers(3).data()); };
  if (!matrix) {
    Eigen::Isometry3d T_base_cam = Eigen::Isometry3d::Identity();
    const auto rotation = pose.Find("rotation_xyzw");
    T_base_cam.linear() = rotation ? ParseQuaternion(*rotation) : R_default;
    T_base_cam.translation() =
        read_t(pose.At("translation", "the camera's place [x, y, z] in base_link, in metres"));
    return T_base_cam;
  }
  Eigen::Isometry3d T_base_cam = ParsePoseMatrix(*matrix);
  std::optional<Eigen::Matrix3d> R;
  std::optional<Eigen::Vector3d> t;
  if (const auto value = pose.Find("rotation_xyzw")) R = ParseQuaternion(*value);
  if (const auto value = pose.Find("translation")) t = read_t(*value);
  CheckAgreement(*matrix, T_base_cam, R, t);
  return T_base_cam;
}

}  // namespace ceilmap::calib
