#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "calib/rig.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/scene.hpp"
#include "samples/simulator/solid.hpp"

namespace ceilmap::simulator {

/// rig.yaml of the scene's robot, in the format of calib::ParseRig.
std::string RigYaml(const Scene& scene);

/// Renders the images. A point p_map of the room appears at camera.Project(T_base_cam^-1
/// T_map_base^-1 p_map) of GetRig().up or .forward, to a few thousandths of a pixel; pixel (0, 0)
/// is the centre of the top-left pixel.
///
/// An image depends only on the scene and its frame: the noise is seeded by the scene's seed and
/// the frame's index, not by earlier images. All const members are thread-safe; threads share a
/// cache of the ceiling's texture (memory below 200 MB a camera, independent of the room's size).
class Renderer {
 public:
  /// @throws InputError when the scene is not valid.
  explicit Renderer(const Scene& scene);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// The upward camera's image: CV_8UC1 of the camera's size.
  [[nodiscard]] cv::Mat Render(const Frame& frame) const;
  /// The forward camera's image: of its size, CV_8UC1, or CV_8UC3 (blue, green, red) if
  /// forward.saturation is not 0. It is independent of Render(). @throws InputError when the scene
  /// has no forward camera.
  [[nodiscard]] cv::Mat RenderForward(const Frame& frame) const;
  /// The image of the camera under the mirror: CV_8UC3 of its size, blue, green, red. A point p_map
  /// appears where the mirror of OmniCamera reflects it, to a few hundredths of a pixel.
  /// @throws InputError when the scene has no omni camera.
  [[nodiscard]] cv::Mat RenderOmni(const Frame& frame) const;
  /// The light on the upward camera's pixels, before the effects of Image: CV_32FC1, 1 = white. A
  /// frame at T_map_base; without movers, motion blur, optical blur, vignetting, glare and noise.
  [[nodiscard]] cv::Mat RenderLight(const Eigen::Isometry3d& T_map_base) const;
  /// The same of the forward camera; CV_32FC3 in colours. @throws as RenderForward().
  [[nodiscard]] cv::Mat RenderForwardLight(const Eigen::Isometry3d& T_map_base) const;
  /// The same of the camera under the mirror, with the movers of that moment: CV_32FC3, blue,
  /// green, red. @throws as RenderOmni().
  [[nodiscard]] cv::Mat RenderOmniLight(const Frame& frame) const;

  [[nodiscard]] const Scene& GetScene() const;
  /// The robot of MakePath and Render, parsed from RigYaml().
  [[nodiscard]] const calib::Rig& GetRig() const;
  /// All objects between floor and ceiling that stand still, including random ones, with known
  /// points of structures and beams.
  [[nodiscard]] const Objects& GetObjects() const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

}  // namespace ceilmap::simulator
