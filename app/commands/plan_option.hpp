#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>

#include "app/reports/page_parts.hpp"
#include "mapping/store/export.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::commands {

/// --plan: the floor plan under the mosaic of a page, which then has the coordinates of the
/// building.
struct PlanOption {
  std::filesystem::path plan;

  CLI::Option* AddTo(CLI::App& cli);
  /// @throws InputError for a plan without a page. @param has_page  The command writes one.
  void CheckHasPage(bool has_page) const;
  /// What the page needs; nothing for a page in the map's coordinates.
  /// @param frame  Of the results: also without a plan, the page has those of Frame::kSite.
  /// @throws InputError when the map has no alignment, or the plan cannot be read.
  [[nodiscard]] std::optional<reports::PageSite> Site(const store::MapReader& map,
                                                      store::Frame frame) const;
};

}  // namespace ceilmap::commands
