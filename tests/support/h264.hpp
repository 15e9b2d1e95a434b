#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace ceilmap::support {

/// A NAL unit in the bytes of a file, without its length or start code.
struct NalUnit {
  std::size_t begin = 0;
  std::size_t size = 0;
  int type = 0;  ///< 1: image that rests on others, 5: image on its own, 6: remarks, 7, 8: sets
};

/// The NAL units in the media data of an MP4 file that holds one H.264 track and nothing else, as
/// `ceilmap simulate` writes them. @throws std::runtime_error when it is another file.
std::vector<NalUnit> NalUnitsOfMp4(const std::string& mp4);

/// The same of a stream with start codes.
std::vector<NalUnit> NalUnitsOfAnnexB(const std::string& stream);

/// The stream of such an MP4 file as a camera would send it, parameter sets first.
std::string AnnexBOf(const std::string& mp4);

}  // namespace ceilmap::support
