// Writes the manual pages and the completion of the shell for the program, when it is built:
//   ceilmap_write_manual DIR   DIR/ceilmap.1, DIR/ceilmap-map.1, ..., DIR/ceilmap.bash

#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include "app/commands/help.hpp"
#include "app/manual/completion.hpp"
#include "app/manual/man_pages.hpp"
#include "app/program.hpp"

namespace {

void Write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text << std::flush;
  if (!file) throw std::runtime_error(path.string() + " cannot be written");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: ceilmap_write_manual DIR\n";
    return 2;
  }
  try {
    const std::filesystem::path folder = argv[1];
    const ceilmap::app::CommandLine line;
    std::filesystem::create_directories(folder);
    const std::string version = std::string("ceilmap ") + CEILMAP_VERSION;
    for (const auto& [name, page] : ceilmap::manual::ManPages(line.Program(), version)) {
      Write(folder / (name + ".1"), page);
    }
    Write(folder / "ceilmap.bash",
          ceilmap::manual::BashCompletion(line.Program(), ceilmap::commands::HelpTopics()));
  } catch (const std::exception& error) {
    std::cerr << "ceilmap_write_manual: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
