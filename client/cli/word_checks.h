#pragma once

#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace lightbatch::cli {

/// Checks for CLI11: empty when the text will do, else what is wrong with it.
/// strtoull, which CLI11 uses, takes -1 for the largest number.
std::string whole_number(const std::string& text);
std::string server_address(const std::string& text);

/// For every option: an unset variable of a script must not silently become the default.
void refuse_empty_values(CLI::App& app);

/// What to say when the first word, or the word after `scene`, is no command.
std::optional<std::string> unknown_command(const CLI::App& app, int argc, char** argv);

}  // namespace lightbatch::cli
