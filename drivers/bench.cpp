// `bulkley bench`: the real step on a fixed scene, phase by phase, beside a naive serial kernel timed in the same run.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "bulkley/io/status.hpp"
#include "bulkley/io/text_file.hpp"
#include "bulkley/kernel/stress_update.hpp"
#include "bulkley/material/preset.hpp"
#include "bulkley/simulation_setup.hpp"
#include "commands.hpp"
#include "support/naive_kernel.hpp"

namespace bulkley {

namespace {

constexpr double shear_rate = 25.0;  // 1/s, so that every particle of a fluid yields
constexpr int particles_per_cell = 8;
constexpr double radius_in_box = 31.0 / 80.0;

struct Arguments {
  GlobalIndex n_particles = 1'000'000;
  std::string material = "cream";
  int n_steps = 50;
  std::string scheme = "apic", order = "quadratic", gradient = "mls";
  std::string json;
  bool naive = true;
};

Material material_named(const std::string& name) {
  if (name == "neo_hookean") return NeoHookean{{1000.0, 83333.3, 38461.5}};  // E = 1e5 Pa, nu = 0.3
  if (const auto preset = find_preset(name)) return preset->material;
  throw UsageError(fmt::format("--material {}: not known; one of neo_hookean, {}", name, preset_names()));
}

// A ball in a unit box on a grid that gives about n_particles.
Scene bench_scene(const Arguments& a) {
  Scene scene;
  scene.title = "bench";
  const double volume = 4.0 / 3.0 * M_PI * std::pow(radius_in_box, 3);
  const int n = static_cast<int>(std::lround(std::cbrt(static_cast<double>(a.n_particles) / (particles_per_cell * volume))));
  if (n < 18) throw UsageError(fmt::format("--particles {}: too few, at least 11500 are needed", a.n_particles));
  scene.grid.n_cells = {n, n, n};
  scene.grid.cell_size = 1.0 / n;
  scene.transfer.scheme = a.scheme == "apic"   ? TransferScheme::apic
                          : a.scheme == "pic"  ? TransferScheme::pic
                          : a.scheme == "flip" ? TransferScheme::flip
                                               : TransferScheme::blend;
  scene.transfer.order = scene.grid.order = a.order == "cubic" ? SplineOrder::cubic : SplineOrder::quadratic;
  scene.transfer.gradient = a.gradient == "bspline" ? GradientForm::bspline : GradientForm::mls;
  scene.gravity = {0.0, 0.0, -9.81};
  scene.materials = {{a.material, material_named(a.material)}};
  scene.faces.fill({FaceKind::separating, 0.0});
  scene.time.end_time = 1.0;
  Body ball;
  ball.name = "ball";
  ball.shape = {Sphere{{0.5, 0.5, 0.5}, radius_in_box}};
  ball.material = a.material;
  ball.density = std::visit([](const auto& law) { return law.density(); }, scene.materials[0].material);
  ball.velocity = {0.0, 0.0, -2.0};
  ball.center = {0.5, 0.5, 0.5};
  ball.particles_per_cell = particles_per_cell;
  ball.lattice = SeedingLattice::jittered;
  scene.bodies = {ball};
  return scene;
}

// Gives the ball a uniform shear and, by marching the law at rest, the stress of a fluid that has been sheared for a while.
void shear(const Scene& scene, ParticleSet& particles) {
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    particles.real(Field::velocity, 0)[p] += shear_rate * (particles.real(Field::position, 1)[p] - 0.5);
    particles.real(Field::affine_velocity, 1)[p] = shear_rate;
  }
  if (!std::holds_alternative<HerschelBulkley>(scene.materials[0].material)) return;
  StepBounds ignored;
  constexpr int n_marches = 40;
  for (int k = 0; k < n_marches; ++k)
    stress_update(scene.materials[0].material, 0, Field::affine_velocity, 0.25 / shear_rate / n_marches, particles, ignored);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[values.size() / 2];
}

struct Result {
  GlobalIndex n_particles = 0;
  double total = 0.0;                                  // ns per particle, step and rank; median of blocks
  std::vector<std::pair<std::string, double>> phases;  // likewise, mean over ranks and blocks
  double naive = 0.0;                                  // ns per particle and step, serial
  double yielded = 0.0;                                // fraction of particles that flow
  double bytes_per_particle = 0.0;                     // peak resident set of the process over its particles
  double bytes_sent = 0.0;                             // by the busiest rank in one step's exchange
};

Result measure(const Comm& comm, const Arguments& a) {
  const Scene scene = bench_scene(a);
  const double before = static_cast<double>(peak_resident_bytes());
  Partition partition = make_partition(scene.grid, scene.partition, seeded_load(comm, scene), comm.size());
  ParticleSet particles = seed_share(comm, scene, partition);
  shear(scene, particles);
  Solver solver(comm, physics_of(scene), std::move(partition), std::move(particles), std::nullopt);

  TimeStepState state;
  state.stable_step = time_step_limit(scene.time, scene.grid.cell_size, solver.bounds()).dt;
  state.wait = scene.time.trial_interval;
  state.first_limit = state.stable_step;
  auto advance = [&](int n) {
    for (int k = 0; k < n; ++k) solver.step(scene.time.end_time, 0, state);
  };
  advance(3);  // warm caches, first pool
  const double memory = static_cast<double>(peak_resident_bytes()) - before;

  std::unique_ptr<NaiveKernel> naive;
  if (a.naive && comm.is_root()) naive = std::make_unique<NaiveKernel>(scene.grid.n_cells[0], radius_in_box);

  Result result;
  result.n_particles = solver.bounds().n_particles;
  const auto n = static_cast<double>(result.n_particles);
  constexpr int block = 10;
  std::vector<double> blocks, naive_steps;
  const std::vector<PhaseSummary> start = summarize(comm, solver.times());
  int n_steps = 0;
  while (n_steps < a.n_steps) {
    BULKLEY_MPI(MPI_Barrier(comm.get()));
    const double begin = MPI_Wtime();
    advance(block);
    blocks.push_back(max_global(comm, MPI_Wtime() - begin) / block);
    n_steps += block;
    // Interleaved, so that both kernels see the same machine.
    if (naive)
      for (int k = 0; k < 3; ++k) naive_steps.push_back(naive->step());
  }
  const double scale = 1e9 * comm.size() / n;
  result.total = median(blocks) * scale;
  for (const PhaseSummary& phase : summarize(comm, solver.times())) {
    double earlier = 0.0;
    for (const PhaseSummary& s : start)
      if (s.name == phase.name) earlier = s.mean;
    result.phases.emplace_back(phase.name, (phase.mean - earlier) / n_steps * scale);
  }
  if (naive) result.naive = median(naive_steps) * 1e9 / static_cast<double>(naive->size());
  GlobalIndex flowing = 0;
  const double* rate = solver.particles().real(Field::plastic_shear_rate);
  for (LocalIndex p = 0; p < solver.particles().size(); ++p) flowing += rate[p] > 0.0 ? 1 : 0;
  result.yielded = static_cast<double>(sum_global(comm, flowing)) / n;
  result.bytes_per_particle = max_global(comm, memory) * comm.size() / n;
  const Exchange& exchange = solver.exchange();
  result.bytes_sent = max_global(comm, static_cast<double>(exchange.sent_by_add().bytes + exchange.sent_by_get().bytes));
  return result;
}

std::string json(const Comm& comm, const Arguments& a, const Result& r) {
  std::string phases;
  for (const auto& [phase, ns] : r.phases)
    phases += fmt::format("{}\n    \"{}\": {:.3f}", phases.empty() ? "" : ",", phase, ns);
  return fmt::format(
      "{{\n  \"particles\": {},\n  \"ranks\": {},\n  \"material\": \"{}\",\n  \"scheme\": \"{}\",\n  \"order\": \"{}\",\n"
      "  \"gradient\": \"{}\",\n  \"steps\": {},\n  \"yielded_fraction\": {:.4f},\n  \"ns_per_particle_step\": {:.3f},\n"
      "  \"phases_ns_per_particle_step\": {{{}\n  }},\n  \"naive_neo_hookean_ns_per_particle_step\": {:.3f},\n"
      "  \"ratio_to_naive\": {:.4f},\n  \"bytes_per_particle\": {:.1f},\n  \"exchange_bytes_per_step\": {:.0f}\n}}\n",
      r.n_particles, comm.size(), a.material, a.scheme, a.order, a.gradient, a.n_steps, r.yielded, r.total, phases, r.naive,
      r.naive > 0.0 ? r.total / r.naive : 0.0, r.bytes_per_particle, r.bytes_sent);
}

}  // namespace

