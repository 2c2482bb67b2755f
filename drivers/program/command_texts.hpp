#pragma once
// What the program's command line consists of, as data, and the pages and completions made from it.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace bulkley {

struct OptionText {
  std::vector<std::string> names;    ///< "--out", or the one name of a positional argument
  std::string value;                 ///< what it takes: "DIR"; empty: nothing
  std::vector<std::string> choices;  ///< the words that it takes, if only these
  std::string about;
  bool positional = false, required = false, repeats = false;
};

struct CommandText {
  std::string name, about;
  std::vector<OptionText> options;  ///< positional ones first
};

/// The subcommands of `app` in their order, without the options that every command has. Not collective.
std::vector<CommandText> command_texts(const CLI::App& app);

/// "bulkley run SCENE.toml [options]". Not collective.
std::string usage(const CommandText& command);

/// The page docs/command-line.md. Not collective.
std::string command_page(const std::vector<CommandText>& commands);
/// The manual page bulkley(1), in roff. Not collective.
std::string manual_page(const std::vector<CommandText>& commands);
/// Completions for bash and for zsh. Not collective.
std::string bash_completion(const std::vector<CommandText>& commands);
std::string zsh_completion(const std::vector<CommandText>& commands);

}  // namespace bulkley
