#include "particle/inflow.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

constexpr double longest_panel = 1e-3;  // s
constexpr double fewest_panels = 4096.0;
constexpr double most_panels = 1e7;

// Gauss-Legendre, four points of [-1, 1].
constexpr std::array<double, 4> gauss_points{-0.86113631159405257522, -0.33998104358485626480, 0.33998104358485626480,
                                             0.86113631159405257522};
constexpr std::array<double, 4> gauss_weights{0.34785484513745385737, 0.65214515486254614263, 0.65214515486254614263,
                                              0.34785484513745385737};

double component(const FeedFrame& frame, int c) { return c < 3 ? frame.position[c] : frame.volume; }

struct Value {
  double value, rate;
};

std::size_t frame_at(const std::vector<FeedFrame>& frames, double time) {
  const auto after =
      std::upper_bound(frames.begin(), frames.end(), time, [](double t, const FeedFrame& f) { return t < f.time; });
  return static_cast<std::size_t>(after - frames.begin()) - 1;
}

double secant(const std::vector<FeedFrame>& frames, std::size_t k, int c) {
  return (component(frames[k + 1], c) - component(frames[k], c)) / (frames[k + 1].time - frames[k].time);
}

/// Linear between key frames, at rest before and after: place and volume stay in step, and what rests keeps its bits.
Value value_at(const std::vector<FeedFrame>& frames, double time, int c) {
  if (time < frames.front().time) return {component(frames.front(), c), 0.0};
  if (time >= frames.back().time) return {component(frames.back(), c), 0.0};
  const std::size_t k = frame_at(frames, time);
  const double rate = secant(frames, k, c), a = component(frames[k], c), b = component(frames[k + 1], c);
  return {std::clamp(a + (time - frames[k].time) * rate, std::min(a, b), std::max(a, b)), rate};
}

/// Calls visit(k) for the segments that reach into [first, last].
template <class Visit>
void for_each_segment(const std::vector<FeedFrame>& frames, double first, double last, Visit visit) {
  for (std::size_t k = first <= frames.front().time ? 0 : frame_at(frames, first);
       k + 1 < frames.size() && frames[k].time <= last; ++k)
    visit(k);
}

// Each point of a lattice counts with the share of its square that a straight edge at its distance leaves inside.
double area_by_points(const Section& section) {
  constexpr int n = 256;  // a side
  const Bounds box = bounds(section);
  const Vec3 step = (box.upper - box.lower) / n;
  const double width = std::max(step[0], step[1]);
  double sum = 0.0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double d = signed_distance(section, box.lower[0] + (i + 0.5) * step[0], box.lower[1] + (j + 0.5) * step[1]);
      sum += std::clamp(0.5 - d / width, 0.0, 1.0);
    }
  return sum * step[0] * step[1];
}

// Precondition: a section by a shape has no profile.
SpeedShares shares_of(const Inflow& inflow) {
  if (inflow.profile == FeedProfile::plug) return {};
  if (const auto* disc = std::get_if<DiscSection>(&inflow.section)) return SpeedShares(*disc);
  return {std::get<RectangleSection>(inflow.section), inflow.open_ends};
}

// Neighbours far apart, and any number of columns evenly spread: multiples of the golden section, as fractions.
double phase_of(GlobalIndex number) {
  const double multiple = 0.61803398874989485 * static_cast<double>(number);
  return multiple - std::floor(multiple) - 0.5;
}

int lattice_width(int particles_per_cell) {
  int k = 1;
  while (k * k * k < particles_per_cell) ++k;
  return k;
}

}  // namespace

double area(const Section& section) {
  if (const auto* disc = std::get_if<DiscSection>(&section)) return std::numbers::pi * disc->radius * disc->radius;
  if (std::holds_alternative<ShapeSection>(section)) return area_by_points(section);
  const auto& rectangle = std::get<RectangleSection>(section);
  return rectangle.width * rectangle.height;
}

double signed_distance(const Section& section, double a, double b) {
  if (const auto* disc = std::get_if<DiscSection>(&section)) return std::hypot(a, b) - disc->radius;
  if (const auto* shape = std::get_if<ShapeSection>(&section)) return signed_distance(shape->shape, Vec3(a, b, 0.0));
  const auto& rectangle = std::get<RectangleSection>(section);
  const double x = std::abs(a) - 0.5 * rectangle.width, y = std::abs(b) - 0.5 * rectangle.height;
  return std::min(std::max(x, y), 0.0) + std::hypot(std::max(x, 0.0), std::max(y, 0.0));
}

