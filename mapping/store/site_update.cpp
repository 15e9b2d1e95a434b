#include "mapping/store/site_update.hpp"

#include "mapping/store/map_revision.hpp"

namespace ceilmap::store {

void WriteSiteFrame(const std::filesystem::path& map,
                    const std::filesystem::path& output,
                    const survey::SiteFrame& site,
                    const std::string& provenance) {
  MapRevision revision(map, output, provenance);
  revision.SetSiteFrame(site);
  revision.Commit();
}

}  // namespace ceilmap::store
