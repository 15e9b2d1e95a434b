#include "app/manual/completion.hpp"

#include <fmt/format.h>

#include <map>
#include <vector>

#include "app/manual/options.hpp"

namespace ceilmap::manual {
namespace {

std::string Words(const std::vector<std::string>& words) {
  return fmt::format("COMPREPLY=($(compgen -W \"{}\" -- \"$cur\"))", fmt::join(words, " "));
}

/// The function of bash-completion that offers the values of an option; empty: nothing to offer.
std::string Offer(const CLI::Option& option) {
  switch (ValueOf(option)) {
    case Value::kChoice:
      return Words(Choices(option));
    case Value::kFolder:
      return "_filedir -d";
    case Value::kFile: {
      const std::vector<std::string> extensions = Extensions(option);
      if (extensions.empty()) return "_filedir";
      return extensions.size() == 1 ? fmt::format("_filedir {}", extensions.front())
                                    : fmt::format("_filedir '@({})'", fmt::join(extensions, "|"));
    }
    case Value::kNone:
    case Value::kOther:
      break;
  }
  return "";
}

/// The case of one command: values behind its options, its options, its commands or arguments.
std::string CommandCase(const CLI::App& command,
                        const std::string& name,
                        const std::vector<std::string>& topics) {
  std::map<std::string, std::vector<std::string>> options_by_offer;
  std::vector<std::string> options;
  std::string arguments;
  for (const CLI::Option* option : command.get_options()) {
    const std::vector<std::string> names = Names(*option);
    if (names.empty() && arguments.empty()) arguments = Offer(*option);
    options.insert(options.end(), names.begin(), names.end());
    if (names.empty() || ValueOf(*option) == Value::kNone) continue;
    auto& same = options_by_offer[Offer(*option)];
    same.insert(same.end(), names.begin(), names.end());
  }
  std::vector<std::string> commands;
  for (const CLI::App* below : Commands(command)) commands.push_back(below->get_name());
  if (name == "help") {
    commands = topics;
    for (const CLI::App* other : Commands(*command.get_parent())) {
      commands.push_back(other->get_name());
    }
  }
  if (!commands.empty()) arguments = Words(commands);
  std::string text = fmt::format("        \"{}\")\n            case $prev in\n", name);
  for (const auto& [offer, names] : options_by_offer) {
    text += fmt::format("                {}) {}{}return ;;\n",
                        fmt::join(names, " | "),
                        offer,
                        offer.empty() ? "" : "; ");
  }
  return text + fmt::format(R"(            esac
            if [[ $cur == -* ]]; then
                {}
            else
                {}
            fi
            ;;
)",
                            Words(options),
                            arguments.empty() ? ":" : arguments);
}

/// As typed after the program's name: "", "map", "compass learn".
std::string NameBelow(const CLI::App& command, const CLI::App& program) {
  const std::string name = FullName(command);
  return &command == &program ? "" : name.substr(FullName(program).size() + 1);
}

void AddCases(const CLI::App& command,
              const CLI::App& program,
              const std::vector<std::string>& topics,
              std::vector<std::string>& names,
              std::string& cases) {
  const std::string name = NameBelow(command, program);
  if (&command != &program) names.push_back(fmt::format("\"{}\"", name));
  cases += CommandCase(command, name, topics);
  for (const CLI::App* below : Commands(command)) AddCases(*below, program, topics, names, cases);
}

}  // namespace

std::string BashCompletion(const CLI::App& program, const std::vector<std::string>& topics) {
  std::vector<std::string> names;
  std::string cases;
  AddCases(program, program, topics, names, cases);
  return fmt::format(R"(# Completion for {0}, made from its options.
_{0}()
{{
    local cur prev words cword i command="" next
    _init_completion || return
    # The command is the words before the first option.
    for ((i = 1; i < cword; i++)); do
        next="${{command:+$command }}${{words[i]}}"
        case $next in
            {1}) command=$next ;;
            *) break ;;
        esac
    done
    case $command in
{2}    esac
}} &&
    complete -F _{0} {0}
)",
                     program.get_name(),
                     fmt::join(names, " | "),
                     cases);
}

}  // namespace ceilmap::manual
