#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"

namespace ceilmap::recordings {

/// Boards found in the pictures that were given.
struct BoardPictures {
  std::string name;  ///< of the source, for messages
  cv::Size size;     ///< of every picture
  std::int64_t pictures =
      0;  ///< looked at; of a video those that were sharper than their neighbours
  std::vector<calibration::BoardView> views;  ///< in the order of the pictures
  std::vector<std::string> without_board;     ///< names of the other pictures
  /// Some pictures without a board, spread over the source, for whoever wants to know why.
  std::vector<cv::Mat> unseen;
  cv::Mat sample;  ///< the picture whose board is the largest, CV_8UC1
  bool interrupted = false;
};

/// Looks for a board in a folder of pictures, in several pictures, or in a video; several pictures
/// at a time. Of a video, 300 pictures at the most are looked at: the sharpest of as many
/// stretches.
/// @param sources  one recording, or pictures.
/// @throws InputError when there are none, one cannot be read, or their sizes differ.
BoardPictures FindBoards(const std::vector<std::string>& sources, const calibration::Board& board);

}  // namespace ceilmap::recordings
