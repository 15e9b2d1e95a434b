#include "app/commands/site_options.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <system_error>

#include "app/site/manifest.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {

void SiteOptions::AddTo(CLI::App& cli) {
  cli.add_option("manifest", manifest, "The manifest of the site")
      ->required()
      ->type_name("SITE.yaml");
  cli.add_option("--program", program, "The ceilmap that the jobs run [this one]")
      ->type_name("FILE")
      ->group("Input");
}

site::Plan SiteOptions::ReadPlan() const {
  return site::MakePlan(site::ReadManifest(manifest));
}

fs::path SiteOptions::Program() const {
  std::error_code error;
  const fs::path file =
      program.empty() ? fs::read_symlink("/proc/self/exe", error) : fs::absolute(program);
  if (error || !fs::is_regular_file(file, error) || access(file.c_str(), X_OK) != 0) {
    throw InputError(fmt::format("--program {}: is not a program; give the path of ceilmap",
                                 program.empty() ? file.string() : program.string()));
  }
  return file.lexically_normal();
}

}  // namespace ceilmap::commands
