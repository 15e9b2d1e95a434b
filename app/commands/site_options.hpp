#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>

#include "app/site/plan.hpp"

namespace ceilmap::commands {

/// What the commands of `ceilmap site` have in common.
struct SiteOptions {
  std::filesystem::path manifest;
  std::filesystem::path program;  ///< --program; empty: the one that runs

  void AddTo(CLI::App& cli);
  /// @throws InputError
  [[nodiscard]] site::Plan ReadPlan() const;
  /// The program of the jobs, absolute. @throws InputError when there is none.
  [[nodiscard]] std::filesystem::path Program() const;
};

}  // namespace ceilmap::commands
