#pragma once
// The subcommands of `bulkley`: each declares its options and gives what to run.

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bulkley/parallel/comm.hpp"
#include "scene/scene.hpp"
#include "simulation/load_meshes.hpp"

namespace bulkley {

/// A subcommand, called after its options are parsed. Collective; throws UsageError or RunError on every rank.
using Command = std::function<ExitCode(const Comm&)>;

Command add_run(CLI::App& app);
Command add_check(CLI::App& app);
Command add_info(CLI::App& app);
Command add_partition(CLI::App& app);
Command add_compare(CLI::App& app);
Command add_convert(CLI::App& app);
Command add_bench(CLI::App& app);
Command add_rheometer(CLI::App& app);
Command add_input_reference(CLI::App& app);
Command add_command_reference(CLI::App& app);
Command add_presets(CLI::App& app);
Command add_status(CLI::App& app);
Command add_report(CLI::App& app);

/// A scene file and its overrides, as several subcommands take them.
struct SceneArguments {
  std::string file;
  std::vector<std::string> overrides;

  void declare(CLI::App& app);
  /// Reads the file and its meshes on the root, and parses it on every rank. Collective.
  Scene load(const Comm& comm, MeshesOf meshes = MeshesOf::everything) const;
};

/// Whole text of a file, read on the root. Throws UsageError when it cannot be read. Collective.
std::string read_on_root(const Comm& comm, const std::string& path);

/// The checkpoint that `path` means: itself, or the newest whole one if it is a folder. Throws UsageError. Collective.
std::string resolve_checkpoint(const Comm& comm, const std::string& path);

}  // namespace bulkley
