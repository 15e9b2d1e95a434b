#pragma once

#include <filesystem>
#include <iosfwd>

namespace ceilmap::recordings {

/// Makes a finished MP4 file (ISO 14496-12) play `factor` times as fast: multiplies the units per
/// second in its movie and track headers (mvhd, mdhd) and does not change images.
/// @param factor  > 0. @throws RunError when the file is not such a file or cannot be written.
void SpeedUpMp4(const std::filesystem::path& file, double factor);

/// The same with an open file, for reading and writing.
/// @return false when it is not such a file.
bool SpeedUpMp4(std::iostream& stream, double factor);

}  // namespace ceilmap::recordings
