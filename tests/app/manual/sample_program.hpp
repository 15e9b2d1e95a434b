#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace ceilmap::manual {

/// A command line with every kind of option: `tool draw [options] map`, `tool store put`.
struct SampleProgram {
  CLI::App app{"Draws maps."};
  std::string text;
  std::vector<std::string> texts;
  int count = 0;
  bool flag = false;

  SampleProgram() {
    app.name("tool");
    CLI::App* const draw = app.add_subcommand("draw", "Draws a map's parts. Slowly.");
    draw->add_option("map", text, "The map")->type_name("MAP.gpkg")->required();
    draw->add_option("-o,--output", text, "The result")->type_name("FILE.pdf|svg")->required();
    draw->add_option("--format", text, "Format")
        ->type_name("TEXT")
        ->check(CLI::IsMember({"ros", "png"}));
    draw->add_option("--folder", text, "A folder.")->type_name("DIR");
    draw->add_option("--up", text, "A video")->type_name("SOURCE");
    draw->add_option("--count", count, "How many")->type_name("N")->check(CLI::Range(2, 64));
    CLI::Option* const quiet = draw->add_flag("--quiet", flag, "Print less")->group("Common");
    draw->add_flag("--verbose", flag, "Print more")->group("Common")->excludes(quiet);
    draw->footer("Example:\n  tool draw a.gpkg -o 'b.pdf'\n.hidden files are not read.");
    CLI::App* const store = app.add_subcommand("store", "Keeps maps.");
    store->add_subcommand("put", "Adds maps.")
        ->add_option("maps", texts, "Maps")
        ->type_name("MAP.gpkg");
    app.add_subcommand("help", "Describes a command.");
  }
};

}  // namespace ceilmap::manual
