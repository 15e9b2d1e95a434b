#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace ceilmap::site {

/// A word of a job's command line.
struct Argument {
  std::string text;
  /// Left out when this job has no result.
  std::optional<std::size_t> of;
};

/// A process that makes one file from others. Paths are absolute or relative to the folder in which
/// all jobs run. The result appears under its name complete or not at all.
struct Job {
  std::string name;                 ///< unique, safe as a file name
  std::string output;               ///< the file that it makes
  std::string log;                  ///< its stdout and stderr
  std::vector<Argument> arguments;  ///< behind the program's name
  /// Files and folders that it reads and no job makes; those that do not exist are no error.
  std::vector<std::string> inputs;
  /// Jobs before it in the list. Without the result of one of `needs` it cannot run. Of `uses` it
  /// takes what there is, at least one.
  std::vector<std::size_t> needs;
  std::vector<std::size_t> uses;
};

/// The words of a job for a process.
/// @param has_result  of each job of the list.
inline std::vector<std::string> WordsOf(const Job& job, const std::vector<bool>& has_result) {
  std::vector<std::string> words;
  for (const Argument& argument : job.arguments) {
    if (!argument.of || has_result[*argument.of]) words.push_back(argument.text);
  }
  return words;
}

}  // namespace ceilmap::site
