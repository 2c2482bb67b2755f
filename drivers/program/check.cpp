#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/duration.hpp"
#include "program/check_meshes.hpp"
#include "program/commands.hpp"
#include "program/human_text.hpp"
#include "simulation/forecast.hpp"
#include "simulation/setup.hpp"

namespace bulkley {

namespace {

std::string dimensionless(double value) { return std::isnan(value) ? std::string("-") : fmt::format("{:.3g}", value); }

void print_colliders(const Scene& scene) {
  for (const Collider& collider : scene.colliders) {
    const Bounds b = bounds(collider.shape);
    const bool is_finite = b.lower.allFinite() && b.upper.allFinite();
    const Vec3 size = b.upper - b.lower;
    const double fastest = collider_speed(scene.grid, {collider}, 0.0, scene.time_stepping.end_time);
    fmt::print("collider   {}: {}, {}{}\n", collider.name, name(collider.contact),
               is_finite ? fmt::format("{:.4g} x {:.4g} x {:.4g} m", size[0], size[1], size[2]) : std::string("endless"),
               collider.motion.moves() ? fmt::format(", moves at up to {:.4g} m/s", fastest) : std::string());
  }
}

void print_measurements(const Scene& scene) {
  for (const Front& front : scene.output.fronts)
    fmt::print("front      {}: {}{}\n", front.name,
               front.quantile == 1.0 ? std::string("the farthest particle")
                                     : fmt::format("{:g} % of the mass", 100.0 * front.quantile),
               front.material ? fmt::format(" of {}", *front.material) : std::string());
  for (const Gauge& gauge : scene.output.gauges) {
    const double area = gauge_area(scene.grid, gauge, scene.colliders);
    const std::string wall = gauge.face ? face_names[static_cast<std::size_t>(*gauge.face)] : *gauge.collider;
    const double n = gauge.face ? static_cast<double>(count_gauge_nodes(scene.grid, gauge))
                                : std::ceil(area / (scene.grid.cell_size * scene.grid.cell_size));
    fmt::print("gauge      {}: {:.4g} m^2 of {}, {}\n", gauge.name, area, wall,
               gauge.face ? counted(n, "node") : "about " + counted(n, "cell"));
  }
}

// Largest disk use: a checkpoint is complete before an older one is deleted.
void print_disk(const Scene& scene, const Forecast& f) {
  const auto checkpoint = static_cast<double>(f.checkpoint_bytes), frame = static_cast<double>(f.frame_bytes);
  const auto n_frames = static_cast<double>(f.n_frames);
  std::string frames = "no frames";
  if (f.n_frames > 0)
    frames = fmt::format("{} of {}: {}", counted(n_frames, "frame"), bytes_text(frame), bytes_text(n_frames * frame));
  if (f.n_frames > 0 && scene.output.compression > 0) frames += " before compression";
  const bool moves = std::ranges::any_of(scene.colliders, [](const Collider& c) { return c.motion.moves(); });
  if (f.n_frames > 0 && moves) frames += ", and in each the colliders that move";
  fmt::print("disk       checkpoints of {}: {} at most; {}\n", bytes_text(checkpoint),
             bytes_text(checkpoint * (scene.checkpoint.keep + 1)), frames);
}

void print_choice(const Scene& scene, const IntegratorChoice& choice) {
  const auto print_integrator = [](const char* label, const IntegratorForecast& f, const std::string& cost) {
    fmt::print("{:<10} about {:.2g} s a step once bodies move at U, limited by: {}; {:.0f} steps{}{}\n", label, f.limit.dt,
               name(f.limit.limiter), f.n_steps,
               f.n_impact_steps > 0.0 ? fmt::format(", {:.0f} of them for impacts", f.n_impact_steps) : std::string(), cost);
  };
  print_integrator("explicit", choice.explicit_step, "");
  print_integrator("imex", choice.imex, fmt::format(", each at about {:.2g} times the cost", choice.imex.step_cost));
  const bool chosen = choice.cheaper == scene.time_stepping.integrator;
  fmt::print("cheaper    {}{}: {}\n", choice.cheaper == IntegratorKind::imex ? "imex" : "explicit",
             chosen ? ", which the scene has" : "", choice.reason);
  for (const std::string& note : choice.notes) fmt::print("note: {}\n", note);
}

void print_magnetics(const MagneticForecast& f, const Forecast& all) {
  fmt::print("field      {} x {} x {} nodes, {} levels down to {} x {} x {}; about {:.1f} MiB on a rank\n", f.n_nodes[0],
             f.n_nodes[1], f.n_nodes[2], f.n_levels, f.coarsest[0], f.coarsest[1], f.coarsest[2],
             f.bytes_per_rank / (1024.0 * 1024.0));
  fmt::print("solution   about {:.2g} s on one rank, every {:.0f} steps at the largest U: {:.0f} ns a particle and step\n",
             f.solve_cost, f.steps_a_solve, 1e9 * f.solve_cost / (f.steps_a_solve * static_cast<double>(all.n_particles)));
  for (const MagneticBodyForecast& b : f.bodies)
    fmt::print("magnetic   {}: applied field up to {:.4g} A/m; as a ball M = {:.4g} A/m, mu_0 M^2/2 = {:.4g} Pa\n", b.name,
               b.applied, b.magnetisation, b.traction);
}

void print(const Scene& scene, const Forecast& f) {
  const GridGeometry& grid = scene.grid;
  const Vec3 upper = grid.upper();
  fmt::print("scene      {}\n", scene.title.empty() ? "(no title)" : scene.title);
  fmt::print("domain     ({:g}, {:g}, {:g}) to ({:g}, {:g}, {:g}) m\n", grid.lower[0], grid.lower[1], grid.lower[2],
             upper[0], upper[1], upper[2]);
  fmt::print("grid       {} x {} x {} cells of {:g} m; {} nodes, {} tiles\n", grid.n_cells[0], grid.n_cells[1],
             grid.n_cells[2], grid.cell_size, GlobalIndex{grid.n_nodes(0)} * grid.n_nodes(1) * grid.n_nodes(2),
             grid.n_tiles());
  fmt::print("particles  {}{}\n", f.n_particles, scene.inflows.empty() ? "" : " at the end");
  fmt::print("\n{:<21}{:<21}{:>12}{:>12}{:>12}{:>10}{:>12}{:>10}{:>10}{:>10}\n", "body", "material", "particles",
             "mass [kg]", "U [m/s]", "L [m]", "c [m/s]", "Re", "Bi", "Ma");
  for (const BodyForecast& b : f.bodies)
    fmt::print("{:<21}{:<21}{:>12}{:>12.4g}{:>12}{:>10.3g}{:>12.4g}{:>10}{:>10}{:>10}\n", b.name, b.material, b.n_particles,
               b.mass, fmt::format("{:.4g}{}", b.speed, b.at_rest ? "*" : ""), b.size, b.wave_speed,
               dimensionless(b.reynolds), dimensionless(b.bingham), dimensionless(b.mach));
  for (const BodyForecast& b : f.bodies)
    if (b.at_rest) {
      fmt::print("* starts at rest: U = sqrt(g L)\n");
      break;
    }
  fmt::print(
      "Re = rho U^2 / (tau_y + K (U/L)^n), Bi = tau_y / (K (U/L)^n), Ma = U / c; '-' where the material does not flow\n");
  for (const NamedMaterial& m : scene.materials)
    if (const auto* fluid = std::get_if<HerschelBulkley>(&m.material)) {
      const ShearRheometerConstants c = shear_rheometer_constants(fluid->parameters);
      fmt::print(
          "{}: shear rheometer yield_stress = {:.6g} Pa, consistency = {:.6g} Pa s^n, flow_index = {:g}; "
          "Yue sigma_Y = {:.6g} Pa, eta = {:.6g} Pa s^h, h = {:g}\n",
          m.name, c.yield_stress, c.consistency, c.flow_index, fluid->parameters.sigma_Y, fluid->parameters.eta,
          fluid->parameters.h);
    }
  print_colliders(scene);
  print_measurements(scene);
  print_meshes(scene, f);
  fmt::print("\nranks      {}{}: at most {} particles a rank, imbalance {:.3f}\n", f.n_ranks, boxes_text(f.boxes),
             f.largest_share, f.imbalance);
  fmt::print(
      "memory     about {:.1f} MiB on the most loaded rank, beyond the empty program; {:.0f} bytes per particle in all\n",
      f.bytes_per_rank / (1024.0 * 1024.0), f.bytes_per_particle);
  print_disk(scene, f);
  fmt::print("time step  {:.4g} s at the start, limited by: {}\n", f.limit.dt, name(f.limit.limiter));
  fmt::print("steps      about {:.0f} to t = {:g} s\n", f.n_steps, scene.time_stepping.end_time);
  if (f.choice) print_choice(scene, *f.choice);
  if (f.magnetic) print_magnetics(*f.magnetic, f);
  for (const std::string& warning : f.warnings) fmt::print("warning: {}\n", warning);
}

}  // namespace

Command add_check(CLI::App& app) {
  struct Arguments {
    SceneArguments scene;
    int n_ranks = 0;
  };
  auto a = std::make_shared<Arguments>();
  a->scene.declare(app);
  app.add_option("-n,--ranks", a->n_ranks, "number of ranks to predict for (default: those that it runs on)")
      ->check(CLI::Range(1, 1 << 22))
      ->type_name("RANKS");
  return [a](const Comm& comm) {
    const Scene scene = a->scene.load(comm);
    check_bodies(scene, shared_survey(comm));
    check_magnetics(scene);
    check_colliders(scene);
    check_rigid_bodies(scene);
    check_gauges(scene);
    check_petsc_options(comm, scene);
    const Forecast f = forecast(comm, scene, a->n_ranks > 0 ? a->n_ranks : comm.size());
    if (comm.is_root()) print(scene, f);
    return ExitCode::finished;
  };
}

}  // namespace bulkley
