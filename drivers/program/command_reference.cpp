#include <fmt/format.h>

#include "program/command_texts.hpp"
#include "program/commands.hpp"

namespace bulkley {

Command add_command_reference(CLI::App& app) {
  auto format = std::make_shared<std::string>("markdown");
  app.add_option("--format", *format, "a page in Markdown, a manual page, or a completion for a shell")
      ->check(CLI::IsMember({"markdown", "man", "bash", "zsh"}));
  return [format, &app](const Comm& comm) {
    if (!comm.is_root()) return ExitCode::finished;
    const std::vector<CommandText> commands = command_texts(*app.get_parent());
    const auto make = *format == "man"    ? manual_page
                      : *format == "bash" ? bash_completion
                      : *format == "zsh"  ? zsh_completion
                                          : command_page;
    fmt::print("{}", make(commands));
    return ExitCode::finished;
  };
}

}  // namespace bulkley
