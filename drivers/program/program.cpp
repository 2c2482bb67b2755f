// The program: sets up MPI and PETSc, hands over to a subcommand, and turns errors into exit codes.

#include "bulkley/program.hpp"

#include <fmt/format.h>
#include <petscsys.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "bench/child.hpp"
#include "bulkley/parallel/petsc.hpp"
#include "config/nearest.hpp"
#include "parallel/signals.hpp"
#include "program/commands.hpp"
#include "program/version.hpp"

namespace {

using namespace bulkley;

struct Entry {
  CLI::App* app;
  Command command;
};

// The sentence about a first word that is no command, which CLI11 would not name; empty if it is one.
std::string command_fault(const std::string& word, const std::vector<Entry>& entries) {
  std::vector<std::string> names;
  for (const Entry& entry : entries) names.push_back(entry.app->get_name());
  if (std::find(names.begin(), names.end(), word) != names.end()) return {};
  return fmt::format("bulkley: unknown command '{}'{}\nRun 'bulkley --help' for the commands.\n", word,
                     config::suggestion(word, names));
}

// Prints CLI11's help or error on the root; every rank returns the same code.
ExitCode report_parse(const Comm& comm, const CLI::App& app, const CLI::ParseError& error) {
  const bool wanted = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success);
  if (comm.is_root()) {
    if (wanted)
      app.exit(error);
    else
      fmt::print(stderr, "bulkley: {}\nRun 'bulkley --help' for the commands.\n", error.what());
  }
  return wanted ? ExitCode::finished : ExitCode::usage;
}

ExitCode run_command(const Comm& comm, int argc, char** argv) {
  CLI::App app(
      "Bulkley: Material Point Method for non-Newtonian fluids and soft solids, on any number of ranks.\n"
      "PETSc options may follow after '--'.",
      "bulkley");
  app.require_subcommand(1);
  app.set_version_flag("--version", version_text());
  std::vector<Entry> entries;
  auto add = [&](const char* name, const char* text, Command (*declare)(CLI::App&)) {
    CLI::App* sub = app.add_subcommand(name, text);
    entries.push_back({sub, declare(*sub)});
  };
  add("run", "run a scene", add_run);
  add("check", "validate a scene and predict its run, without running it", add_check);
  add("partition", "compare methods of partitioning a scene among ranks, without running it", add_partition);
  add("info", "print the contents of a checkpoint or frame and verify its checksums", add_info);
  add("compare", "compare the particles of two checkpoints", add_compare);
  add("convert", "write particles of frames or checkpoints as VTK files or CSV tables", add_convert);
  add("status", "print the progress of a run, while it runs or afterwards", add_status);
  add("report", "write a page about a run: its plots, time steps, costs, scene and pictures", add_report);
  add("rheometer", "measure a material at one point, with the solver's kernel, or fit a measured flow curve", add_rheometer);
  add("bench", "time the phases of a step on a fixed scene", add_bench);
  add("input-reference", "print the reference page of the scene file", add_input_reference);
  add("command-reference", "print the reference of the command line, the manual page or a completion",
      add_command_reference);
  add("presets", "list the materials known by name", add_presets);

  if (argc > 1 && argv[1][0] != '-')
    if (const std::string fault = command_fault(argv[1], entries); !fault.empty()) {
      if (comm.is_root()) fmt::print(stderr, "{}", fault);
      return ExitCode::usage;
    }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return report_parse(comm, app, error);
  }
  for (const Entry& entry : entries)
    if (entry.app->parsed()) return entry.command(comm);
  return ExitCode::usage;
}

// Errors that reach this point were thrown on every rank.
ExitCode guarded(const Comm& comm, int argc, char** argv) {
  try {
    return run_command(comm, argc, argv);
  } catch (const UsageError& error) {
    if (comm.is_root()) fmt::print(stderr, "{}\n", error.what());
    return ExitCode::usage;
  } catch (const RunError& error) {
    if (comm.is_root()) fmt::print(stderr, "bulkley: {}\n", error.what());
    return ExitCode::failed;
  } catch (const std::exception& error) {
    // Not one of our kinds: it may have been thrown on this rank alone, so the others must not be left waiting.
    abort_all_ranks(error.what(), __FILE__, __LINE__);
  }
}

}  // namespace

int bulkley::run_program(int argc, char** argv) {
  // hwloc, in MPI_Init, would connect to X displays to look for GPUs; a server that ends at that moment would end the rank.
  setenv("HWLOC_COMPONENTS", "-gl", 0);  // 0: what the user has set stays
  remember_environment();
  if (argc > 1 && std::strcmp(argv[1], "run") == 0) watch_signals();  // others may be interrupted at once
  // Our options precede "--", PETSc's follow it.
  int n_ours = argc;
  for (int k = 1; k < argc; ++k)
    if (std::strcmp(argv[k], "--") == 0) {
      n_ours = k;
      break;
    }
  std::vector<char*> petsc_arguments{argv[0]};
  std::string no_handler = "-no_signal_handler";
  petsc_arguments.push_back(no_handler.data());
  for (int k = n_ours + 1; k < argc; ++k) petsc_arguments.push_back(argv[k]);
  petsc_arguments.push_back(nullptr);
  int petsc_count = static_cast<int>(petsc_arguments.size()) - 1;
  char** petsc_argv = petsc_arguments.data();

  if (PetscInitialize(&petsc_count, &petsc_argv, nullptr, nullptr) != 0) {
    std::fputs("bulkley: PETSc could not be initialised\n", stderr);
    return static_cast<int>(ExitCode::failed);
  }
  install_assert_handler();
  ExitCode code;
  {
    const Comm comm(MPI_COMM_WORLD);
    code = guarded(comm, n_ours, argv);
  }
  BULKLEY_PETSC(PetscFinalize());
  return static_cast<int>(code);
}
