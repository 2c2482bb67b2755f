// Inflows: the volume that has entered, the lattice of a layer, births and releases, key frames.
#include "particle/inflow.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

#include "bulkley/base/error.hpp"
#include "particle/feed_frames.hpp"

namespace bulkley::inflow_test {
namespace {

GridGeometry grid() {
  GridGeometry g;
  g.cell_size = 0.01;
  g.n_cells = {20, 20, 20};
  return g;
}

Inflow jet() {
  Inflow inflow;
  inflow.section = DiscSection{0.03};
  inflow.position = Vec3(0.1, 0.1, 0.15);
  inflow.speed = TimeFormula{0.5, ""};
  inflow.density = 1000.0;
  return inflow;
}

TEST(EnteredVolume, OfANumberIsExact) {
  Inflow inflow = jet();
  inflow.start = 1.0;
  inflow.end = 3.0;
  const EnteredVolume volume(inflow, 10.0);
  const double rate = 0.5 * area(inflow.section);
  EXPECT_EQ(volume.volume(0.5), 0.0);
  EXPECT_DOUBLE_EQ(volume.volume(2.0), rate);
  EXPECT_DOUBLE_EQ(volume.volume(9.0), 2.0 * rate);
}

TEST(EnteredVolume, OfAFormulaIsItsIntegral) {
  Inflow inflow = jet();
  inflow.speed.reset();
  inflow.flow_rate = TimeFormula{0.0, "1e-3 * (1 + sin(20*t))"};
  const EnteredVolume volume(inflow, 2.0);
  for (const double t : {0.0, 0.00037, 0.5, 1.2345, 2.0})
    EXPECT_NEAR(volume.volume(t), 1e-3 * (t + (1.0 - std::cos(20.0 * t)) / 20.0), 1e-15);
  inflow.flow_rate = TimeFormula{0.0, "sin(20*t)"};
  EXPECT_THROW(EnteredVolume(inflow, 2.0), UsageError);
}

TEST(EnteredVolume, OfKeyFramesRestsInPauses) {
  Inflow inflow = jet();
  inflow.key_frames = {{0.0, {0, 0, 0}, 0.0}, {1.0, {1, 0, 0}, 0.3}, {2.0, {1, 1, 0}, 0.3}, {3.0, {1, 1, 1}, 1.0}};
  const EnteredVolume volume(inflow, 2.0);
  EXPECT_EQ(volume.volume(1.0), 0.3);
  for (double t = 1.0; t <= 2.0; t += 1.0 / 64) EXPECT_EQ(volume.volume(t), 0.3);
  EXPECT_EQ(volume.volume(3.0), 1.0);
  EXPECT_DOUBLE_EQ(volume.volume(2.25), 0.475);
  EXPECT_DOUBLE_EQ(volume.rate(2.25), 0.7);
  EXPECT_DOUBLE_EQ(volume.largest_rate(0.5, 2.5), 0.7);
  EXPECT_EQ(volume.largest_rate(1.25, 1.75), 0.0);
  EXPECT_EQ(volume.rate(1.5), 0.0);
}

TEST(Feed, HasLayersOfTheRightVolume) {
  const Feed feed(grid(), jet(), 0, 1.0);
  const double n = static_cast<double>(feed.points().size());
  EXPECT_DOUBLE_EQ(n * feed.particle_volume(), area(DiscSection{0.03}) * 0.005);
  for (const Feed::Point& point : feed.points()) EXPECT_LE(point.offset.norm(), 0.03);
  for (const double t : {0.0, 0.013, 0.1, 0.37}) {
    const auto n_released = static_cast<double>(feed.n_particles(feed.released(t)));
    EXPECT_LE(std::abs(n_released * feed.particle_volume() - feed.entered_volume(t)),
              0.5 * n * feed.particle_volume() * (1.0 + 1e-12));
    for (const Feed::Point& point : feed.points())  // three cells, two layers each
      EXPECT_EQ(feed.n_layers(feed.born(t), point) - feed.n_layers(feed.released(t), point), 6);
  }
}

TEST(Feed, PlacesLayersByTimeAlone) {
  const Feed feed(grid(), jet(), 7 * Feed::ids_per_inflow, 1.0);
  const GlobalIndex id = feed.id_of(3, feed.points().back());
  EXPECT_TRUE(feed.owns(id));
  EXPECT_EQ(feed.layer_of(id), 3);
  EXPECT_EQ(&feed.point_of(id), &feed.points().back());
  const NozzleState nozzle = feed.at(0.1);
  EXPECT_DOUBLE_EQ(feed.distance(nozzle, 3, feed.points().back()), 0.05 - 2.5 * 0.005);
  EXPECT_DOUBLE_EQ(feed.position(nozzle, 3, feed.points().back())[2], 0.15 - 0.0375);
  const Vec3 velocity = feed.velocity(nozzle, Vec3::Zero(), 1.0);
  EXPECT_EQ(velocity.head<2>().norm(), 0.0);
  EXPECT_DOUBLE_EQ(velocity[2], -0.5);  // the volume over the area: rounded twice
}

TEST(Feed, RefusesSectionsOfFewParticles) {
  Inflow inflow = jet();
  for (const Section& section : {Section(DiscSection{0.0099}), Section(RectangleSection{0.1, 0.0199})}) {
    inflow.section = section;
    EXPECT_THROW(Feed(grid(), inflow, 0, 1.0), UsageError);
  }
  inflow.section = RectangleSection{0.02, 0.04};
  EXPECT_EQ(Feed(grid(), inflow, 0, 1.0).points().size(), 32u);
}

Shape solid(auto kind) { return Shape{std::move(kind)}; }

TEST(Feed, HasOneLayerAcrossAPlaneFlow) {
  GridGeometry plane = grid();
  plane.n_cells[1] = 1;
  plane.periodic[1] = true;
  Inflow inflow = jet();
  for (const bool turned : {false, true}) {
    inflow.section = turned ? RectangleSection{0.06, 0.01} : RectangleSection{0.01, 0.06};
    inflow.side = turned ? Vec3::UnitX() : Vec3::UnitY();
    inflow.position = Vec3(0.1, 0.005, 0.15);
    EXPECT_DOUBLE_EQ(narrowest_side(plane, inflow), 0.06);
    const Feed feed(plane, inflow, 1000, 2.0);
    ASSERT_EQ(feed.points().size(), 12u);
    for (const Feed::Point& point : feed.points()) EXPECT_NEAR(point.offset[1], 0.0, 1e-17);
    EXPECT_NEAR(12.0 * feed.particle_volume(), 0.06 * 0.01 * 0.005, 1e-18);
    EXPECT_DOUBLE_EQ(narrowest_side(grid(), inflow), 0.01);
    EXPECT_THROW(Feed(grid(), inflow, 1000, 2.0), UsageError) << "in a slab it is two particles wide";
  }
}

TEST(Section, OfAShapeIsWhatItsPlaneCuts) {
  const ShapeSection cut{solid(Sphere{Vec3(0.01, 0.0, 0.03), 0.05})};  // a disc of 0.04 m
  EXPECT_NEAR(area(cut) / area(DiscSection{0.04}), 1.0, 2e-4);
  EXPECT_LT(signed_distance(cut, 0.0499, 0.0), 0.0);
  EXPECT_GT(signed_distance(cut, 0.0501, 0.0), 0.0);
  const ShapeSection ring{solid(Difference{
      {solid(Cylinder{Vec3(0, 0, -1), Vec3(0, 0, 1), 0.04}), solid(Cylinder{Vec3(0, 0, -2), Vec3(0, 0, 2), 0.02})}})};
  EXPECT_NEAR(area(ring) / (area(DiscSection{0.04}) - area(DiscSection{0.02})), 1.0, 2e-4);
  const Bounds box = bounds(Section(cut));
  EXPECT_NEAR((box.lower - Vec3(-0.04, -0.05, 0.0)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((box.upper - Vec3(0.06, 0.05, 0.0)).norm(), 0.0, 1e-15);
}

TEST(Feed, FillsTheSectionOfAShape) {
  Inflow inflow = jet();
  inflow.section = ShapeSection{solid(Difference{
      {solid(Box{Vec3(-0.02, -0.03, -1), Vec3(0.04, 0.03, 1)}), solid(Box{Vec3(0.0, -0.01, -2), Vec3(0.02, 0.01, 2)})}})};
  const Feed feed(grid(), inflow, 0, 1.0);
  EXPECT_EQ(feed.points().size(), 12u * 12u - 4u * 4u);
  EXPECT_NEAR(feed.particle_volume(), 0.005 * 0.005 * 0.005, 1e-4 * 1.25e-7);
  const NozzleState nozzle = feed.at(0.0);
  for (const Feed::Point& point : feed.points()) {
    EXPECT_LT(feed.distance_to_edge(nozzle, nozzle.position + point.offset), 0.0);
    EXPECT_EQ(&feed.point_of(feed.id_of(5, point)), &point);
    const Bounds box = feed.bounds(nozzle, 0.0, -feed.length());
    const Vec3 x = feed.position(nozzle, 4, point);
    EXPECT_TRUE((x.array() >= box.lower.array()).all() && (x.array() <= box.upper.array()).all());
  }
}

TEST(Feed, RefusesShapesWithoutASection) {
  Inflow inflow = jet();
  const Shape far = solid(Sphere{Vec3(0, 0, 0.06), 0.05}), endless = solid(Plane{Vec3::Zero(), Vec3::UnitX()});
  const Shape sheet = solid(Difference{
      {solid(Cylinder{Vec3(0, 0, -1), Vec3(0, 0, 1), 0.04}), solid(Cylinder{Vec3(0, 0, -2), Vec3(0, 0, 2), 0.0395})}});
  for (const Shape& shape : {far, endless, sheet}) {
    inflow.section = ShapeSection{shape};
    EXPECT_THROW(Feed(grid(), inflow, 0, 1.0), UsageError);
  }
}

TEST(Feed, IsStretchedAboutItsExit) {
  const Feed feed(grid(), jet(), 0, 1.0);
  const NozzleState plain = feed.at(0.1), stretched = feed.at(0.1, 0.9);
  const Feed::Point& point = feed.points().front();
  for (const GlobalIndex k : {1, 10, 13})
    EXPECT_DOUBLE_EQ(feed.distance(stretched, k, point), 0.9 * feed.distance(plain, k, point));
  EXPECT_DOUBLE_EQ(stretched.speed, 0.9 * plain.speed);
}

TEST(Feed, FollowsKeyFrames) {
  Inflow inflow = jet();
  inflow.position.reset();
  inflow.speed.reset();
  inflow.key_frames = {{0.0, {0.1, 0.1, 0.15}, 0.0}, {1.0, {0.12, 0.1, 0.15}, 1e-3}, {3.0, {0.12, 0.16, 0.15}, 1e-3}};
  const Feed feed(grid(), inflow, 0, 5.0);
  const NozzleState half = feed.at(0.5), later = feed.at(2.0), after = feed.at(4.0);
  EXPECT_NEAR((half.position - Vec3(0.11, 0.1, 0.15)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((half.velocity - Vec3(0.02, 0.0, 0.0)).norm(), 0.0, 1e-15);
  EXPECT_DOUBLE_EQ(half.path, 0.5e-3 / area(inflow.section));
  EXPECT_NEAR((later.velocity - Vec3(0.0, 0.03, 0.0)).norm(), 0.0, 1e-15);
  EXPECT_EQ(later.speed, 0.0);
  EXPECT_EQ(after.position, Vec3(0.12, 0.16, 0.15));
  EXPECT_DOUBLE_EQ(feed.speed_bound(1.5, 2.0), 0.03);
}

TEST(Feeds, NeedIdsForAll) {
  const std::vector<Inflow> many(127, jet());
  EXPECT_NO_THROW(feeds_of(grid(), many, 1, 1.0));
  EXPECT_THROW(feeds_of(grid(), std::vector<Inflow>(129, jet()), 1, 1.0), UsageError);
}

TEST(KeyFrames, AreReadAndChecked) {
  const auto frames = parse_key_frames("t,x,y,z,e\n# start\n0, 1, 2, 3, 0\n1.5,1,2,3,1e-6\n");
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].time, 1.5);
  EXPECT_EQ(frames[1].volume, 1e-6);
  EXPECT_EQ(frames[0].position, Vec3(1, 2, 3));
  EXPECT_TRUE(key_frames_fault(frames).empty());
  EXPECT_THROW(parse_key_frames("0,0,0,0,0\n1,2,3\n"), UsageError);
  EXPECT_FALSE(key_frames_fault({frames[1], frames[0]}).empty());
  EXPECT_FALSE(key_frames_fault({frames[0]}).empty());
  EXPECT_FALSE(key_frames_fault({{0, Vec3::Zero(), 0}, {1, Vec3::Zero(), 2}, {2, Vec3::Zero(), 1}}).empty());
}

}  // namespace
}  // namespace bulkley::inflow_test
