#pragma once

#include <cstddef>
#include <opencv2/core.hpp>

#include "app/page/page_data.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::page {

/// As large as a picture on a page may be unless another size is given: pages are sent by mail.
inline constexpr std::size_t kMaxPictureBytes = 4 << 20;

/// A picture of a mosaic for a page: WebP, what was never seen transparent (PNG where OpenCV writes
/// no WebP). With lower quality, then with less resolution, it is made to fit into `max_bytes`.
/// @param grey, alpha  CV_8UC1 of the grid's size; alpha 0: never seen.
/// @param grid  where it lies; of no pixels: the picture is empty.
/// @param max_bytes  a picture of 1 x 1 pixel comes back even if it is larger.
/// @throws std::invalid_argument on wrong types or sizes.
PagePicture MakePicture(const cv::Mat& grey,
                        const cv::Mat& alpha,
                        const store::MosaicGrid& grid,
                        std::size_t max_bytes = kMaxPictureBytes);

/// The same of a map's mosaic, no side longer than `max_px`; empty when the map has none.
/// @throws InputError as MapReader.
PagePicture MakeMosaicPicture(const store::MapReader& map,
                              int max_px = 3000,
                              std::size_t max_bytes = kMaxPictureBytes);

}  // namespace ceilmap::page