Bounds bounds(const Section& section) {
  Vec3 half = Vec3::Zero();
  if (const auto* shape = std::get_if<ShapeSection>(&section)) {
    Bounds box = bounds(shape->shape);
    box.lower[2] = box.upper[2] = 0.0;
    return box;
  }
  if (const auto* disc = std::get_if<DiscSection>(&section))
    half.head<2>().setConstant(disc->radius);
  else
    half.head<2>() =
        0.5 * Eigen::Vector2d(std::get<RectangleSection>(section).width, std::get<RectangleSection>(section).height);
  return {-half, half};
}

SectionFrame section_frame(const Inflow& inflow) {
  SectionFrame frame;
  frame.axis = inflow.direction.normalized();
  Vec3 side = inflow.side;
  if (side.isZero(0.0)) side = std::abs(frame.axis[0]) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  frame.first = (side - side.dot(frame.axis) * frame.axis).normalized();
  frame.second = frame.axis.cross(frame.first);
  return frame;
}

std::array<bool, 2> sides_across(const GridGeometry& grid, const Inflow& inflow) {
  const Bounds box = bounds(inflow.section);
  const SectionFrame frame = section_frame(inflow);
  std::array<bool, 2> across{};
  for (int side = 0; side < 2; ++side)
    for (int axis = 0; axis < 3; ++axis)
      if (grid.is_plane(axis) && std::abs((side == 0 ? frame.first : frame.second)[axis]) > 1.0 - 1e-12)
        across[static_cast<std::size_t>(side)] = box.upper[side] - box.lower[side] > grid.cell_size * (1.0 - 1e-9);
  return across;
}

double narrowest_side(const GridGeometry& grid, const Inflow& inflow) {
  const Bounds box = bounds(inflow.section);
  const std::array<bool, 2> across = sides_across(grid, inflow);
  double narrowest = INFINITY;
  for (int side = 0; side < 2; ++side)
    if (!across[static_cast<std::size_t>(side)]) narrowest = std::min(narrowest, box.upper[side] - box.lower[side]);
  return narrowest;
}

EnteredVolume::EnteredVolume(const Inflow& inflow, double end_time)
    : start_(inflow.start), end_(inflow.end.value_or(std::numeric_limits<double>::infinity())), frames_(inflow.key_frames) {
  if (!frames_.empty()) {
    start_ = frames_.front().time;
    end_ = frames_.back().time;
    return;
  }
  const TimeFormula& rate = inflow.flow_rate ? *inflow.flow_rate : inflow.speed.value();
  if (!inflow.flow_rate) factor_ = area(inflow.section);
  constant_ = factor_ * rate.number;
  const double last = std::isfinite(end_) ? end_ : end_time;  // of the panels
  if (rate.text.empty() || !(last > start_)) return;
  formula_ = std::make_shared<Formula>(rate.text, std::vector<std::string>{"t"});
  const double n_panels = std::max(fewest_panels, std::ceil((last - start_) / longest_panel));
  if (n_panels > most_panels)
    throw UsageError(
        fmt::format("lasts {:g} s; a rate by formula may last {:g} s", last - start_, most_panels * longest_panel));
  panel_length_ = (last - start_) / n_panels;
  panel_volume_.push_back(0.0);
  for (std::size_t n = 0; n < static_cast<std::size_t>(n_panels); ++n) {
    const double begin = start_ + static_cast<double>(n) * panel_length_;
    double largest = 0.0;
    for (const double at : {begin, begin + 0.25 * panel_length_, begin + 0.5 * panel_length_, begin + 0.75 * panel_length_,
                            begin + panel_length_}) {
      const double value = factor_ * (*formula_)({at});
      if (!(value >= 0.0 && std::isfinite(value)))
        throw UsageError(fmt::format("has the rate {:g} at t = {:g} s; it must be a number >= 0", value / factor_, at));
      largest = std::max(largest, value);
    }
    panel_largest_.push_back(largest);
    panel_volume_.push_back(panel_volume_.back() + std::max(0.0, integral(begin, begin + panel_length_)));
  }
}

double EnteredVolume::integral(double from, double to) const {
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  double sum = 0.0;
  for (std::size_t g = 0; g < gauss_points.size(); ++g)
    sum += gauss_weights[g] * (factor_ * (*formula_)({middle + half * gauss_points[g]}));
  return half * sum;
}

