#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace ceilmap::files {

/// What a text file of lines (trajectories, stamps, headings) may have at most: larger ones are
/// refused before they fill the memory. A trajectory of this size has 30 frames a second for a day.
inline constexpr std::size_t kMaxTextBytes = std::size_t{256} << 20U;
inline constexpr std::size_t kMaxLineBytes = std::size_t{64} << 10U;

/// The whole file. Pipes are read too, to their end.
/// @param max_bytes  of which a text may have no more; for tests.
/// @throws InputError when it is missing, a folder, unreadable or too large.
std::string ReadTextFile(const std::filesystem::path& file, std::size_t max_bytes = kMaxTextBytes);

/// The lines of a text, one by one, without their ends; what follows the last end is a line unless
/// it is empty.
class Lines {
 public:
  /// @param text, name  of the file; must outlive this.
  Lines(std::string_view text, const std::string& name) : rest_(text), name_(name) {}

  /// @return false at the end. @throws InputError when the line is too long for one of text.
  bool Next(std::string_view& line);
  [[nodiscard]] int Number() const { return number_; }  ///< of the last line, from 1

 private:
  std::string_view rest_;
  const std::string& name_;
  int number_ = 0;
};

}  // namespace ceilmap::files
