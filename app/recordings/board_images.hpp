#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"

namespace ceilmap::recordings {

/// Boards found in the given images.
struct BoardImages {
  std::string name;         ///< name of the source, for messages
  cv::Size size;            ///< size of every image
  std::int64_t images = 0;  ///< processed; of a video, the sharpest of each interval
  std::vector<calibration::BoardView> views;  ///< in the order of the images
  std::vector<std::string> without_board;     ///< names of the images without a board
  /// Some images without a board, spread over the source, to find the reason.
  std::vector<cv::Mat> unseen;
  cv::Mat sample;  ///< the image with the largest board, CV_8UC1
  bool interrupted = false;
};

/// Detects a board in a folder of images, in several images, or in a video, with several threads.
/// Of a video, at most 300 images are processed: the sharpest of as many intervals.
/// @param sources  One recording, or images.
/// @throws InputError when there are none, one cannot be read, or their sizes differ.
BoardImages FindBoards(const std::vector<std::string>& sources, const calibration::Board& board);

}  // namespace ceilmap::recordings