std::size_t EnteredVolume::panel_of(double time) const {
  const double n = std::floor((time - start_) / panel_length_);
  return static_cast<std::size_t>(std::clamp(n, 0.0, static_cast<double>(panel_largest_.size() - 1)));
}

double EnteredVolume::volume(double time) const {
  if (!frames_.empty()) return value_at(frames_, time, 3).value;
  const double t = std::clamp(time, start_, end_);
  if (!formula_) return constant_ * (t - start_);
  const std::size_t n = panel_of(t);
  const double part = integral(start_ + static_cast<double>(n) * panel_length_, t);
  return std::clamp(panel_volume_[n] + part, panel_volume_[n], panel_volume_[n + 1]);
}

double EnteredVolume::rate(double time) const {
  if (time < start_ || time > end_) return 0.0;
  if (!frames_.empty()) return std::max(0.0, value_at(frames_, time, 3).rate);
  return formula_ ? factor_ * (*formula_)({time}) : constant_;
}

double EnteredVolume::largest_rate(double first, double last) const {
  if (last < start_ || first > end_) return 0.0;
  double largest = 0.0;
  if (!frames_.empty()) {
    for_each_segment(frames_, first, last, [&](std::size_t k) { largest = std::max(largest, secant(frames_, k, 3)); });
    return largest;
  }
  if (!formula_) return constant_;
  for (std::size_t n = panel_of(std::clamp(first, start_, end_)); n <= panel_of(std::clamp(last, start_, end_)); ++n)
    largest = std::max(largest, panel_largest_[n]);
  return largest;
}

Feed::Feed(const GridGeometry& grid, const Inflow& inflow, GlobalIndex first_id, double end_time)
    : inflow_(inflow), entered_(inflow, end_time), first_id_(first_id) {
  const double dx = grid.cell_size, spacing = dx / lattice_width(inflow.particles_per_cell);
  length_ = (grid.order == SplineOrder::quadratic ? 3.0 : 4.0) * dx;
  layer_ = spacing * inflow.volume_ratio;
  path_per_volume_ = inflow.volume_ratio / area(inflow.section);
  frame_ = section_frame(inflow);
  shares_ = shares_of(inflow);

  if (const auto* shape = std::get_if<ShapeSection>(&inflow.section))
    check_shape(shape->shape, "has a section whose shape is wrong");
  const Bounds box = bulkley::bounds(inflow.section);
  const Vec3 sides = box.upper - box.lower, middle = box.center();
  radius_ = std::holds_alternative<DiscSection>(inflow.section) ? 0.5 * sides[0]
                                                                : box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).norm();
  if (!sides.allFinite()) throw UsageError("has a section without end: its shape must have finite bounds");
  const double narrowest = narrowest_side(grid, inflow);
  if (narrowest < 4.0 * spacing * (1.0 - 1e-9))
    throw UsageError(fmt::format(
        "has a section {:g} m wide; it must be at least 4 particles wide, {:g} m: make it wider, the cells of {:g} m "
        "smaller, or particles_per_cell greater than {}",
        narrowest, 4.0 * spacing, dx, inflow.particles_per_cell));
  const std::array<bool, 2> across = sides_across(grid, inflow);
  const double apart[2] = {across[0] ? sides[0] : spacing, across[1] ? sides[1] : spacing};  // m, particles along either side
  const double rows = std::ceil(sides[0] / apart[0] - 1e-9), columns = std::ceil(sides[1] / apart[1] - 1e-9);
  if (rows * columns > static_cast<double>(ids_per_layer))
    throw UsageError(
        fmt::format("has a section of {:.0f} x {:.0f} particles; it may have {}", rows, columns, ids_per_layer));
  double speeds = 0.0;  // of all columns, over the mean
  place_of_number_.assign(static_cast<std::size_t>(rows * columns), -1);
  for (GlobalIndex number = 0; number < static_cast<GlobalIndex>(place_of_number_.size()); ++number) {
    const auto n_columns = static_cast<GlobalIndex>(columns);
    const double a = middle[0] + (static_cast<double>(number / n_columns) - 0.5 * (rows - 1.0)) * apart[0];
    const double b = middle[1] + (static_cast<double>(number % n_columns) - 0.5 * (columns - 1.0)) * apart[1];
    if (signed_distance(inflow.section, a, b) > 0.0) continue;
    place_of_number_[static_cast<std::size_t>(number)] = static_cast<LocalIndex>(points_.size());
    const SpeedShares::Share share = shares_.at(a, b);
    points_.push_back({a * frame_.first + b * frame_.second, number, share.value,
                       share.slope[0] * frame_.first + share.slope[1] * frame_.second, is_plug() ? 0.0 : phase_of(number)});
    speeds += share.value;
  }
  const double section_area = area(inflow.section), held = static_cast<double>(points_.size()) * apart[0] * apart[1];
  if (!(section_area > 0.0)) throw UsageError("has an empty section: its shape does not reach the plane z = 0");
  if (!(held > 0.5 * section_area && held < 2.0 * section_area))
    throw UsageError(
        fmt::format("has a section of {:.4g} m^2, of which its {} particles {:g} m apart fill {:.4g} m^2: too few to show "
                    "its shape; make it "
                    "larger, the cells of {:g} m smaller, or particles_per_cell greater than {}",
                    section_area, points_.size(), spacing, held, dx, inflow.particles_per_cell));
  particle_volume_ = section_area * spacing / speeds;
  if (is_plug() || !inflow.position || inflow.motion.moves()) return;
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(frame_.axis[axis]) > 1.0 - 1e-12) node_factor_ = section_area / (dx * dx * sum_over_nodes(grid, axis));
}

