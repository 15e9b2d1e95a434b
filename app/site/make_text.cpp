#include "app/site/make_text.hpp"

#include <fmt/format.h>

#include <set>

#include "app/site/quoting.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::site {
namespace {

/// Linux takes no longer argument of a program, here of `sh -c` (MAX_ARG_STRLEN, 128 KiB).
constexpr std::size_t kMaxRecipeBytes = 131000;

constexpr const char* kHeader =
    R"(# {0} maps of recordings, {1} matches, 1 map of the site. GNU make:
#   make -j N -f THIS_FILE        N jobs at a time; -k: a failed job does not stop the others
# A job's output goes to its log in {2}.
.DELETE_ON_ERROR:
.SUFFIXES:
MAKEFLAGS += --no-builtin-rules
SHELL := /bin/sh
.PHONY: all
all: {3}
)";

class MakeWriter {
 public:
  MakeWriter(const Plan& plan, const fs::path& program) : plan_(plan), program_(program) {}

  [[nodiscard]] std::string Header() const {
    const std::string logs = (fs::path(plan_.work) / "logs").string();
    return fmt::format(kHeader, plan_.maps, plan_.matches, logs, Target(plan_.output));
  }

  [[nodiscard]] std::string Rule(const Job& job, std::int64_t date) const {
    std::string text = fmt::format("\n{}:", Target(job.output));
    for (const std::string& input : job.inputs) text += " " + Target(input);
    for (const auto* before : {&job.needs, &job.uses}) {
      for (const std::size_t i : *before) text += " " + Target(plan_.jobs[i].output);
    }
    return text + fmt::format("\n\t@{}\n", Recipe(job, date));
  }

 private:
  [[nodiscard]] std::string Target(const std::string& file) const {
    return MakeName((plan_.folder / file).lexically_normal().string());
  }

  [[nodiscard]] std::string Recipe(const Job& job, std::int64_t date) const {
    std::string folders;
    std::set<std::string> seen;
    for (const std::string& file : {job.output, job.log}) {
      const std::string folder = fs::path(file).parent_path().string();
      if (!folder.empty() && seen.insert(folder).second) folders += " " + RecipeWord(folder);
    }
    std::string words = RecipeWord(program_.string());
    const std::vector<bool> all(plan_.jobs.size(), true);
    for (const std::string& word : WordsOf(job, all)) words += " " + RecipeWord(word);
    const std::string log = RecipeWord(job.log);
    std::string recipe = fmt::format(
        "echo {0}; cd {1} && mkdir -p{2} && SOURCE_DATE_EPOCH={3} {4} >{5} 2>&1 || {{ echo "
        "{0}' failed, see '{5}: \"$$(tail -n 1 {5})\" >&2; exit 1; }}",
        RecipeWord(job.name),
        RecipeWord(plan_.folder.string()),
        folders,
        date,
        words,
        log);
    if (recipe.size() > kMaxRecipeBytes) {
      throw InputError(fmt::format(
          "the plan has {} maps and matches, more than a makefile can pass to '{}'; use 'ceilmap "
          "site run', or --format sbatch",
          plan_.maps + plan_.matches,
          job.name));
    }
    return recipe;
  }

  const Plan& plan_;
  const fs::path& program_;
};

}  // namespace

std::string MakeText(const Plan& plan,
                     const fs::path& program,
                     const std::vector<std::int64_t>& dates) {
  const MakeWriter writer(plan, program);
  std::string text = writer.Header();
  for (std::size_t i = 0; i < plan.jobs.size(); ++i) text += writer.Rule(plan.jobs[i], dates[i]);
  return text;
}

}  // namespace ceilmap::site
