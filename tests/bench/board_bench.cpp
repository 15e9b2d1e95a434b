// Corners and lenses from simulated boards, for wide lenses of both models: prints the errors of
// the detected corners by their distance from the image's centre, of the focal length, and of the
// calibrated lens over all pixels.
//   ceilmap_board_bench [VIEWS]      default: 15

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "calib/solve/camera_solver.hpp"
#include "tests/calib/solve/board_camera.hpp"

namespace ceilmap::calibration {
namespace {

void Measure(const NamedLens& named, int count) {
  Board board;
  board.square_m = 0.03;
  const Lens& truth = named.lens;
  const BoardCamera camera(board, truth);
  CornerErrors corners;
  std::vector<BoardView> views;
  std::uint64_t seed = 0;
  for (const BoardPose& pose : camera.Poses(count)) {
    auto view = DetectBoard(camera.Take(pose, ++seed), board);
    if (!view) continue;
    corners.Add(*view, camera.Corners(pose), truth.Size());
    view->name = fmt::format("{}", seed);
    views.push_back(*view);
  }
  fmt::print("{:25} {:3} ", named.name, views.size());
  for (const CornerErrors::Ring& ring : corners.rings) {
    fmt::print(" {:.3f} ({:.2f})", std::sqrt(ring.squares_px2 / ring.count), ring.largest_px);
  }
  const auto solution = SolveCamera(board, views, truth.Size(), {.model = truth.model});
  if (!solution) {
    fmt::print("  no solution\n");
    return;
  }
  const Lens& lens = solution->lens;
  const LensError error = CompareLenses(lens, truth);
  fmt::print("  {:+.4f} {:+.4f} %  {:+.3f} {:+.3f}  {:.3f}  {:.3f} ({:.3f})  views {}\n",
             100 * (lens.fx / truth.fx - 1),
             100 * (lens.fy / truth.fy - 1),
             lens.cx - truth.cx,
             lens.cy - truth.cy,
             solution->rms_px,
             error.rms_px,
             error.largest_px,
             solution->UsedViews());
}

}  // namespace
}  // namespace ceilmap::calibration

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 15;
  fmt::print(
      "lens, views, errors of corners in four rings: RMS (largest), px; of fx, fy; of cx, cy, px; "
      "RMS of the "
      "fit; of the lens over its pixels: RMS (largest), px\n");
  for (const cv::Size size : {cv::Size(640, 480), cv::Size(1280, 960)}) {
    for (const auto& named : ceilmap::calibration::WideLenses(size)) {
      ceilmap::calibration::Measure(named, count);
    }
  }
}
