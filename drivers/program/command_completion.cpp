// Completions for shells.

#include <fmt/format.h>

#include "program/command_texts.hpp"

namespace bulkley {

namespace {

std::string words_of(const std::vector<CommandText>& commands) {
  std::string words;
  for (const CommandText& command : commands) words += command.name + " ";
  return words + "--help --version";
}

std::string option_words(const CommandText& command) {
  std::string words;
  for (const OptionText& option : command.options)
    if (!option.positional)
      for (const std::string& name : option.names) words += name + " ";
  return words + "--help";
}

// Inside single quotes of zsh's _arguments and _describe.
std::string zsh_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\'')
      result += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      result += std::string("\\") + c;
    else
      result += c == '\n' ? ' ' : c;
  }
  return result;
}

std::string zsh_value(const OptionText& option) {
  if (option.value.empty()) return {};
  const std::string words = fmt::format("{}", fmt::join(option.choices, " "));
  return fmt::format(":{}:{}", zsh_text(option.value), words.empty() ? "_files" : "(" + words + ")");
}

}  // namespace

std::string bash_completion(const std::vector<CommandText>& commands) {
  std::string text =
      "# Completion of bulkley for bash; made by `bulkley command-reference --format bash`.\n"
      "# Where nothing is offered bash completes names of files.\n"
      "_bulkley() {\n"
      "  local word=\"${COMP_WORDS[COMP_CWORD]}\" previous=\"${COMP_WORDS[COMP_CWORD - 1]}\" command=\"${COMP_WORDS[1]}\" "
      "words=\"\"\n"
      "  COMPREPLY=()\n";
  text += fmt::format("  if ((COMP_CWORD == 1)); then\n    words=\"{}\"\n  else\n    case \"$command $previous\" in\n",
                      words_of(commands));
  for (const CommandText& command : commands)
    for (const OptionText& option : command.options)
      if (!option.positional && !option.choices.empty())
        text += fmt::format("      \"{} {}\") words=\"{}\" ;;\n", command.name, option.names.back(),
                            fmt::join(option.choices, " "));
  text += "    esac\n  fi\n  if [[ -z \"$words\" && \"$word\" == -* ]]; then\n    case \"$command\" in\n";
  for (const CommandText& command : commands)
    text += fmt::format("      {}) words=\"{}\" ;;\n", command.name, option_words(command));
  text +=
      "    esac\n  fi\n"
      "  if [[ -n \"$words\" ]]; then mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\"); fi\n"
      "}\n"
      "complete -o bashdefault -o default -F _bulkley bulkley\n";
  return text;
}

std::string zsh_completion(const std::vector<CommandText>& commands) {
  std::string text =
      "#compdef bulkley\n"
      "# Completion of bulkley for zsh; made by `bulkley command-reference --format zsh`.\n"
      "_bulkley() {\n"
      "  local -a commands=(\n";
  for (const CommandText& command : commands) text += fmt::format("    '{}:{}'\n", command.name, zsh_text(command.about));
  text +=
      "  )\n"
      "  if ((CURRENT == 2)); then\n"
      "    _describe command commands\n"
      "    return\n"
      "  fi\n"
      "  local command=$words[2]\n"
      "  shift words\n"
      "  ((CURRENT--))\n"
      "  case $command in\n";
  for (const CommandText& command : commands) {
    text += fmt::format("    {})\n      _arguments \\\n", command.name);
    for (const OptionText& option : command.options)
      if (!option.positional)
        text += fmt::format("        '{}{}[{}]{}' \\\n", option.repeats ? "*" : "", option.names.back(),
                            zsh_text(option.about), zsh_value(option));
    text += "        '--help[print what the command takes]' \\\n        '*:file:_files'\n      ;;\n";
  }
  text += "  esac\n}\n_bulkley \"$@\"\n";
  return text;
}

}  // namespace bulkley
