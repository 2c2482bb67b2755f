#pragma once
// Material that enters through a nozzle: an entry of [[inflows]] (docs/theory.md, "Inflow").
//
// Layers of particles are born behind the exit, move with the nozzle by formula and become ordinary particles once they have
// passed the exit. Which layers there are, and where, follows from the time alone: from the volume e(t) that has entered. Of a
// profile each column of a lattice across the section has layers of its own.

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "config/formula.hpp"
#include "geometry/rigid_motion.hpp"
#include "geometry/shape.hpp"
#include "grid/grid_geometry.hpp"
#include "particle/feed_profile.hpp"

namespace bulkley {

struct DiscSection {
  double radius;  ///< m
};
/// Sides along `side` of the inflow and across both it and the direction.
struct RectangleSection {
  double width, height;  ///< m
};
/// What the plane z = 0 cuts out of a shape, x along `side` of the inflow, y across both it and the direction.
struct ShapeSection {
  Shape shape;
};
using Section = std::variant<DiscSection, RectangleSection, ShapeSection>;

/// m^2; of a shape by the distances of 256 points a side, right to about 1e-4.
double area(const Section& section);
/// Signed distance from the point (a, b) of the exit plane, m, to the section's edge, negative inside; of a shape the distance in
/// space.
double signed_distance(const Section& section, double a, double b);
/// A rectangle around the section, m; z is 0. Of a shape that encloses nothing, lower > upper.
Bounds bounds(const Section& section);

/// A pressure, Pa, or that which the material has in front of the exit.
struct FeedPressure {
  double value = 0.0;
  bool is_measured = false;
};

/// A number, or a formula of the time t in s where `text` is not empty.
struct TimeFormula {
  double number = 0.0;
  std::string text;
};

/// Where the nozzle is and what has entered by then.
struct FeedFrame {
  double time = 0.0;             ///< s
  Vec3 position = Vec3::Zero();  ///< m, of the exit's centre
  double volume = 0.0;           ///< m^3, since the first key frame
};

/// What a scene says of one inflow.
struct Inflow {
  std::string name;
  std::string material;  ///< name of an entry of [materials]
  std::uint8_t material_index = 0;
  double density = 0.0;  ///< kg/m^3, of the material
  Section section = DiscSection{0.0};
  std::optional<Vec3> position;          ///< m, of the exit's centre, at t = 0 where the inflow moves; none with key frames
  Vec3 direction{0.0, 0.0, -1.0};        ///< of the flow, any length
  Vec3 side = Vec3::Zero();              ///< of a rectangle's width, or x of a shape; zero: chosen
  std::optional<TimeFormula> flow_rate;  ///< m^3/s
  std::optional<TimeFormula> speed;      ///< m/s
  std::vector<FeedFrame> key_frames;     ///< instead of position and rate, in the order of time; linear between
  std::string key_frames_file;           ///< CSV of key frames, by the root
  FeedProfile profile = FeedProfile::plug;
  OpenEnds open_ends{};       ///< of a rectangle with a profile
  double start = 0.0;         ///< s
  std::optional<double> end;  ///< s; none: it does not end
  FeedPressure pressure;      ///< at which the material enters
  double volume_ratio = 1.0;  ///< J of the feed, from the pressure; 1 where that is measured
  double wave_speed = 0.0;    ///< m/s, of the material at rest; only where the pressure is measured
  int particles_per_cell = 8;
  std::optional<std::string> moves_with;  ///< name of the collider whose motion it shares
  RigidMotion motion{};                   ///< that of the collider
  std::string place;                      ///< "file:line:column"
};

/// Unit vectors at t = 0: of the flow, and along the two coordinates of the section.
struct SectionFrame {
  Vec3 axis, first, second;
};
SectionFrame section_frame(const Inflow& inflow);
/// Whether the sides of the section along the frame's first and second axis span a plane flow, which has one particle there.
std::array<bool, 2> sides_across(const GridGeometry& grid, const Inflow& inflow);
/// The shorter side of the section's bounds, m, but for those that span a plane flow.
double narrowest_side(const GridGeometry& grid, const Inflow& inflow);

/// How the nozzle moves: a point x of it has the velocity `velocity` + `spin` x (x - position), the feed `speed` times the share of the
/// place along `axis` more.
struct NozzleState {
  Vec3 position, velocity, spin;
  Mat3 rotation;
  Vec3 axis;     ///< unit, of the flow
  double path;   ///< m, by which the feed has advanced since the start, at a stretch of 1, in the mean over the section
  double speed;  ///< m/s, of the feed, in the mean over the section
  double stretch =
      1.0;  ///< J of a pressure that is measured: by so much layers are nearer to each other, and the feed slower
};

/// The volume that has entered, e(t): closed forms of numbers and key frames, panels of fixed length for formulas. Nothing depends
/// on the time step.
class EnteredVolume {
 public:
  /// Throws UsageError with the reason where a formula is negative or has no value. `end_time`: of the run, s.
  EnteredVolume(const Inflow& inflow, double end_time);

  double start() const { return start_; }
  double end() const { return end_; }
  double volume(double time) const;  ///< m^3
  double rate(double time) const;    ///< m^3/s
  double largest_rate(double first, double last) const;

 private:
  std::size_t panel_of(double time) const;
  double integral(double from, double to) const;

  double start_, end_;     ///< s; endless where the scene gives no end
  double constant_ = 0.0;  ///< m^3/s, of a number
  double factor_ = 1.0;    ///< of the formula: the section's area for a speed
  std::shared_ptr<Formula> formula_;
  std::vector<double> panel_volume_, panel_largest_;  ///< until the panel's begin; m^3/s within it
  double panel_length_ = 0.0;
  std::vector<FeedFrame> frames_;
};

/// One inflow with all that follows from it. Not collective, as all here.
class Feed {
 public:
  /// `first_id`: of its particles. Throws UsageError with the reason, without the inflow's name.
  Feed(const GridGeometry& grid, const Inflow& inflow, GlobalIndex first_id, double end_time);

