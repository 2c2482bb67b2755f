#include <fmt/format.h>

#include <cstring>
#include <filesystem>

#include "base/text.hpp"
#include "config/duration.hpp"
#include "program/commands.hpp"
#include "program/version.hpp"
#include "simulation/simulation.hpp"

namespace bulkley {

namespace {

struct RunArguments {
  SceneArguments scene;
  RunOptions options;
  std::string walltime;
  CLI::Option* restart = nullptr;
};

// The command that continues the run, on any number of ranks; without limits of this part, except the wall time.
std::string continuation(const RunArguments& a, const std::string& folder) {
  std::string text = "bulkley run " + shell_word(a.scene.file);
  for (const std::string& override : a.scene.overrides) text += " --set " + shell_word(override);
  text += " --out " + shell_word(folder) + " --restart";
  if (!a.walltime.empty()) text += " --max-walltime " + shell_word(a.walltime);
  return text;
}

}  // namespace

Command add_run(CLI::App& app) {
  auto a = std::make_shared<RunArguments>();
  a->scene.declare(app);
  app.add_option("--out", a->options.folder, "folder for everything the run writes (default: out/NAME-OF-SCENE)")
      ->type_name("DIR");
  a->restart = app.add_option("--restart", a->options.restart_file,
                              "continue from this checkpoint, or from the newest complete one in the output folder")
                   ->type_name("[FILE.h5]")
                   ->expected(0, 1);
  app.add_flag("--changed-scene", a->options.changed_scene,
               "continue although the scene differs from the checkpoint's in more than title, time.end, [output], "
               "[checkpoint] and [partition]");
  app.add_option("--max-steps", a->options.max_steps, "end after this step number")->check(CLI::NonNegativeNumber);
  app.add_option("--max-walltime", a->walltime, "stop before this wall time with a checkpoint, exit code 4: 1h55m, 90s")
      ->type_name("TIME");
  app.add_flag("--overwrite", a->options.overwrite, "delete an earlier run in the output folder");
  app.add_flag("--quiet", a->options.quiet, "no progress lines");
  return [a](const Comm& comm) {
    RunOptions options = a->options;
    options.begin = MPI_Wtime();
    if (options.folder.empty()) options.folder = "out/" + std::filesystem::path(a->scene.file).stem().string();
    options.restart = a->restart->count() > 0;
    if (options.restart && options.overwrite)
      throw UsageError("--restart continues a run and --overwrite deletes it: give one of them");
    if (!a->walltime.empty()) options.max_walltime = parse_duration(a->walltime);
    options.program = version_text();
    options.continuation = continuation(*a, options.folder);
    // A restart seeds nothing: the files of its bodies may be gone.
    const Scene scene = a->scene.load(comm, options.restart ? MeshesOf::colliders : MeshesOf::everything);
    const RunOutcome outcome = run_simulation(comm, scene, options);
    return outcome == RunOutcome::finished ? ExitCode::finished : ExitCode::stopped;
  };
}

}  // namespace bulkley
