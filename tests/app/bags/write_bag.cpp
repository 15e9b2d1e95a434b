// Writes a bag with a message of each type, for tests/bags/validate-mcap.sh.
#include <cstdio>
#include <string_view>

#include "tests/app/bags/all_messages.hpp"

int main(int count, char** words) {
  using ceilmap::bags::Compression;
  if (count != 3) {
    std::fputs("usage: ceilmap_write_bag BAG.mcap none|zstd|lz4\n", stderr);
    return 2;
  }
  const std::string_view name = words[2];
  ceilmap::bags::McapWriter writer(words[1],
                                   {.compression = name == "zstd"  ? Compression::kZstd
                                                   : name == "lz4" ? Compression::kLz4
                                                                   : Compression::kNone,
                                    .chunk_bytes = 1000});
  ceilmap::bags::WriteAllMessages(writer);
  writer.Commit();
  return 0;
}
