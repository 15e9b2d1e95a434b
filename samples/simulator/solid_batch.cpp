// Intersection of many rays with one solid, in loops that compilers vectorise.

#include <algorithm>
#include <opencv2/core/hal/hal.hpp>

#include "samples/simulator/solid_in_view.hpp"

namespace ceilmap::simulator {
namespace {

constexpr float kMiss = 1e30F;

/// The component of the ray (x, y, 1) along an axis of the solid.
struct Component {
  float of_x;
  float of_y;
  float constant;
  Component(const Eigen::Matrix3f& R_solid_cam, int axis)
      : of_x(R_solid_cam(axis, 0)), of_y(R_solid_cam(axis, 1)), constant(R_solid_cam(axis, 2)) {}
  [[nodiscard]] float Of(float x, float y) const { return of_x * x + of_y * y + constant; }
};

struct Entries {
  RayBatch::Array<float> enter;
  RayBatch::Array<float> leave;
  RayBatch::Array<std::int32_t> face;
};

void KeepNearer(const Entries& entries, std::int32_t number, RayBatch& rays) {
  for (int i = 0; i < rays.count; ++i) {
    const float enter = entries.enter[i];
    if (!(enter > 0 && enter < entries.leave[i] && enter < rays.distance[i])) continue;
    rays.distance[i] = enter;
    rays.face[i] = entries.face[i];
    rays.solid[i] = number;
  }
}

}  // namespace

void SolidInView::EnterNearer(RayBatch& rays, std::int32_t number) const {
  is_round_ ? EnterCylinderNearer(rays, number) : EnterBoxNearer(rays, number);
}

void SolidInView::EnterBoxNearer(RayBatch& rays, std::int32_t number) const {
  const Component x_axis(R_solid_cam_, 0);
  const Component y_axis(R_solid_cam_, 1);
  const Component z_axis(R_solid_cam_, 2);
  const Eigen::Vector3f low = (low_ - camera_).cast<float>();
  const Eigen::Vector3f high = (high_ - camera_).cast<float>();
  const float x0 = low.x();
  const float x1 = high.x();
  const float y0 = low.y();
  const float y1 = high.y();
  const float z0 = low.z();
  const float z1 = high.z();
  // The camera sees at most one of two opposite faces.
  const int face_x = x0 > 0 ? 0 : 1;
  const int face_y = y0 > 0 ? 2 : 3;
  const int face_z = z0 > 0 ? 4 : 5;
  Entries entries;
  for (int i = 0; i < rays.count; ++i) {
    const float inverse_x = 1 / x_axis.Of(rays.x[i], rays.y[i]);
    const float inverse_y = 1 / y_axis.Of(rays.x[i], rays.y[i]);
    const float inverse_z = 1 / z_axis.Of(rays.x[i], rays.y[i]);
    const float in_x = std::min(x0 * inverse_x, x1 * inverse_x);
    const float in_y = std::min(y0 * inverse_y, y1 * inverse_y);
    const float in_z = std::min(z0 * inverse_z, z1 * inverse_z);
    const float out_x = std::max(x0 * inverse_x, x1 * inverse_x);
    const float out_y = std::max(y0 * inverse_y, y1 * inverse_y);
    const float out_z = std::max(z0 * inverse_z, z1 * inverse_z);
    const float in_xy = std::max(in_x, in_y);
    const int face_xy = in_x >= in_y ? face_x : face_y;
    entries.enter[i] = std::max(in_xy, in_z);
    entries.leave[i] = std::min(std::min(out_x, out_y), out_z);
    entries.face[i] = in_xy >= in_z ? face_xy : face_z;
  }
  KeepNearer(entries, number, rays);
}

void SolidInView::EnterCylinderNearer(RayBatch& rays, std::int32_t number) const {
  const Component x_axis(R_solid_cam_, 0);
  const Component y_axis(R_solid_cam_, 1);
  const Component z_axis(R_solid_cam_, 2);
  const auto x0 = static_cast<float>(low_.x() - camera_.x());
  const auto x1 = static_cast<float>(high_.x() - camera_.x());
  const Eigen::Vector2f from = FromAxis(camera_).cast<float>();
  const float from_y = from.x();
  const float from_z = from.y();
  const auto c = static_cast<float>(FromAxis(camera_).squaredNorm() - radius_ * radius_);
  const int end = x0 > 0 ? 0 : 1;
  // |from + t (y, z)|^2 = radius^2, that is a t^2 + 2 b t + c = 0
  RayBatch::Array<float> a;
  RayBatch::Array<float> b;
  RayBatch::Array<float> square;
  RayBatch::Array<float> root;
  for (int i = 0; i < rays.count; ++i) {
    const float y = y_axis.Of(rays.x[i], rays.y[i]);
    const float z = z_axis.Of(rays.x[i], rays.y[i]);
    a[i] = y * y + z * z;
    b[i] = from_y * y + from_z * z;
    square[i] = b[i] * b[i] - a[i] * c;
    root[i] = std::max(square[i], 0.0F);
  }
  cv::hal::sqrt32f(root.data(), root.data(), rays.count);
  Entries entries;
  for (int i = 0; i < rays.count; ++i) {
    const float inverse_x = 1 / x_axis.Of(rays.x[i], rays.y[i]);
    const float in_side = (-b[i] - root[i]) / a[i];
    const float in_x = std::min(x0 * inverse_x, x1 * inverse_x);
    const float out_x = std::max(x0 * inverse_x, x1 * inverse_x);
    const float in = std::max(in_side, in_x);
    entries.enter[i] = square[i] > 0 ? in : kMiss;
    entries.leave[i] = std::min((root[i] - b[i]) / a[i], out_x);
    entries.face[i] = in_side > in_x ? 2 : end;
  }
  KeepNearer(entries, number, rays);
}

}  // namespace ceilmap::simulator