  /// A column of the lattice: a place in each layer.
  struct Point {
    Vec3 offset;                ///< m, from the exit's centre at t = 0
    GlobalIndex number;         ///< in row order over the section's box
    double share = 1.0;         ///< its speed over the mean
    Vec3 slope = Vec3::Zero();  ///< 1/m, of the share, at t = 0
    double phase = 0.0;         ///< layers by which its own lie behind those of a plug, -1/2 to 1/2
  };
  /// How far a feed has got by some time: which layers of which columns there are, or have passed the exit.
  struct Front {
    double path = 0.0;   ///< m, in the mean over the section
    double ahead = 0.0;  ///< m, by which all columns reach farther
  };

  const Inflow& inflow() const { return inflow_; }
  const std::vector<Point>& points() const { return points_; }
  /// A place of the exit, m from its centre at t = 0: the centre, or the place of the nearest particle where a shape leaves that out.
  Vec3 middle() const;
  double start() const { return entered_.start(); }
  double end() const { return entered_.end(); }
  double length() const { return length_; }                    ///< m, of the feed behind the exit
  double layer_height() const { return layer_; }               ///< m
  double particle_volume() const { return particle_volume_; }  ///< m^3, reference volume
  double entered_volume(double time) const { return entered_.volume(time); }
  bool runs(double time) const { return time >= start() && time < end(); }

  NozzleState at(double time, double stretch = 1.0) const;
  /// Distance of layer k of a column past the exit, m.
  double distance(const NozzleState& nozzle, GlobalIndex k, const Point& point) const {
    return nozzle.stretch * (point.share * nozzle.path - depth(k, point));
  }
  /// What has been born, or has passed the exit, by `time`.
  Front born(double time) const;
  Front released(double time) const;
  /// Layers 1 to that of a column are within the front.
  GlobalIndex n_layers(const Front& front, const Point& point) const;
  bool is_within(const Front& front, GlobalIndex k, const Point& point) const {
    return depth(k, point) < point.share * front.path + front.ahead;
  }
  /// Of all columns.
  GlobalIndex n_particles(const Front& front) const;

  bool owns(GlobalIndex id) const { return id >= first_id_ && id < first_id_ + ids_per_inflow; }
  GlobalIndex layer_of(GlobalIndex id) const { return (id - first_id_) / ids_per_layer; }
  GlobalIndex id_of(GlobalIndex layer, const Point& point) const { return first_id_ + layer * ids_per_layer + point.number; }
  /// The point of a particle's layer. Precondition: owns(id).
  const Point& point_of(GlobalIndex id) const;

  Vec3 position(const NozzleState& nozzle, GlobalIndex k, const Point& point) const {
    return nozzle.position + nozzle.rotation * point.offset + distance(nozzle, k, point) * nozzle.axis;
  }
  /// Of a place where the feed has this share of its mean speed.
  Vec3 velocity(const NozzleState& nozzle, const Vec3& position, double share) const {
    return nozzle.velocity + nozzle.spin.cross(position - nozzle.position) + (nozzle.speed * share) * nozzle.axis;
  }
  /// The velocity gradient that a profile shears a column with, 1/s, without the nozzle's spin.
  Mat3 shear(const NozzleState& nozzle, const Point& point) const {
    return nozzle.speed * nozzle.axis * (nozzle.rotation * point.slope).transpose();
  }
  bool is_plug() const { return shares_.is_plug(); }
  /// Share of the mean speed at a node.
  double share_at(const NozzleState& nozzle, const Vec3& node) const;
  /// Whether a point is in the nozzle, widened by `margin`, between `from` and 0 past the exit, m.
  bool holds(const NozzleState& nozzle, const Vec3& point, double margin, double from) const;

  /// Signed distance of a point from the edge of the nozzle's section, m, negative inside.
  double distance_to_edge(const NozzleState& nozzle, const Vec3& point) const;
  /// A box around all that `holds` with these arguments.
  Bounds bounds(const NozzleState& nozzle, double margin, double from) const;

  /// Speed that no point of the feed exceeds between two times, m/s.
  double speed_bound(double first, double last) const;

  static constexpr GlobalIndex ids_per_layer = GlobalIndex{1} << 16;
  static constexpr GlobalIndex ids_per_inflow = GlobalIndex{1} << 56;

 private:
  /// m, from the exit back to layer k at t = 0, at a stretch of 1.
  double depth(GlobalIndex k, const Point& point) const { return (static_cast<double>(k) - 0.5 + point.phase) * layer_; }
  double sum_over_nodes(const GridGeometry& grid, int axis) const;

  Inflow inflow_;
  EnteredVolume entered_;
  GlobalIndex first_id_;
  SectionFrame frame_;
  SpeedShares shares_;
  double node_factor_ = 1.0;  ///< of the shares of nodes, so that those of a plane sum up to the flow
  double radius_ = 0.0;       ///< m, of the circle about the section
  double length_, layer_, path_per_volume_, particle_volume_;
  std::vector<Point> points_;
  std::vector<LocalIndex> place_of_number_;
};

/// The feeds of a scene. `n_bodies`: whose ids come first. Throws UsageError, one sentence.
std::vector<Feed> feeds_of(const GridGeometry& grid, const std::vector<Inflow>& inflows, std::size_t n_bodies,
                           double end_time);

}  // namespace bulkley
