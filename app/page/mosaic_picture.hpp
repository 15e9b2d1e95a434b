#pragma once

#include <cstddef>
#include <opencv2/core.hpp>

#include "app/page/page_data.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::page {

/// Default size limit of a picture on a page, so that pages can be sent by mail.
inline constexpr std::size_t kMaxPictureBytes = 4 << 20;

/// Makes a picture of a mosaic for a page: WebP, unmapped pixels transparent (PNG if OpenCV has no
/// WebP encoder). The quality and then the resolution are reduced until it fits into `max_bytes`.
/// @param grey, alpha  CV_8UC1 of the grid's size; alpha 0: unmapped.
/// @param grid  Extent of the mosaic; without pixels, the picture is empty.
/// @param max_bytes  A picture of 1 x 1 pixel is returned even if it is larger.
/// @throws std::invalid_argument on wrong types or sizes.
PagePicture MakePicture(const cv::Mat& grey,
                        const cv::Mat& alpha,
                        const store::MosaicGrid& grid,
                        std::size_t max_bytes = kMaxPictureBytes);

/// A picture of a map's mosaic, at most `max_px` wide and high; empty if the map has none.
/// @throws InputError as MapReader.
PagePicture MakeMosaicPicture(const store::MapReader& map,
                              int max_px = 3000,
                              std::size_t max_bytes = kMaxPictureBytes);

}  // namespace ceilmap::page
