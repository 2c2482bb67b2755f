// docs/command-line.md and bulkley(1).

#include <fmt/format.h>

#include "bulkley/version.hpp"
#include "program/command_texts.hpp"

namespace bulkley {

namespace {

struct ExitText {
  int code;
  const char* meaning;
};
constexpr ExitText exit_texts[] = {
    {0, "The run reached its end; the question was answered."},
    {1, "The files that were compared differ (compare)."},
    {2, "The input is wrong: each fault is one line with file, line and column, the key, and what is allowed."},
    {3, "The run failed: the sentence says why and names the last good checkpoint."},
    {4,
     "The run stopped early with a good checkpoint (signal, file STOP or wall time): the last line is the command that "
     "goes on."},
};

struct VariableText {
  const char* name;
  const char* meaning;
};
constexpr VariableText variable_texts[] = {
    {"BULKLEY_PYTHON",
     "The interpreter that draws for `report` and `rheometer --plot`, with matplotlib; otherwise python3 on the PATH."},
    {"PETSC_OPTIONS", "Options for PETSc, beside those after `--`."},
};

std::string first_upper(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

std::string sentence(const std::string& text) {
  const std::string whole = first_upper(text);
  return whole.empty() || whole.back() == '.' ? whole : whole + ".";
}

std::string notes(const OptionText& option) {
  std::string text = sentence(option.about);
  if (option.required) text += " Required.";
  if (option.repeats && !option.positional && text.find("several times") == std::string::npos)
    text += " May be given several times.";
  return text;
}

std::string cell(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : c == '\n' ? std::string(" ") : std::string(1, c);
  return result;
}

// Roff reads a backslash as a command, a hyphen as a soft one, and a dot or apostrophe that begins a line as a request.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if ((c == '.' || c == '\'') && (result.empty() || result.back() == '\n')) result += "\\&";
    if (c == '-')
      result += "\\-";
    else if (c == '\\')
      result += "\\e";
    else if (c != '`')
      result += c;
  }
  return result;
}

}  // namespace

std::string command_page(const std::vector<CommandText>& commands) {
  std::string page =
      "# Command line\n\n"
      "<!-- Made by `bulkley command-reference`; a test compares. -->\n\n"
      "    bulkley COMMAND [arguments] [-- PETSc options]\n\n"
      "`run` is the one command that wants `mpirun`; `check`, `partition`, `convert` and `bench` may have it, the others "
      "take one "
      "rank. "
      "`bulkley COMMAND --help` prints a command's options, `bulkley --version` the version, the commit and the libraries. "
      "Everything for PETSc follows after `--`.\n\n"
      "| Command | |\n|---|---|\n";
  for (const CommandText& command : commands)
    page += fmt::format("| [`{0}`](#bulkley-{0}) | {1} |\n", command.name, cell(sentence(command.about)));
  for (const CommandText& command : commands) {
    page += fmt::format("\n## bulkley {}\n\n{}\n\n    {}\n", command.name, sentence(command.about), usage(command));
    if (!command.options.empty()) page += "\n| | |\n|---|---|\n";
    for (const OptionText& option : command.options)
      page += fmt::format("| `{}{}` | {} |\n", fmt::join(option.names, "`, `"),
                          option.value.empty() || option.positional ? "" : " " + cell(option.value), cell(notes(option)));
  }
  page += "\n## Exit codes\n\n| | |\n|---|---|\n";
  for (const ExitText& exit : exit_texts) page += fmt::format("| {} | {} |\n", exit.code, exit.meaning);
  page += "\n## Environment\n\n| | |\n|---|---|\n";
  for (const VariableText& variable : variable_texts)
    page += fmt::format("| `{}` | {} |\n", variable.name, variable.meaning);
  return page;
}

std::string manual_page(const std::vector<CommandText>& commands) {
  std::string page = fmt::format(
      ".\\\" Made by `bulkley command\\-reference \\-\\-format man`.\n"
      ".TH BULKLEY 1 \"\" \"Bulkley {}\" \"User commands\"\n"
      ".SH NAME\nbulkley \\- Material Point Method for non\\-Newtonian fluids and soft solids\n"
      ".SH SYNOPSIS\n.B mpirun \\-n\n.I RANKS\n.B bulkley run\n.I SCENE.toml\n[options] [\\-\\- PETSc options]\n.br\n"
      ".B bulkley\n.I COMMAND\n[options]\n"
      ".SH DESCRIPTION\n"
      "Computes how creams, pastes, suspensions and soft solids flow, bounce and settle, from a scene in TOML, on any "
      "number of\n"
      "MPI ranks, with the same bits on all of them. Runs restart from their checkpoints on any number of ranks and open "
      "in\n"
      "ParaView.\n.SH COMMANDS\n",
      version);
  for (const CommandText& command : commands) {
    page += fmt::format(".SS {}\n{}\n", roff(usage(command)), roff(sentence(command.about)));
    for (const OptionText& option : command.options)
      page += fmt::format(".TP\n.B {}\n{}\n",
                          roff(fmt::format("{}{}", fmt::join(option.names, ", "),
                                           option.value.empty() || option.positional ? "" : " " + option.value)),
                          roff(notes(option)));
  }
  page += ".SH EXIT STATUS\n";
  for (const ExitText& exit : exit_texts) page += fmt::format(".TP\n.B {}\n{}\n", exit.code, roff(exit.meaning));
  page += ".SH ENVIRONMENT\n";
  for (const VariableText& variable : variable_texts)
    page += fmt::format(".TP\n.B {}\n{}\n", variable.name, roff(variable.meaning));
  page +=
      ".SH FILES\n"
      "A run writes into its output folder: status.json, history.csv, scene.toml, frames.xdmf with frame_*.h5, and\n"
      "checkpoint_*.h5. A file named STOP in it asks the run to stop with a checkpoint.\n"
      ".SH SIGNALS\n"
      "SIGUSR1, SIGTERM and SIGINT to a rank: checkpoint and stop, exit status 4. SIGUSR2: checkpoint and go on.\n"
      ".SH SEE ALSO\n.BR mpirun (1),\n.BR paraview (1)\n";
  return page;
}

}  // namespace bulkley
