#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "localization/compass/labrosse/methods.hpp"

namespace ceilmap::commands {

/// Options of a command that measures the heading from panoramas: the compass and its settings.
struct CompassOptions {
  std::string method = "fft";        ///< fft, labrosse2006, labrosse2006-probes, labrosse2004
  std::optional<double> fov_deg;     ///< width of the front and the back field of view
  std::optional<std::int64_t> skip;  ///< labrosse2006: frames left out after each one
  std::optional<double> threshold;   ///< labrosse2006: on the normalised amplitude

  void AddTo(CLI::App& cli, const std::string& group);
  /// @throws InputError on a value outside its range, or an option that the method does not have.
  void Check() const;
  /// The parameters with the options that are given. @throws as Check.
  [[nodiscard]] labrosse::CompassParams Resolve(labrosse::CompassParams params) const;
};

}  // namespace ceilmap::commands
