#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"

namespace ceilmap::recordings {

/// Boards found in the images that were given.
struct BoardImages {
  std::string name;         ///< of the source, for messages
  cv::Size size;            ///< of every image
  std::int64_t images = 0;  ///< looked at; of a video those that were sharper than their neighbours
  std::vector<calibration::BoardView> views;  ///< in the order of the images
  std::vector<std::string> without_board;     ///< names of the other images
  /// Some images without a board, spread over the source, for whoever wants to know why.
  std::vector<cv::Mat> unseen;
  cv::Mat sample;  ///< the image whose board is the largest, CV_8UC1
  bool interrupted = false;
};

/// Looks for a board in a folder of images, in several images, or in a video; several pictures
/// at a time. Of a video, 300 images at the most are looked at: the sharpest of as many
/// stretches.
/// @param sources  one recording, or images.
/// @throws InputError when there are none, one cannot be read, or their sizes differ.
BoardImages FindBoards(const std::vector<std::string>& sources, const calibration::Board& board);

}  // namespace ceilmap::recordings
