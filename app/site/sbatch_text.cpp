#include "app/site/sbatch_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "app/site/quoting.hpp"

namespace fs = std::filesystem;

namespace ceilmap::site {
namespace {

constexpr std::size_t kMaxTasks = 1000;

constexpr std::string_view kHead = R"(#!/usr/bin/env bash
# {0} maps of recordings, {1} matches, 1 map of the site. Submits the jobs to Slurm:
#   bash THIS_FILE [OPTIONS OF SBATCH]        e.g. --partition=long --cpus-per-task=4 --mem=8G
# A task does nothing if its result is there and no input is newer: after a failure, submit again.
# The output of each job goes to its log.
set -euo pipefail

program={2}
folder={3}
)";

// Without fmt: braces are bash's.
constexpr std::string_view kFunctions = R"sh(
inputs() { files+=("$@"); }
words() { arguments+=("$@"); }
# if_there FILE WORD: a word for a file that another job may have failed to make.
if_there() {
  if [[ -e $1 ]]; then
    files+=("$1")
    arguments+=("$2")
  fi
}

# result LOG DATE OUTPUT: runs the job of `files` and `arguments`, unless the output is up to date.
result() {
  local log=$1 output=$3 input child='' stopped='' code=0
  if [[ -e $output ]]; then
    local newer=''
    for input in "${files[@]}"; do
      if [[ $input -nt $output ]]; then newer=1; fi
    done
    if [[ ! $newer ]]; then return 0; fi
  fi
  mkdir -p -- "$(dirname -- "$log")" "$(dirname -- "$output")"
  # A program that is asked to end keeps what it has, but a part of a recording is no result here.
  trap 'stopped=1; if [[ $child ]]; then kill -KILL "$child" 2>/dev/null || true; fi' INT TERM
  SOURCE_DATE_EPOCH=$2 "$program" "${arguments[@]}" >"$log" 2>&1 </dev/null &
  child=$!
  if [[ $stopped ]]; then kill -KILL "$child" 2>/dev/null || true; fi
  wait "$child" || code=$?
  if [[ $stopped ]]; then
    wait "$child" 2>/dev/null || true
    rm -f -- "$output"
    exit 130
  fi
  trap - INT TERM
  if ((code == 0)) && [[ ! -e $output ]]; then
    echo "ended without writing $output" >>"$log"
    code=1
  fi
  return "$code"
}

# tasks STEP COUNT TASKS: the jobs of this task of an array, number SLURM_ARRAY_TASK_ID of TASKS.
tasks() {
  local i failed=0
  for ((i = SLURM_ARRAY_TASK_ID; i < $2; i += $3)); do
    files=()
    arguments=()
    job "$1.$i" || failed=1
  done
  return "$failed"
}

# submit STEP OPTIONS... -- ARGUMENTS...: the number of the job.
submit() {
  local step=$1 options=() id
  shift
  while [[ $1 != -- ]]; do
    options+=("$1")
    shift
  done
  shift
  id=$(sbatch --parsable --job-name="ceilmap-$step" --chdir="$folder" --output=/dev/null "${options[@]}" \
    "${user[@]}" "$script" --task "$step" "$@")
  echo "${id%%;*}"
}
)sh";

constexpr std::string_view kEnd = R"(
if [[ ${1:-} == --task ]]; then
  cd -- "$folder"
  tasks "${@:2}"
  exit
fi
script=${BASH_SOURCE[0]}
user=("$@")
)";

std::string JobWords(std::string_view function, const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += " " + ShellWord(word);
  return words.empty() ? "" : fmt::format("      {}{}\n", function, text);
}

/// One case of the function `job`.
std::string JobCase(const Plan& plan, const Job& job, const std::string& label, std::int64_t date) {
  std::string text = fmt::format("    {})\n", label);
  std::vector<std::string> inputs = job.inputs;
  for (const std::size_t before : job.needs) inputs.push_back(plan.jobs[before].output);
  text += JobWords("inputs", inputs);
  std::vector<std::string> words;
  for (const Argument& argument : job.arguments) {
    const bool may_fail =
        argument.of && std::find(job.uses.begin(), job.uses.end(), *argument.of) != job.uses.end();
    if (!may_fail) {
      words.push_back(argument.text);
      continue;
    }
    text += JobWords("words", words);
    words.clear();
    text += JobWords("if_there", {plan.jobs[*argument.of].output, argument.text});
  }
  text += JobWords("words", words);
  return text +
         fmt::format(
             "      result {} {} {}\n      ;;\n", ShellWord(job.log), date, ShellWord(job.output));
}

/// Consecutive jobs of the plan, which are submitted together.
struct Stage {
  std::string_view name;
  std::size_t begin = 0;
  std::size_t end = 0;
  std::string_view after;  ///< kind of dependency on the stage before
};

std::vector<Stage> StagesOf(const Plan& plan) {
  const std::size_t solution = plan.Solution();
  const std::size_t drawn = solution + 1 + plan.parts;
  const std::size_t assembled = plan.parts > 0 ? drawn + 1 : drawn;
  std::vector<Stage> stages = {{"map", 0, plan.maps, ""},
                               {"match", plan.maps, solution, "afterany"},
                               {"solve", solution, solution + 1, "afterany"},
                               {"part", solution + 1, drawn, "afterok"},
                               {"mosaic", drawn, assembled, "afterok"},
                               {"align", assembled, plan.jobs.size(), "afterok"}};
  std::erase_if(stages, [](const Stage& stage) { return stage.begin == stage.end; });
  return stages;
}

std::string Submissions(const std::vector<Stage>& stages) {
  std::string text;
  std::string_view before;
  for (const Stage& stage : stages) {
    const std::size_t count = stage.end - stage.begin;
    const std::size_t tasks = std::min(count, kMaxTasks);
    std::string dependency;
    if (!before.empty()) {
      dependency =
          fmt::format(" --kill-on-invalid-dep=yes --dependency={}:\"${}\"", stage.after, before);
    }
    text += fmt::format("{0}=$(submit {0} --array=0-{1}{2} -- {3} {4})\n",
                        stage.name,
                        tasks - 1,
                        dependency,
                        count,
                        tasks);
    before = stage.name;
  }
  text += "echo \"submitted:";
  for (const Stage& stage : stages) text += fmt::format(" {0} ${0}", stage.name);
  return text + "\"\n";
}

}  // namespace

std::string SbatchText(const Plan& plan,
                       const fs::path& program,
                       const std::vector<std::int64_t>& dates) {
  const std::vector<Stage> stages = StagesOf(plan);
  std::string text = fmt::format(
      kHead, plan.maps, plan.matches, ShellWord(program.string()), ShellWord(plan.folder.string()));
  text += kFunctions;
  text += "\njob() {\n  case $1 in\n";
  for (const Stage& stage : stages) {
    for (std::size_t i = stage.begin; i < stage.end; ++i) {
      text +=
          JobCase(plan, plan.jobs[i], fmt::format("{}.{}", stage.name, i - stage.begin), dates[i]);
    }
  }
  text += "  esac\n}\n";
  text += kEnd;
  return text + Submissions(stages);
}

}  // namespace ceilmap::site
