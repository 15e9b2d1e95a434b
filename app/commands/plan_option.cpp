#include "app/commands/plan_option.hpp"

#include <fmt/format.h>

#include "app/page/plan_picture.hpp"
#include "calib/base/error.hpp"
#include "mapping/store/site_plan.hpp"

namespace ceilmap::commands {

CLI::Option* PlanOption::AddTo(CLI::App& cli) {
  return cli
      .add_option("--plan",
                  plan,
                  "Floor plan under the mosaic of the page, in the coordinates of the building, "
                  "which the page then has ('ceilmap align'): GeoTIFF, PNG or JPEG with a world "
                  "file, DXF, GeoJSON")
      ->type_name("FILE");
}

void PlanOption::CheckHasPage(bool has_page) const {
  if (plan.empty() || has_page) return;
  throw InputError("--plan: is drawn on the page; give --report DIR too");
}

std::optional<reports::PageSite> PlanOption::Site(const store::MapReader& map,
                                                  store::Frame frame) const {
  if (plan.empty() && frame == store::Frame::kMap) return std::nullopt;
  const char* const option = plan.empty() ? "--frame site" : "--plan";
  try {
    reports::PageSite site;
    site.frame = *store::SiteOf(map, store::Frame::kSite);
    if (!plan.empty()) site.plan = page::MakePlan(store::ReadSitePlan(plan));
    return site;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", option, error.what()));
  }
}

}  // namespace ceilmap::commands