// Of the shares of the nodes in a plane across `axis`, along which the feed flows; those on an edge, which move where it has no wall,
// count half.
double Feed::sum_over_nodes(const GridGeometry& grid, int axis) const {
  const double dx = grid.cell_size;
  const Vec3 center = inflow_.position.value();
  Int3 first{}, last{};
  for (int a = 0; a < 3; ++a) {
    const double reach = a == axis ? 0.0 : radius_;
    first[a] = a == axis ? 0 : static_cast<int>(std::floor((center[a] - reach - grid.lower[a]) / dx));
    last[a] = a == axis ? 0 : static_cast<int>(std::ceil((center[a] + reach - grid.lower[a]) / dx));
  }
  double sum = 0.0;
  for (int i = first[0]; i <= last[0]; ++i)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int k = first[2]; k <= last[2]; ++k) {
        const Vec3 arm = grid.lower + dx * Vec3(i, j, k) - center;
        const double a = arm.dot(frame_.first), b = arm.dot(frame_.second);
        const double depth = -signed_distance(inflow_.section, a, b) / dx;
        if (depth > -1e-6) sum += (depth < 1e-6 ? 0.5 : 1.0) * shares_.at(a, b).value;
      }
  return sum;
}

Vec3 Feed::middle() const {
  if (signed_distance(inflow_.section, 0.0, 0.0) <= 0.0) return Vec3::Zero();
  const auto nearer = [](const Point& a, const Point& b) { return a.offset.squaredNorm() < b.offset.squaredNorm(); };
  return std::min_element(points_.begin(), points_.end(), nearer)->offset;
}

NozzleState Feed::at(double time, double stretch) const {
  NozzleState state{
      inflow_.position.value_or(Vec3::Zero()), Vec3::Zero(), Vec3::Zero(), Mat3::Identity(), frame_.axis, 0.0, 0.0, stretch};
  state.path = path_per_volume_ * entered_.volume(time);
  state.speed = stretch * (path_per_volume_ * entered_.rate(time));
  if (!inflow_.key_frames.empty()) {
    for (int a = 0; a < 3; ++a) {
      const Value value = value_at(inflow_.key_frames, time, a);
      state.position[a] = value.value;
      state.velocity[a] = value.rate;
    }
  } else if (inflow_.motion.moves()) {
    const Pose pose = inflow_.motion.pose(time);
    const RigidVelocity velocity = inflow_.motion.velocity_at(time);
    state.position = pose.to_world(*inflow_.position);
    state.velocity = velocity.at(state.position);
    state.spin = velocity.angular_velocity;
    state.rotation = pose.rotation;
    state.axis = pose.rotation * frame_.axis;
  }
  return state;
}

Feed::Front Feed::born(double time) const {
  Front front = released(time);
  if (runs(time)) front.ahead = length_;
  return front;
}

Feed::Front Feed::released(double time) const {
  return {time < start() ? 0.0 : path_per_volume_ * entered_.volume(time), 0.0};
}