Command add_bench(CLI::App& app) {
  auto a = std::make_shared<Arguments>();
  app.add_option("--particles", a->n_particles, "about how many, 8 per cell")
      ->check(CLI::Range(11500, 2'000'000'000))
      ->capture_default_str();
  app.add_option("--material", a->material, "neo_hookean or a preset: cream, pie, oobleck")->capture_default_str();
  app.add_option("--steps", a->n_steps, "steps to time, in blocks of 10")
      ->check(CLI::Range(10, 1000000))
      ->capture_default_str();
  app.add_option("--scheme", a->scheme)->check(CLI::IsMember({"apic", "pic", "flip", "blend"}))->capture_default_str();
  app.add_option("--order", a->order)->check(CLI::IsMember({"quadratic", "cubic"}))->capture_default_str();
  app.add_option("--gradient", a->gradient)->check(CLI::IsMember({"mls", "bspline"}))->capture_default_str();
  app.add_option("--json", a->json, "also write the result to this file")->type_name("FILE");
  app.add_flag("!--no-naive", a->naive, "leave the naive kernel out");
  return [a](const Comm& comm) {
    const Result result = measure(comm, *a);
    const std::string text = json(comm, *a, result);
    root_guard(comm, [&] {
      fmt::print("{}", text);
      if (a->json.empty()) return;
      if (const auto folder = std::filesystem::path(a->json).parent_path(); !folder.empty())
        std::filesystem::create_directories(folder);
      write_text_atomically(a->json, text);
    });
    return ExitCode::finished;
  };
}

}  // namespace bulkley
