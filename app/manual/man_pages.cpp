#include "app/manual/man_pages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <sstream>
#include <string_view>
#include <vector>

#include "app/manual/options.hpp"

namespace ceilmap::manual {
namespace {

/// Characters that roff would take as its own, or print as others than those to be typed.
std::string Escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '\\':
        escaped += "\\e";
        break;
      case '-':
        escaped += "\\-";
        break;
      case '\'':
        escaped += "\\(aq";
        break;
      case '^':
        escaped += "\\(ha";
        break;
      case '~':
        escaped += "\\(ti";
        break;
      case '`':
        escaped += "\\(ga";
        break;
      default:
        escaped += c;
    }
  }
  // At the beginning of a line a dot would begin a request.
  return escaped.starts_with('.') ? "\\&" + escaped : escaped;
}

std::string Bold(std::string_view text) {
  return "\\fB" + Escaped(text) + "\\fR";
}

std::string Italic(std::string_view text) {
  return "\\fI" + Escaped(text) + "\\fR";
}

/// The name of a command's page: "ceilmap-compass-learn".
std::string PageName(const CLI::App& command) {
  std::string name = FullName(command);
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

/// As whatis shows it: the first sentence, without its dot.
std::string Purpose(const CLI::App& command) {
  std::string text = command.get_description();
  text = text.substr(0, text.find(". "));
  if (text.ends_with('.')) text.pop_back();
  if (!text.empty()) text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return text;
}

std::vector<std::string> NamesOf(const std::set<CLI::Option*>& options) {
  std::vector<std::string> names;
  names.reserve(options.size());
  for (const CLI::Option* option : options) names.push_back(Bold(Names(*option).back()));
  return names;
}

/// Of "N:INT in [2 - 640]" or "S:POSITIVE".
std::string Range(const CLI::Option& option) {
  const std::string type = option.get_type_name().substr(ValueName(option).size());
  if (type == ":POSITIVE") return "Above 0";
  if (type == ":NONNEGATIVE") return "0 or more";
  const std::size_t begin = type.find('[');
  const std::size_t middle = type.find(" - ");
  const std::size_t end = type.find(']');
  if (begin == std::string::npos || middle == std::string::npos || end == std::string::npos) {
    return "";
  }
  return fmt::format("From {} to {}",
                     type.substr(begin + 1, middle - begin - 1),
                     type.substr(middle + 3, end - middle - 3));
}

/// Its description and what else --help says of it.
std::string Description(const CLI::Option& option) {
  std::string text = Escaped(option.get_description());
  const auto add = [&text](const std::string& sentence) {
    if (!text.empty() && !text.ends_with('.')) text += '.';
    text += "\n" + sentence + ".";
  };
  if (option.get_required()) add("Required");
  if (const auto choices = Choices(option); !choices.empty()) {
    add(Escaped(fmt::format("One of {}", fmt::join(choices, ", "))));
  } else if (const std::string range = Range(option); !range.empty()) {
    add(Escaped(range));
  }
  if (!option.get_default_str().empty()) add("Default: " + Escaped(option.get_default_str()));
  if (const auto others = NamesOf(option.get_excludes()); !others.empty()) {
    add(fmt::format("Not together with {}", fmt::join(others, ", ")));
  }
  if (const auto others = NamesOf(option.get_needs()); !others.empty()) {
    add(fmt::format("Only with {}", fmt::join(others, ", ")));
  }
  return text;
}

std::string Entry(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : Names(option)) names.push_back(Bold(name));
  std::string head = fmt::format("{}", fmt::join(names, ", "));
  if (names.empty()) head = Italic(option.get_single_name());
  const std::string value = ValueOf(option) == Value::kNone ? "" : ValueName(option);
  if (!value.empty()) head += " " + Italic(value);
  return fmt::format(".TP\n{}\n{}\n", head, Description(option));
}

/// The arguments, then the options by their groups.
std::string Options(const CLI::App& command) {
  std::string arguments;
  std::string text = ".SH OPTIONS\n";
  for (const std::string& group : command.get_groups()) {
    std::string entries;
    for (const CLI::Option* option : command.get_options()) {
      if (option->get_group() != group || group.empty()) continue;
      (option->nonpositional() ? entries : arguments) += Entry(*option);
    }
    if (entries.empty()) continue;
    if (group != "Options") text += ".SS " + Escaped(group) + "\n";
    text += entries;
  }
  return (arguments.empty() ? "" : ".SH ARGUMENTS\n" + arguments) + text;
}

