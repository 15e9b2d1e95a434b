#pragma once

#include <string>
#include <vector>

#include "app/recordings/bag_source.hpp"
#include "calib/solve/board.hpp"
#include "calib/solve/camera_calibration.hpp"

namespace ceilmap::recordings {

/// Searches for a board in a folder of images, in several images, or in a video, several images at
/// a time. A video is divided into at most 300 parts, of which the sharpest image each is searched.
/// Ends early when the user interrupts.
/// @param sources  One recording, or images. @param bag  which images, where it is a bag.
/// @throws InputError when there are none, one cannot be read, or their sizes differ.
calibration::BoardImages FindBoards(const std::vector<std::string>& sources,
                                    const calibration::Board& board,
                                    const BagTopic& bag = {});

}  // namespace ceilmap::recordings
