// `bulkley partition`: what each way of dividing a scene among ranks would give, without running it.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>

#include "base/text.hpp"
#include "config/nearest.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "io/files/text_file.hpp"
#include "kernel/cells.hpp"
#include "program/commands.hpp"
#include "program/partition_table.hpp"
#include "simulation/setup.hpp"

namespace bulkley {

namespace {

constexpr int most_ranks = 1 << 20;

struct PartitionArguments {
  SceneArguments scene;
  std::string ranks, methods, frame, before, csv;
  int ranks_per_node = 0;
};

std::vector<int> rank_counts(const std::string& list) {
  std::vector<int> counts;
  for (const std::string& word : split(list, ',')) {
    int n = 0;
    const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), n);
    if (fault != std::errc{} || end != word.data() + word.size() || n < 1 || n > most_ranks)
      throw UsageError(fmt::format("--ranks: '{}' in '{}' is not a whole number from 1 to {}", word, list, most_ranks));
    counts.push_back(n);
  }
  return counts;
}

std::vector<PartitionMethod> methods_of(const std::string& list) {
  std::vector<PartitionMethod> methods;
  for (const std::string& word : list.empty() ? partition_method_names() : split(list, ',')) {
    const auto method = partition_method(word);
    if (!method)
      throw UsageError(
          fmt::format("--methods: there is no method '{}'{}", word, config::suggestion(word, partition_method_names())));
    methods.push_back(*method);
  }
  return methods;
}

/// What the scene's bodies put into the tiles. Counting proceeds in slices, so that it can report progress.
TileCensus count_start(const Scene& scene) {
  constexpr double patience = 2.0;  // s
  constexpr GlobalIndex n_slices = 100;
  const auto start = std::chrono::steady_clock::now();
  bool told = false;
  const auto n_tiles = GlobalIndex{scene.grid.n_tiles()};
  TileCensus all;
  for (GlobalIndex slice = 0; slice < n_slices; ++slice) {
    const TileCensus part = count_particles(scene.grid, scene.bodies, static_cast<TileIndex>(n_tiles * slice / n_slices),
                                            static_cast<TileIndex>(n_tiles * (slice + 1) / n_slices));
    all.n_materials = part.n_materials;
    all.tile.insert(all.tile.end(), part.tile.begin(), part.tile.end());
    all.count.insert(all.count.end(), part.count.begin(), part.count.end());
    all.cells.insert(all.cells.end(), part.cells.begin(), part.cells.end());
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (told || seconds < patience) continue;
    told = true;
    fmt::print(stderr, "counting the particles of the start; {} % of the grid after {:.0f} s\n", slice + 1, seconds);
  }
  return all;
}

struct Snapshot {
  CheckpointHeader header;
  TileCensus census;
};

Snapshot read_snapshot(const Comm& comm, const Scene& scene, const std::string& path) {
  const std::string file = resolve_checkpoint(comm, path);
  Snapshot snapshot{read_header(comm, file), {}};
  expect_materials(file, snapshot.header.material_names, scene);
  if (snapshot.header.scene_text != scene.effective_text)
    fmt::print(stderr, "warning: {}: was written by a scene that differs from this one\n", file);
  ParticleSet particles = no_particles(scene);
  read_checkpoint(comm, file, 0, snapshot.header.n_particles, particles);
  expect_inside(scene.grid, particles, file);
  snapshot.census = take_census(scene.grid, particles, static_cast<int>(scene.materials.size()));
  return snapshot;
}

PartitionTask task_of(const Comm& comm, const Scene& scene, const PartitionArguments& arguments) {
  PartitionTask task;
  task.grid = scene.grid;
  TileCensus census;
  if (arguments.frame.empty()) {
    census = count_start(scene);
  } else {
    Snapshot now = read_snapshot(comm, scene, arguments.frame);
    census = std::move(now.census);
    task.cost = load_cost(now.header.reals);  // those that the run has measured
  }
  task.ranks_per_node = arguments.ranks_per_node;
  task.cost.n_exchanges = scene.transfer.n_exchanges();
  task.n_particles = census.n_particles();
  if (task.n_particles == 0) throw UsageError("there are no particles to divide");
  task.load = tile_load(census, task.cost);
  if (!arguments.before.empty()) {
    const Snapshot then = read_snapshot(comm, scene, arguments.before);
    CostModel cost = load_cost(then.header.reals);  // by which the run made its map then: measured costs drift
    cost.n_exchanges = task.cost.n_exchanges;
    task.before = tile_load(then.census, cost);
  }
  return task;
}

void print_task(const Scene& scene, const PartitionTask& task) {
  fmt::print("scene      {}\n", scene.title.empty() ? "(no title)" : scene.title);
  fmt::print("grid       {} x {} x {} cells, {} tiles\n", task.grid.n_cells[0], task.grid.n_cells[1], task.grid.n_cells[2],
             task.grid.n_tiles());
  fmt::print("particles  {} in {} tiles\n", task.n_particles, task.load.size());
}

ExitCode run_partition(const Comm& comm, const PartitionArguments& arguments) {
  if (comm.size() > 1)
    throw UsageError("bulkley partition runs on one rank; -n gives the numbers of ranks to partition for");
  const std::vector<int> counts = rank_counts(arguments.ranks);
  const std::vector<PartitionMethod> methods = methods_of(arguments.methods);
  const Scene scene = arguments.scene.load(comm);
  const PartitionTask task = task_of(comm, scene, arguments);
  print_task(scene, task);
  std::vector<PartitionRow> all;
  for (const int n_ranks : counts) {
    std::vector<PartitionRow> rows = partition_rows(task, methods, n_ranks);
    fmt::print("{}", partition_table(rows));
    std::fflush(stdout);
    all.insert(all.end(), rows.begin(), rows.end());
  }
  if (!arguments.csv.empty()) write_text_atomically(arguments.csv, partition_csv(task, all));
  return ExitCode::finished;
}

}  // namespace

Command add_partition(CLI::App& app) {
  auto arguments = std::make_shared<PartitionArguments>();
  arguments->scene.declare(app);
  app.add_option("-n,--ranks", arguments->ranks, "numbers of ranks, such as 8,64,512")->required()->type_name("RANKS");
  app.add_option("--methods", arguments->methods, "methods to compare, such as hilbert,metis (default: all)")
      ->type_name("NAMES");
  app.add_option("--frame", arguments->frame, "particles of this checkpoint instead of the initial ones")
      ->type_name("CHECKPOINT.h5");
  app.add_option("--before", arguments->before,
                 "an earlier checkpoint: predicts how many particles change ranks if the map made for it is replaced")
      ->type_name("CHECKPOINT.h5");
  app.add_option("--ranks-per-node", arguments->ranks_per_node,
                 "also the part of the bytes that leaves a node of so many ranks that follow each other")
      ->type_name("NUMBER")
      ->check(CLI::Range(1, most_ranks));
  app.add_option("--csv", arguments->csv, "also write the numbers here")->type_name("FILE.csv");
  app.footer("What the columns mean: docs/partitions.md.");
  return [arguments](const Comm& comm) { return run_partition(comm, *arguments); };
}

}  // namespace bulkley
