#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace ceilmap::files {

/// Maximum size of a text file of lines (trajectories, stamps, headings); larger files are refused
/// before they fill the memory. A trajectory of this size has 30 frames a second for a day.
inline constexpr std::size_t kMaxTextBytes = std::size_t{256} << 20U;
inline constexpr std::size_t kMaxLineBytes = std::size_t{64} << 10U;

/// Reads a whole file. Pipes are read to their end.
/// @param max_bytes  Maximum size; for tests.
/// @throws InputError when the file is missing, a folder, unreadable or too large.
std::string ReadTextFile(const std::filesystem::path& file, std::size_t max_bytes = kMaxTextBytes);

/// The lines of a text, one by one, without line ends. Text after the last line end is a line
/// unless it is empty.
class Lines {
 public:
  /// @param text, name  Of the file; must outlive the object.
  Lines(std::string_view text, const std::string& name) : rest_(text), name_(name) {}

  /// @return false at the end. @throws InputError when the line is too long.
  bool Next(std::string_view& line);
  [[nodiscard]] int Number() const { return number_; }  ///< of the last line, from 1

 private:
  std::string_view rest_;
  const std::string& name_;
  int number_ = 0;
};

}  // namespace ceilmap::files
