// Writes a recording as a bag of ROS 2, for measurements: see tests/bench/README.md.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string_view>

#include "tests/integration/recording_bag.hpp"

int main(int count, char** words) {
  using ceilmap::bags::Compression;
  if (count != 4) {
    std::fputs("usage: ceilmap_write_recording_bag FOLDER BAG.mcap none|zstd|lz4\n", stderr);
    return 2;
  }
  const std::string_view compression = words[3];
  ceilmap::integration::RecordingBagOptions options;
  options.start_s = 1.7e9;
  options.file.compression = compression == "zstd"  ? Compression::kZstd
                             : compression == "lz4" ? Compression::kLz4
                                                    : Compression::kNone;
  try {
    ceilmap::integration::WriteRecordingBag(words[1], words[2], options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
