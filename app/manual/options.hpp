#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

/// What an option or argument of the command line is, as manual pages and completion need it.
namespace ceilmap::manual {

/// What the shell can offer as a value.
enum class Value {
  kNone,    ///< a flag: it has no value
  kChoice,  ///< one of Choices()
  kFile,    ///< a file, with one of Extensions() if there are any
  kFolder,
  kOther,  ///< a number, a name, an address
};

/// The name of its value as --help shows it, without its range and its default: "FILE.json", "M".
std::string ValueName(const CLI::Option& option);
Value ValueOf(const CLI::Option& option);
/// "ros", "geotiff", ...: of "TEXT:{ros,geotiff}".
std::vector<std::string> Choices(const CLI::Option& option);
/// "pdf", "svg": of "FILE.pdf|svg".
std::vector<std::string> Extensions(const CLI::Option& option);

/// "-o", "--output".
std::vector<std::string> Names(const CLI::Option& option);

/// The command as typed: "ceilmap compass learn".
std::string FullName(const CLI::App& command);
/// The commands below a command, in the order of --help.
std::vector<const CLI::App*> Commands(const CLI::App& command);

}  // namespace ceilmap::manual