// The last layer that is within: never fewer for a longer path, whatever rounding does.
GlobalIndex Feed::n_layers(const Front& front, const Point& point) const {
  auto k = static_cast<GlobalIndex>(
      std::max(0.0, std::floor((point.share * front.path + front.ahead) / layer_ + 0.5 - point.phase)));
  while (is_within(front, k + 1, point)) ++k;
  while (k > 0 && !is_within(front, k, point)) --k;
  return k;
}

GlobalIndex Feed::n_particles(const Front& front) const {
  GlobalIndex n = 0;
  for (const Point& point : points_) n += n_layers(front, point);
  return n;
}

const Feed::Point& Feed::point_of(GlobalIndex id) const {
  const auto number = static_cast<std::size_t>((id - first_id_) % ids_per_layer);
  return points_[static_cast<std::size_t>(place_of_number_[number])];
}

bool Feed::holds(const NozzleState& nozzle, const Vec3& point, double margin, double from) const {
  const Vec3 arm = point - nozzle.position;
  const double along = arm.dot(nozzle.axis);
  if (along > 0.0 || along <= from) return false;
  return distance_to_edge(nozzle, point) <= margin;
}

double Feed::distance_to_edge(const NozzleState& nozzle, const Vec3& point) const {
  const Vec3 local = nozzle.rotation.transpose() * (point - nozzle.position);
  return signed_distance(inflow_.section, local.dot(frame_.first), local.dot(frame_.second));
}

double Feed::share_at(const NozzleState& nozzle, const Vec3& node) const {
  if (is_plug()) return 1.0;
  const Vec3 local = nozzle.rotation.transpose() * (node - nozzle.position);
  return node_factor_ * shares_.at(local.dot(frame_.first), local.dot(frame_.second)).value;
}

Bounds Feed::bounds(const NozzleState& nozzle, double margin, double from) const {
  const Vec3 middle = nozzle.position + 0.5 * from * nozzle.axis, half = 0.5 * from * nozzle.axis;
  const Vec3 sides = half.cwiseAbs() + Vec3::Constant(1.000001 * (radius_ + std::sqrt(2.0) * margin));
  return {middle - sides, middle + sides};
}

double Feed::speed_bound(double first, double last) const {
  double fastest = 0.0;
  if (!inflow_.key_frames.empty())
    for_each_segment(inflow_.key_frames, first, last, [&](std::size_t k) {
      Vec3 largest;
      for (int a = 0; a < 3; ++a) largest[a] = secant(inflow_.key_frames, k, a);
      fastest = std::max(fastest, largest.norm());
    });
  else if (inflow_.motion.moves())
    fastest = inflow_.motion.speed_bound(first, last,
                                         (*inflow_.position - inflow_.motion.center).norm() + radius_ + 2.0 * length_);
  return fastest + std::max(1.0, node_factor_) * shares_.largest() * (path_per_volume_ * entered_.largest_rate(first, last));
}

std::vector<Feed> feeds_of(const GridGeometry& grid, const std::vector<Inflow>& inflows, std::size_t n_bodies,
                           double end_time) {
  constexpr GlobalIndex largest = std::numeric_limits<GlobalIndex>::max();
  const double n_cells = 1.0 * grid.n_cells[0] * grid.n_cells[1] * grid.n_cells[2];
  const double end_of_ids = 64.0 * n_cells * static_cast<double>(n_bodies) +
                            static_cast<double>(Feed::ids_per_inflow) * static_cast<double>(inflows.size());
  if (!inflows.empty() && end_of_ids >= static_cast<double>(largest))
    throw UsageError(fmt::format("{} inflows, {} bodies and {:g} cells need more particle ids than 2^63", inflows.size(),
                                 n_bodies, n_cells));
  const GlobalIndex base = static_cast<GlobalIndex>(64.0 * n_cells * static_cast<double>(n_bodies));
  std::vector<Feed> feeds;
  for (std::size_t i = 0; i < inflows.size(); ++i) try {
      feeds.emplace_back(grid, inflows[i], base + static_cast<GlobalIndex>(i) * Feed::ids_per_inflow, end_time);
    } catch (const UsageError& error) {
      throw UsageError(fmt::format("{}{}inflow '{}' {}", inflows[i].place, inflows[i].place.empty() ? "" : ": ",
                                   inflows[i].name, error.what()));
    }
  return feeds;
}

}  // namespace bulkley
