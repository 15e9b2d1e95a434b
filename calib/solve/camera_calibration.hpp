#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"
#include "calib/solve/camera_solver.hpp"
#include "calib/solve/view_judge.hpp"

namespace ceilmap::calibration {

/// Images in which boards were searched for (DetectBoard).
struct BoardImages {
  std::string name;              ///< of the source, for messages
  cv::Size size;                 ///< of each image
  std::int64_t images = 0;       ///< searched; of a video only those sharper than their neighbours
  std::vector<BoardView> views;  ///< boards that were found, in the order of the images
  std::vector<std::string> without_board;  ///< names of the other images
  /// Some of the images without a board, CV_8UC1: the cause is searched for in them when no image
  /// shows the board.
  std::vector<cv::Mat> unseen;
  cv::Mat sample;  ///< the image with the largest board, CV_8UC1
};

/// A calibrated camera, with all data of its report.
struct CameraCalibration {
  std::string name;  ///< of the camera
  Board board;
  BoardImages images;
  std::vector<BoardView> views;  ///< selected for the solution
  CameraSolution solution;       ///< its views are indices of `views`
  Coverage coverage;             ///< of the views used
  std::vector<std::string> warnings;
  struct LeftOut {
    std::string name;
    std::string why;
  };
  std::vector<LeftOut> left_out;
};

/// Selects views, solves and judges the solution (calib/README.md, "Calibration of a camera").
/// @param max_views  at least 3.
/// @throws InputError when the images do not determine the camera, with what is missing and what to
///   add.
CameraCalibration CalibrateCamera(const Board& board,
                                  BoardImages images,
                                  const SolverParams& params,
                                  std::size_t max_views);

}  // namespace ceilmap::calibration