std::string Synopsis(const CLI::App& command) {
  std::string line = Bold(FullName(command));
  if (!Commands(command).empty())
    return line + " " + Italic("COMMAND") + " [" + Italic("OPTIONS") + "]";
  for (const CLI::Option* option : command.get_options()) {
    if (!option->nonpositional()) continue;
    if (option->get_required()) {
      line += fmt::format(" {} {}", Bold(Names(*option).back()), Italic(ValueName(*option)));
    }
  }
  line += " [" + Italic("OPTIONS") + "]";
  for (const CLI::Option* option : command.get_options()) {
    if (option->nonpositional()) continue;
    const std::string more = option->get_items_expected_max() > 1 ? " ..." : "";
    const std::string name = Italic(option->get_single_name()) + more;
    line += option->get_required() ? " " + name : " [" + name + "]";
  }
  return line;
}

std::string CommandList(const CLI::App& command) {
  std::string text = ".SH COMMANDS\n";
  for (const CLI::App* below : Commands(command)) {
    text +=
        fmt::format(".TP\n{}\n{}\n", Bold(below->get_name()), Escaped(below->get_description()));
  }
  return text;
}

/// The end of --help: "Example:" with its indented lines, and notes.
std::string ExamplesAndNotes(const CLI::App& command) {
  std::istringstream footer(command.get_footer());
  std::string examples;
  std::string notes;
  for (std::string line; std::getline(footer, line);) {
    if (line.starts_with("  ")) {
      examples += Escaped(line.substr(2)) + "\n";
    } else if (!line.empty() && line != "Example:") {
      notes += Escaped(line) + "\n";
    }
  }
  if (!examples.empty()) examples = ".SH EXAMPLES\n.EX\n" + examples + ".EE\n";
  return examples + (notes.empty() ? "" : ".SH NOTES\n" + notes);
}

std::string SeeAlso(const CLI::App& command) {
  std::vector<std::string> pages;
  const auto add = [&pages](const CLI::App& other) {
    pages.push_back(fmt::format("{}(1)", Bold(PageName(other))));
  };
  if (command.get_parent() != nullptr) add(*command.get_parent());
  for (const CLI::App* below : Commands(command)) add(*below);
  return fmt::format(".SH SEE ALSO\n{}\n", fmt::join(pages, ",\n"));
}

std::string Page(const CLI::App& command, const std::string& version) {
  std::string title = PageName(command);
  std::string text = fmt::format(".SH NAME\n{} \\- {}\n.SH SYNOPSIS\n{}\n.SH DESCRIPTION\n{}\n",
                                 Escaped(title),
                                 Escaped(Purpose(command)),
                                 Synopsis(command),
                                 Escaped(command.get_description()));
  std::transform(title.begin(), title.end(), title.begin(), [](unsigned char c) {
    return static_cast<char>(std::toupper(c));
  });
  if (!Commands(command).empty()) text += CommandList(command);
  text += Options(command) + ExamplesAndNotes(command);
  return fmt::format(
             ".TH {} 1 \"\" \"{}\" \"User Commands\"\n.nh\n.ad l\n", Escaped(title), version) +
         text +
         ".SH EXIT STATUS\n.TP\n0\nThe command is done.\n.TP\n1\nThe run failed.\n.TP\n2\n"
         "Arguments or input files cannot be used.\n" +
         SeeAlso(command);
}

void AddPages(const CLI::App& command,
              const std::string& version,
              std::map<std::string, std::string>& pages) {
  pages[PageName(command)] = Page(command, version);
  for (const CLI::App* below : Commands(command)) AddPages(*below, version, pages);
}

}  // namespace

std::map<std::string, std::string> ManPages(const CLI::App& program, const std::string& version) {
  std::map<std::string, std::string> pages;
  AddPages(program, version, pages);
  return pages;
}

}  // namespace ceilmap::manual
