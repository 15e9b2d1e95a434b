#include "app/recordings/mp4_rate.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <sstream>
#include <string>

namespace ceilmap::recordings {
namespace {

std::string BigEndian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift & 0xFFU);
  return bytes;
}

std::string Box(const std::string& type, const std::string& content) {
  return BigEndian(static_cast<std::uint32_t>(content.size()) + 8) + type + content;
}

/// Version 0: flags, two times, units a second.
std::string Header(const std::string& type, std::uint32_t units) {
  return Box(type, std::string(12, '\0') + BigEndian(units));
}

std::string Movie(std::uint32_t movie_units, std::uint32_t track_units) {
  return Box("ftyp", "isom") +
         Box("moov",
             Header("mvhd", movie_units) + Box("trak", Box("mdia", Header("mdhd", track_units))));
}

TEST(SpeedUpMp4, ChangesTheUnitsOfMovieAndTrackAlone) {
  std::stringstream stream(Movie(1000, 90000));
  EXPECT_TRUE(SpeedUpMp4(stream, 1.5));
  EXPECT_EQ(stream.str(), Movie(1500, 135000));
}

// Each level of a file of a gigabyte could be eight bytes: a hundred million calls.
TEST(SpeedUpMp4, GoesNoDeeperThanAMovieIs) {
  std::string nested;
  for (int i = 0; i < 1'000'000; ++i) nested += std::string(4, '\0') + "moov";
  std::stringstream stream(nested + Movie(1000, 90000));
  EXPECT_FALSE(SpeedUpMp4(stream, 1.5));
}

TEST(SpeedUpMp4, StopsAtSizesThatCannotBe) {
  const std::string movie = Movie(1000, 90000);
  for (const char* size :
       {"\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF", "\x7F\xFF\xFF\xFF\xFF\xFF\xFF\xFF"}) {
    std::stringstream stream(movie + BigEndian(1) + "mdat" + std::string(size, 8));
    EXPECT_TRUE(SpeedUpMp4(stream, 1));
    EXPECT_EQ(stream.str().substr(0, movie.size()), movie);
  }
}

TEST(SpeedUpMp4, RefusesWhatIsNone) {
  for (const std::string& bytes : {std::string(), std::string("text"), Box("moov", "")}) {
    std::stringstream stream(bytes);
    EXPECT_FALSE(SpeedUpMp4(stream, 2)) << bytes;
  }
}

}  // namespace
}  // namespace ceilmap::recordings
