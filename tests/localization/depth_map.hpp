#pragma once

#include <memory>
#include <vector>

#include "localization/map_patches.hpp"
#include "mapping/registration/registrar.hpp"
#include "tests/localization/true_map.hpp"
#include "tests/mapping/registration/synthetic_depth.hpp"

namespace ceilmap::localization::synthetic {

using registration::synthetic::SyntheticDepth;

constexpr double kDeck_m = 5;
constexpr double kMapCamera_m = 0.4;
constexpr double kStripRho = 1.35;  // of the mapping camera

/// An upward camera of 640 x 480 px under the mast of its robot.
inline calib::MountedCamera DeckCamera(double focal_px = 350, double height_m = kMapCamera_m) {
  calib::MountedCamera up = UpCamera(focal_px, height_m);
  up.camera = {640, 480, focal_px, focal_px, 319.5, 239.5, {}};
  return up;
}

/// Image of a robot under the deck and its strips.
inline cv::Mat SeenBelow(const SyntheticDepth& ceiling,
                         const calib::CeilingView& view,
                         const Pose2& T_map_base,
                         std::uint32_t noise_seed = 1) {
  const calib::CeilingView map_view(DeckCamera(), kDeck_m);
  const double map_distance = map_view.FocalLength() * map_view.MetresPerPixel();
  const double distance = view.FocalLength() * view.MetresPerPixel();
  // Of the strips, for this camera.
  const double rho = distance / (map_distance / kStripRho - map_distance + distance);
  registration::ImageMotion farther = MotionAt(view, T_map_base);
  farther.scale = map_view.MetresPerPixel() / view.MetresPerPixel();
  registration::ImageMotion nearer = farther;
  nearer.tx_px *= rho;
  nearer.ty_px *= rho;
  nearer.scale *= rho / kStripRho;
  return ceiling.Render(view.Size(), farther, nearer, 1.5, noise_seed);
}

/// A map of keyframes at their true poses with their true heights, 1.2 m apart along x, in two rows
/// that face each other.
class DepthMap {
 public:
  DepthMap() : ceiling(kStripRho) {
    const calib::CeilingView view(DeckCamera(), kDeck_m);
    store::MapMetadata metadata;
    metadata.resolution = view.MetresPerPixel();
    metadata.ceiling_height_m = kDeck_m;
    metadata.view_size = view.Size();
    metadata.view_units_per_px = view.MetresPerPixel();
    metadata.view_focal_px = view.FocalLength();
    metadata.T_base_view = view.T_base_view();
    store::MapWriter writer(folder / "deck.gpkg", metadata);
    places::PlaceDescriber describer(
        view.Size(),
        view.MetresPerPixel(),
        places::PlaceDescriptorParams::ForCamera(view.Size(), view.MetresPerPixel()));
    registration::RegistrarParams params;
    params.camera = registration::PlaneCameraOf(view);
    const registration::Registrar registrar(view.Size(), params);
    graph::MapGraph graph;
    constexpr int kColumns = 5;
    for (int i = 0; i < 2 * kColumns; ++i) {
      const bool back = i >= kColumns;
      const int column = back ? 2 * kColumns - 1 - i : i;
      const Pose2 T_map_base{1.2 * column, back ? 1.2 : 0, back ? std::numbers::pi : 0};
      AddKeyframe({i,
                   T_map_base,
                   SeenBelow(ceiling, view, T_map_base, static_cast<std::uint32_t>(i) + 100),
                   Eigen::Vector3d(1e6, 1e6, 1e7),
                   std::make_shared<const heights::HeightField>(
                       TrueHeights(view, T_map_base, registrar.EmptyHeights()))},
                  describer,
                  writer,
                  graph);
    }
    mosaic::MosaicParams mosaic;
    mosaic.resolution = metadata.resolution;
    mosaic.threads = 1;
    mosaic::WriteMap(graph, metadata, mosaic, writer);
    writer.Commit();
    map = std::make_unique<store::MapReader>(folder / "deck.gpkg");
  }

  support::TempFolder folder;
  SyntheticDepth ceiling;
  std::unique_ptr<store::MapReader> map;

 private:
  /// Blocks with a border of a strip in them are not known.
  [[nodiscard]] heights::HeightField TrueHeights(const calib::CeilingView& view,
                                                 const Pose2& T_map_base,
                                                 heights::HeightField field) const {
    registration::ImageMotion nearer = MotionAt(view, T_map_base);
    nearer.tx_px *= kStripRho;
    nearer.ty_px *= kStripRho;
    const registration::ImageMotion back = nearer.Inverse();
    for (std::size_t i = 0; i < field.cells.size(); ++i) {
      const auto cover = [&](double u, double v) {
        return ceiling.Cover(back.Apply(field.Centre(i) + Eigen::Vector2d(u, v)));
      };
      const double middle = cover(0, 0);
      constexpr double kHalf = 12;
      if (cover(kHalf, kHalf) != middle || cover(-kHalf, kHalf) != middle ||
          cover(kHalf, -kHalf) != middle || cover(-kHalf, -kHalf) != middle) {
        continue;
      }
      field.cells[i] = {middle > 0 ? static_cast<float>(kStripRho) : 1.0F, 0.004F};
    }
    field.scale_sigma = 0.002;
    return field;
  }
};

}  // namespace ceilmap::localization::synthetic
