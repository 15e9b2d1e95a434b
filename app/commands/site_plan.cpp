#include <fmt/format.h>

#include <memory>
#include <string>

#include "app/commands/site_commands.hpp"
#include "app/commands/site_options.hpp"
#include "app/files/output_files.hpp"
#include "app/site/make_text.hpp"
#include "app/site/sbatch_text.hpp"
#include "app/terminal/table.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct SitePlanOptions {
  SiteOptions site;
  std::string format = "make";
  fs::path output;
};

std::string PlanAsList(const site::Plan& plan) {
  terminal::Table table;
  table.AddRow({"job", "makes", "after"});
  for (const site::Job& job : plan.jobs) {
    std::string after;
    if (!job.uses.empty()) after = fmt::format("all before it, with what they made");
    for (const std::size_t before : job.needs) {
      after += (after.empty() ? "" : ", ") + plan.jobs[before].name;
    }
    table.AddRow({job.name, job.output, after});
  }
  return table.Format();
}

std::string PlanText(const SitePlanOptions& params, const site::Plan& plan) {
  if (params.format == "list") return PlanAsList(plan);
  const site::Plan existing = site::WithExistingInputs(plan);
  const std::vector<std::int64_t> dates = site::ResultDates(plan);
  return params.format == "make" ? site::MakeText(existing, params.site.Program(), dates)
                                 : site::SbatchText(existing, params.site.Program(), dates);
}

void RunSitePlan(const SitePlanOptions& params,
                 const CommonOptions& common,
                 terminal::Summary& summary) {
  files::CheckOutputFiles({params.output}, common.Existing());
  const site::Plan plan = params.site.ReadPlan();
  const std::string text = PlanText(params, plan);
  summary.frames = static_cast<std::int64_t>(plan.jobs.size());
  summary.quality = {{"jobs", plan.jobs.size()}, {"maps", plan.maps}, {"matches", plan.matches}};
  if (params.output.empty()) {
    fmt::print("{}", text);
    return;
  }
  files::WriteFileAtomically(params.output, text);
  summary.files = {params.output};
  if (!common.quiet) fmt::print("written {}\n", params.output.string());
}

}  // namespace

Command AddSitePlanCommand(CLI::App& site) {
  Command command = MakeCommand(
      site,
      "plan",
      "Prints the jobs of a site with their dependencies.",
      "ceilmap site plan hall.yaml --format make -o hall.mk && make -j 4 -f hall.mk\n"
      "  ceilmap site plan hall.yaml --format sbatch -o hall.sh && bash hall.sh "
      "--cpus-per-task=4\n"
      "A makefile needs GNU make, a script for sbatch Slurm with a folder that all nodes share. "
      "After a change of the manifest, make the plan again; make and Slurm do not see changed "
      "options, 'ceilmap site run' does.");
  auto params = std::make_shared<SitePlanOptions>();
  params->site.AddTo(*command.cli);
  command.cli->add_option("--format", params->format, "For GNU make, for Slurm, or to be read")
      ->check(CLI::IsMember({"make", "sbatch", "list"}))
      ->capture_default_str()
      ->group("Results");
  command.cli->add_option("-o,--output", params->output, "The plan [stdout]")
      ->type_name("FILE")
      ->group("Results");
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunSitePlan(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
