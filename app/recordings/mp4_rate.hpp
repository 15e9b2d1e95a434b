#pragma once

#include <filesystem>
#include <iosfwd>

namespace ceilmap::recordings {

/// Makes a finished MP4 file (ISO 14496-12) play `factor` times as fast: multiplies the units per
/// second in its movie and track headers (mvhd, mdhd) and touches no image.
/// @param factor  > 0. @throws RunError when the file is no such file or cannot be written.
void SpeedUpMp4(const std::filesystem::path& file, double factor);

/// The same with an open file, for reading and writing.
/// @return false when it is no such file.
bool SpeedUpMp4(std::iostream& stream, double factor);

}  // namespace ceilmap::recordings
