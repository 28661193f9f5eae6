#include "client/cli/word_checks.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "client/cli/units.h"

namespace lightbatch::cli {
namespace {

std::string not_empty(const std::string& text) { return text.empty() ? "the value is empty" : ""; }

}  // namespace

std::string whole_number(const std::string& text) {
  return is_whole_number(text) ? "" : "'" + text + "' is no whole number of 64 bits";
}

std::string server_address(const std::string& text) {
  return is_server_address(text) ? "" : "'" + text + "' is not HOST:PORT";
}

void refuse_empty_values(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_expected_max() > 0) option->check(not_empty);
  }
  for (CLI::App* command : app.get_subcommands({})) refuse_empty_values(*command);
}

std::optional<std::string> unknown_command(const CLI::App& app, int argc, char** argv) {
  const CLI::App* at = &app;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.starts_with("-")) return std::nullopt;
    const auto commands = at->get_subcommands({});
    const auto named = std::find_if(commands.begin(), commands.end(),
                                    [&](const CLI::App* c) { return c->get_name() == word; });
    if (commands.empty()) return std::nullopt;
    if (named == commands.end()) return "there is no command '" + word + "'";
    at = *named;
  }
  return std::nullopt;
}

}  // namespace lightbatch::cli
