#include "app/files/arguments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>
#include <system_error>

#include "app/files/csv.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::files {

namespace {

// Comma-separated numbers, as many as fit into the array; false for anything else.
bool ParseNumbers(std::string_view rest, std::span<double> values) {
  bool good = true;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t comma = rest.find(',');
    const bool last = i + 1 == values.size();
    good = good && last == (comma == std::string_view::npos) &&
           ParseNumber(rest.substr(0, comma), values[i]) && std::isfinite(values[i]);
    rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
  }
  return good;
}

}  // namespace

Pose2 ParsePose2(const std::string& text, const std::string& option) {
  std::array<double, 3> values{};
  if (!ParseNumbers(text, values)) {
    throw InputError(fmt::format("{} {}: must be X,Y,YAW_DEG, e.g. 1.5,-0.2,90", option, text));
  }
  return {values[0], values[1], WrapAngle(values[2] * kRadPerDeg)};
}

PoseSpread ParseSpread(const std::string& text, const std::string& option) {
  std::array<double, 2> values{};
  if (!ParseNumbers(text, values) || !(values[0] > 0) || !(values[1] > 0)) {
    throw InputError(
        fmt::format("{} {}: must be METRES,DEGREES, both > 0, e.g. 0.5,10", option, text));
  }
  return {values[0], values[1] * kRadPerDeg};
}

std::optional<std::array<double, 4>> ParseFourNumbers(const std::string& text) {
  std::array<double, 4> values{};
  if (!ParseNumbers(text, values)) return std::nullopt;
  return values;
}

std::optional<std::array<double, 6>> ParseSixNumbers(const std::string& text) {
  std::array<double, 6> values{};
  if (!ParseNumbers(text, values)) return std::nullopt;
  return values;
}

std::vector<double> ParsePositiveNumbers(const std::string& text, const std::string& option) {
  std::vector<double> values(1 +
                             static_cast<std::size_t>(std::count(text.begin(), text.end(), ',')));
  const auto positive = [](double value) { return value > 0; };
  if (!ParseNumbers(text, values) || !std::all_of(values.begin(), values.end(), positive)) {
    throw InputError(
        fmt::format("{} {}: must be numbers > 0 with commas between, e.g. 1,2,5", option, text));
  }
  return values;
}

NamedFile ParseNamedFile(const std::string& text) {
  const std::size_t equals = text.find('=');
  std::error_code ignored;
  const bool named = equals != std::string::npos && equals > 0 && text.find('/') > equals &&
                     !std::filesystem::exists(text, ignored);
  if (named) return {text.substr(0, equals), text.substr(equals + 1)};
  const std::filesystem::path file = text;
  return {file.stem().string(), file};
}

}  // namespace ceilmap::files
