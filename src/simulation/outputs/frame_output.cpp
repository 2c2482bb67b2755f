#include "simulation/outputs/frame_output.hpp"

#include <fmt/format.h>

#include "simulation/setup.hpp"

namespace bulkley {

namespace {

/// What stands among the material or beside it: colliders, and magnets as if they were some, where no collider has their shape.
std::vector<Collider> shown_obstacles(const Scene& scene) {
  std::vector<Collider> shown = scene.colliders;
  if (!scene.magnetics) return shown;
  int number = 0;
  for (const FieldSource& source : scene.magnetics->sources) {
    ++number;
    if (source.moves_with) continue;  // a collider is drawn there
    if (const std::optional<Shape> body = body_of(source)) {
      Collider& magnet = shown.emplace_back();
      magnet.name = fmt::format("magnet {}", number);
      magnet.shape = *body;
    }
  }
  return shown;
}

}  // namespace

FrameOutput::FrameOutput(Run& run, GlobalIndex restart_step) {
  const Bounds domain{run.scene.grid.lower, run.scene.grid.upper()};
  if (run.scene.output.frame_interval > 0.0)
    colliders_ = ColliderSurfaces(shown_obstacles(run.scene), run.scene.rigid_bodies, domain);
  colliders_.write(run.comm, run.options.folder);
  series_.emplace(run.comm, run.options.folder, restart_step);  // lists the colliders if their file is there
  for (const std::string& warning : series_->warnings()) run.warn(warning);
}

bool FrameOutput::is_due(const Run& run, const Occasion& occasion) const {
  const double interval = run.scene.output.frame_interval;
  if (interval <= 0.0 || run.state.time < next_frame_time(run.state, interval, run.scene.time_stepping.end_time))
    return false;
  return (occasion.event == RunEvent::start && !run.options.restart) ||
         (occasion.event == RunEvent::step && run.last_step.plan.lands);
}

void FrameOutput::write(Run& run) {
  const double before = MPI_Wtime();
  SimulationState& state = run.state;
  const auto watch = run.watch_write(frame_path(run.options.folder, state.next_frame));
  if (run.scene.output.tiles) {
    const TileTotals totals = tile_totals(run.comm, run.scene.grid, run.solver->census(), state.cost);
    const TileValues tiles{run.scene.grid, run.solver->partition().map, totals.tile, totals.n_particles, totals.cost};
    write_with_grid(run, &tiles);
  } else {
    write_with_grid(run, nullptr);
  }
  series_->add(run.comm, state.next_frame);
  ++state.next_frame;
  ++state.frame_tick;
  run.clock.output += MPI_Wtime() - before;
}

void FrameOutput::write_with_grid(Run& run, const TileValues* tiles) {
  if (!run.scene.output.grid) return write_frame_of(run, nullptr, tiles);
  const std::vector<Node> values = run.solver->node_values(run.state.time);
  const FieldGrid& grid = run.solver->grid();
  const GridNodes nodes{run.scene.grid, grid.first(), grid.count(), values};
  write_frame_of(run, &nodes, tiles);
}

void FrameOutput::write_frame_of(Run& run, const GridNodes* nodes, const TileValues* tiles) {
  if (const RigidContact* const bodies = run.solver->rigid_bodies()) colliders_.set_body_poses(bodies->poses());
  const FrameInfo info{run.state.next_frame, run.state.step, run.state.time, 0};
  std::optional<BoxFields> box;
  if (run.scene.output.magnetic_field) box = run.solver->force_fields(run.state.time);
  write_frame(run.comm, run.options.folder, info, run.solver->particles(), run.scene.materials, run.scene.output, nodes,
              tiles, &colliders_, box ? &*box : nullptr);
}

}  // namespace bulkley
