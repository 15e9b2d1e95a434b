#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

namespace ceilmap::commands {

/// `--size-budget` of `prune` and `update`.
struct SizeBudget {
  double megabytes = 0;  ///< 10^6 bytes; 0: not given

  [[nodiscard]] std::optional<std::uint64_t> Bytes() const;
  void AddTo(CLI::App& cli, const std::string& text, const std::string& group = "Options");
};

}  // namespace ceilmap::commands
