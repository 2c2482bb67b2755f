#include "program/command_texts.hpp"

#include <fmt/format.h>

#include "base/text.hpp"

namespace bulkley {

namespace {

// What an option takes. CLI11 writes a choice as "TEXT:{a,b}" and a checked number as "INT:NONNEGATIVE"; other types are as we
// named them, "shear|extension" among them.
void take_type(const std::string& type, OptionText& option) {
  option.value = type;
  for (const char* builtin : {"INT", "UINT", "FLOAT", "TEXT"})
    if (type.rfind(std::string(builtin) + ":", 0) == 0) option.value = builtin;
  const std::size_t open = type.find('{'), close = type.rfind('}');
  if (open != std::string::npos && close != std::string::npos && close > open) {
    option.choices = split(type.substr(open + 1, close - open - 1), ',');
    option.value = fmt::format("{}", fmt::join(option.choices, "|"));
  } else if (type.find('|') != std::string::npos) {
    option.choices = split(type, '|');
  }
}

OptionText option_text(const CLI::Option& from) {
  OptionText option;
  option.about = from.get_description();
  option.positional = from.get_positional();
  option.required = from.get_required();
  option.repeats = from.get_expected_max() > 1 || from.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  if (option.positional)
    option.names.push_back(from.get_name(true));
  else
    for (const std::string& name : from.get_snames()) option.names.push_back("-" + name);
  for (const std::string& name : from.get_lnames()) option.names.push_back("--" + name);
  if (from.get_items_expected_max() > 0) take_type(from.get_type_name(), option);
  if (option.positional && !option.value.empty() && option.choices.empty() && option.value != "TEXT")
    option.names.front() = option.value;
  return option;
}

// Those of a command and of the groups that its options form.
void add_options(const CLI::App& app, const CLI::Option* help, bool positional, std::vector<OptionText>& options) {
  for (const CLI::Option* option : app.get_options())
    if (option != help && option != app.get_help_ptr() && option->get_positional() == positional)
      options.push_back(option_text(*option));
  for (const CLI::App* group : app.get_subcommands([](const CLI::App* sub) { return sub->get_name().empty(); }))
    add_options(*group, help, positional, options);
}

}  // namespace

std::vector<CommandText> command_texts(const CLI::App& app) {
  std::vector<CommandText> commands;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    CommandText command{sub->get_name(), sub->get_description(), {}};
    for (const bool positional : {true, false}) add_options(*sub, sub->get_help_ptr(), positional, command.options);
    commands.push_back(std::move(command));
  }
  return commands;
}

std::string usage(const CommandText& command) {
  std::string text = "bulkley " + command.name;
  bool others = false;
  for (const OptionText& option : command.options) {
    if (!option.positional) {
      others = true;
      continue;
    }
    const std::string name = option.names.front() + (option.repeats ? "..." : "");
    text += option.required ? " " + name : " [" + name + "]";
  }
  return text + (others ? " [options]" : "");
}

}  // namespace bulkley
