#pragma once
// Frames for ParaView, at multiples of output.frame_interval.

#include "io/frames/frame.hpp"
#include "simulation/outputs/output.hpp"

namespace bulkley {

class FrameOutput : public Output {
 public:
  FrameOutput(Run& run, GlobalIndex restart_step);  ///< Collective.
  bool is_due(const Run& run, const Occasion& occasion) const override;
  void write(Run& run) override;

 private:
  void write_with_grid(Run& run, const TileValues* tiles);
  void write_frame_of(Run& run, const GridNodes* nodes, const TileValues* tiles);

  ColliderSurfaces colliders_;  ///< none in runs without frames
  std::optional<FrameSeries> series_;
};

}  // namespace bulkley
