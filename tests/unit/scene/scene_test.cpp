// What a scene file says, and what the reader says of a faulty one.

#include "scene/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/scene_text.hpp"

namespace bulkley::scene_test::scene_test {
namespace {

TEST(Scene, TakesDefaultsFromTheStructs) {
  const Scene scene = parsed(small_scene);
  const Scene defaults;
  EXPECT_EQ(scene.gravity, Vec3(0.0, 0.0, -9.81));
  EXPECT_EQ(scene.time_stepping.elastic_cfl, defaults.time_stepping.elastic_cfl);
  EXPECT_EQ(scene.transfer.scheme, TransferScheme::moment_flip);
  EXPECT_EQ(scene.faces[4].kind, FaceKind::sticky);
  EXPECT_EQ(scene.output.fields, defaults.output.fields);
  EXPECT_FALSE(scene.output.tiles);
  EXPECT_FALSE(scene.allow_overlap);
}

TEST(Scene, MayAskWhichRankHoldsWhat) {
  const Scene scene = parsed(small_scene, {"output.tiles=true", "output.fields=[\"rank\"]"});
  EXPECT_TRUE(scene.output.tiles);
  EXPECT_EQ(scene.output.fields, std::vector<std::string>{"rank"});
}

TEST(Scene, FillsTheGrid) {
  const Scene scene =
      parsed(small_scene, {"transfer.order=cubic", "boundaries.y_lower=periodic", "boundaries.y_upper=periodic"});
  EXPECT_EQ(scene.grid.n_cells, (Int3{20, 20, 10}));
  EXPECT_EQ(scene.grid.cell_size, 0.05);
  EXPECT_EQ(scene.grid.order, SplineOrder::cubic);
  EXPECT_EQ(scene.grid.periodic, (std::array<bool, 3>{false, true, false}));
}

TEST(Scene, FillsBodies) {
  const std::string second =
      "[[bodies]]\nname = \"cube\"\nmaterial = \"rubber\"\nshape = { type = \"box\", lower = [0, 0, 0], upper = [0.1, 0.1, "
      "0.1] }\n"
      "velocity = [1, 2, 3]\nangular_velocity = [0, 0, 4]\ncenter = [0, 0, 0]\nparticles_per_cell = 27\nlattice = "
      "\"jittered\"\n"
      "seed = 11\n[materials.rubber]\nlaw = \"neo_hookean\"\ndensity = 900\nbulk_modulus = 1e5\nshear_modulus = 1e4\n";
  const Scene scene = parsed(small_scene + second);
  ASSERT_EQ(scene.bodies.size(), 2u);
  EXPECT_EQ(scene.bodies[0].material_index, 0);
  EXPECT_EQ(scene.bodies[0].density, 77.7);
  EXPECT_TRUE(scene.bodies[0].center.value().isApprox(Vec3(0.5, 0.5, 0.25)));  // of the bounds
  EXPECT_EQ(scene.bodies[0].particles_per_cell, 8);
  EXPECT_EQ(scene.bodies[1].material_index, 1);  // order of the file, not of the alphabet
  EXPECT_EQ(scene.bodies[1].density, 900.0);
  EXPECT_EQ(scene.bodies[1].center, Vec3(0.0, 0.0, 0.0));
  EXPECT_EQ(scene.bodies[1].velocity, Vec3(1.0, 2.0, 3.0));
  EXPECT_EQ(scene.bodies[1].angular_velocity, Vec3(0.0, 0.0, 4.0));
  EXPECT_EQ(scene.bodies[1].particles_per_cell, 27);
  EXPECT_EQ(scene.bodies[1].lattice, SeedingLattice::jittered);
  EXPECT_EQ(scene.bodies[1].seed, 11u);
  EXPECT_EQ(scene.body_places[1], "s.toml:13:1");
}

TEST(Scene, FillsFacesAndColliders) {
  const Scene scene =
      parsed(small_scene +
             "[boundaries]\nz_lower = { type = \"separating\", friction = 0.3 }\nx_upper = \"outflow\"\n"
             "[[colliders]]\nname = \"rod\"\nshape = { type = \"cylinder\", start = [0, 0, 0.1], end = [1, 0, 0.1], "
             "radius = 0.02 }\ncontact = \"separating\"\nfriction = 0.5\n");
  EXPECT_EQ(scene.faces[4].kind, FaceKind::separating);
  EXPECT_EQ(scene.faces[4].friction, 0.3);
  EXPECT_EQ(scene.faces[1].kind, FaceKind::outflow);
  ASSERT_EQ(scene.colliders.size(), 1u);
  EXPECT_EQ(scene.colliders[0].contact, Contact::separating);
  EXPECT_EQ(scene.colliders[0].friction, 0.5);
  EXPECT_EQ(std::get<Cylinder>(scene.colliders[0].shape.kind).end, Vec3(1.0, 0.0, 0.1));
}

TEST(Scene, PlacesShapes) {
  const Scene scene =
      parsed(with_shape("{ type = \"union\", parts = [{ type = \"sphere\", center = [0.5, 0.5, 0.25], radius = 0.1 }, { "
                        "type = \"capsule\", start = "
                        "[0.5, 0.5, 0.2], end = [0.5, 0.5, 0.3], radius = 0.05, rotation = { axis = [1, 0, 0], angle = 90, "
                        "origin = [0.5, 0.5, 0.25] } "
                        "}], translation = [0.1, 0, 0] }"));
  const auto& outer = std::get<Placed>(scene.bodies[0].shape.kind);
  EXPECT_EQ(outer.translation, Vec3(0.1, 0.0, 0.0));
  EXPECT_EQ(outer.angle, 0.0);
  const auto& inner = std::get<Placed>(std::get<Union>(outer.part->kind).parts[1].kind);
  EXPECT_DOUBLE_EQ(inner.angle, std::numbers::pi / 2.0);
  // The capsule lies along y now and has moved along x.
  EXPECT_LT(signed_distance(scene.bodies[0].shape, Vec3(0.6, 0.58, 0.25)), 0.0);
  EXPECT_GT(signed_distance(scene.bodies[0].shape, Vec3(0.6, 0.5, 0.36)), 0.0);
}

TEST(Scene, ReadsCheckpointTimes) {
  const Scene scene = parsed(small_scene, {"checkpoint.wall_time=1h30m", "checkpoint.steps=500"});
  EXPECT_EQ(scene.checkpoint.wall_interval, 5400.0);
  EXPECT_EQ(scene.checkpoint.step_interval, 500);
  EXPECT_EQ(parsed(small_scene, {"checkpoint.wall_time=90"}).checkpoint.wall_interval, 90.0);
}

// --- faults -----------------------------------------------------------------------------------------------------------

TEST(SceneFaults, UnknownKeysAndTables) {
  EXPECT_EQ(faults_of(with(small_scene, "end = 1", "end = 1\nclf = 0.4")),
            "s.toml:7:1: unknown key 'clf' in [time]; did you mean 'cfl'?");
  EXPECT_EQ(faults_of(small_scene + "[outptu]\n"),
            "s.toml:13:2: unknown table 'outptu' at the top level; did you mean 'output'?");
  EXPECT_EQ(
      faults_of(small_scene + "colour = 1\n"),
      "s.toml:13:1: unknown key 'colour' in [bodies.0]; known: 'name', 'material', 'shape', 'velocity', 'angular_velocity', "
      "'center', 'velocity_field', 'particles_per_cell', 'lattice', 'seed'");
}

TEST(SceneFaults, RepeatedKeys) {
  EXPECT_EQ(faults_of(with(small_scene, "end = 1", "end = 1\nend = 2")), "s.toml:7:7: key 'end' is given twice");
}

TEST(SceneFaults, MissingKeys) {
  EXPECT_EQ(faults_of(""),
            "s.toml:1:1: required table [domain] is missing\ns.toml:1:1: required table [time] is missing\n"
            "s.toml:1:1: required table [materials] is missing");
  EXPECT_EQ(faults_of(with(small_scene, "cell_size = 0.05\n", "")),
            "s.toml:1:1: required key 'cell_size' is missing in [domain]");
  EXPECT_EQ(faults_of(with(small_scene, "end = 1", "end = 1\nmode = \"fixed\"")),
            "s.toml:5:1: required key 'dt' is missing in [time]");
}

TEST(SceneFaults, OverridesNameThemselves) {
  EXPECT_EQ(faults_of(small_scene, {"time.ned=1"}), "--set time.ned=1: unknown key 'ned' in [time]; did you mean 'end'?");
  EXPECT_EQ(faults_of(small_scene, {"tiem.end=1"}),
            "--set tiem.end=1: unknown table 'tiem' at the top level; did you mean 'time'?");
  EXPECT_EQ(faults_of(small_scene, {"time.cfl=0.6"}),
            "--set time.cfl=0.6: 'time.cfl' is 0.6; it must be greater than 0 and at most 0.5");
  EXPECT_EQ(faults_of(small_scene, {"bodies.bal.velocity=[0,0,1]"}),
            "--set bodies.bal.velocity=[0,0,1]: 'bodies' has no entry 'bal'; it has 1 entry ('ball')");
}

TEST(SceneFaults, GridsThatDoNotFit) {
  EXPECT_EQ(faults_of(small_scene, {"domain.upper=[1.03,1,0.5]"}),
            "--set domain.upper=[1.03,1,0.5]: the domain is 20.6 cells of 0.05 m long along x; it must be a whole number of "
            "cells: "
            "'domain.upper' = 1.05 (21 cells) along x would fit");
  EXPECT_EQ(faults_of(small_scene, {"domain.upper=[1,1,0.1]"}),
            "--set domain.upper=[1,1,0.1]: the domain is 2 cells of 0.05 m long along z; it must be at least 4 cells: "
            "'domain.upper' = 0.2 (4 cells) along z would fit");
  EXPECT_EQ(
      faults_of(small_scene, {"boundaries.z_lower=periodic", "boundaries.z_upper=periodic"}),
      "s.toml:3:9: the domain is 10 cells of 0.05 m long along z; it must be a multiple of 4 cells because the axis is "
      "periodic, or one cell for a plane flow: 'domain.upper' = 0.6 (12 cells) along z would fit");
  EXPECT_EQ(faults_of(small_scene, {"domain.upper=[1,1,0.05]"}),
            "--set domain.upper=[1,1,0.05]: the domain is 1 cells of 0.05 m long along z; it must be at least 4 cells, or have "
            "periodic faces for a plane flow: 'domain.upper' = 0.2 (4 cells) along z would fit");
  EXPECT_EQ(faults_of(small_scene, {"domain.upper=[1,1,0.1]", "boundaries.z_lower=periodic", "boundaries.z_upper=periodic"}),
            "--set domain.upper=[1,1,0.1]: the domain is 2 cells of 0.05 m long along z; it must be a multiple of 4 cells because the "
            "axis is periodic, or one cell for a plane flow: 'domain.upper' = 0.2 (4 cells) along z would fit");
  EXPECT_EQ(faults_of(small_scene, {"domain.upper=[1,0,1]"}),
            "--set domain.upper=[1,0,1]: 'domain.upper' = 0 along y; it must be greater than 'lower' = 0");
  EXPECT_EQ(
      faults_of(small_scene, {"domain.cell_size=1e-9"}).substr(0, 130),
      std::string("--set domain.cell_size=1e-9: 'domain.cell_size' = 1e-09 gives 1e+09 cells along x; it must give at most "
                  "1048576\n--set domain.cell_size=1e-9")
          .substr(0, 130));
  EXPECT_EQ(
      faults_of(small_scene, {"domain.cell_size=1e-6", "domain.upper=[1,1,1]"}),
      "--set domain.cell_size=1e-6: 'domain.cell_size' = 1e-06 gives 1000000 x 1000000 x 1000000 cells; the grid must have "
      "fewer than 2^31 tiles of 4 x 4 x 4");
}

TEST(SceneFaults, DecimalSizesAreWholeCells) {  // 0.9 / 0.00625 is not exactly 144
  EXPECT_EQ(faults_of(small_scene, {"domain.upper=[0.9,0.9,0.375]", "domain.cell_size=0.00625"}), "");
  EXPECT_EQ(faults_of(small_scene, {"domain.lower=[-0.3,0,0]", "domain.cell_size=0.1"}), "");
}

TEST(SceneFaults, PeriodicAtOneEnd) {
  EXPECT_EQ(faults_of(small_scene, {"boundaries.x_upper=periodic"}),
            "--set boundaries.x_upper=periodic: 'boundaries.x_upper' is periodic but 'x_lower' is not; an axis is periodic "
            "at both "
            "ends or at none");
}

TEST(SceneFaults, FrictionBelongsToSeparatingContact) {
  EXPECT_EQ(faults_of(small_scene + "[boundaries]\nz_lower = { type = \"slip\", friction = 0.3 }"),
            "s.toml:14:28: 'boundaries.z_lower.friction' is given but applies only with type = \"separating\"");
  EXPECT_EQ(faults_of(small_scene + "[boundaries]\nz_lower = { type = \"slip\", velocity = [1, 0, 0] }"),
            "s.toml:14:28: 'boundaries.z_lower.velocity' is given but applies only with type = \"sticky\"");
  EXPECT_EQ(faults_of(small_scene + "[boundaries]\nz_lower = { type = \"sticky\", velocity = [1, 0, 2] }"),
            "s.toml:14:11: 'boundaries.z_lower.velocity' has a component along z; a face moves only in its own plane");
  EXPECT_EQ(
      faults_of(small_scene + "[[colliders]]\nname = \"c\"\nfriction = 1\nshape = { type = \"plane\", point = [0, 0, 0], "
                              "normal = [0, 0, 1] }"),
      "s.toml:15:1: 'colliders.0.friction' is given but applies only with contact = \"separating\"");
}

TEST(SceneFaults, Bodies) {
  EXPECT_EQ(faults_of(with(small_scene, "material = \"fluid\"", "material = \"fluit\"")),
            "s.toml:11:12: body 'ball' is made of 'fluit', which is not in [materials]; did you mean 'fluid'?");
  EXPECT_EQ(faults_of(small_scene + "particles_per_cell = 9"),
            "s.toml:13:22: 'bodies.0.particles_per_cell' is 9; it must be one of "
            "1, 8, 27, 64");
  EXPECT_EQ(faults_of(small_scene + "seed = 3"),
            "s.toml:13:1: 'bodies.0.seed' is given but applies only with lattice = \"jittered\"");
  EXPECT_EQ(faults_of(small_scene + "lattice = \"jittered\"\nseed = -1"),
            "s.toml:14:8: 'bodies.0.seed' is -1; it must be at least 0");
  EXPECT_EQ(faults_of(small_scene + small_scene.substr(small_scene.find("[[bodies]]"))),
            "s.toml:14:8: 'bodies.1.name' is \"ball\", which another entry of [bodies] has already");
  EXPECT_EQ(faults_of(small_scene, {"bodies=[]"}),
            "--set bodies=[]: 'bodies' is empty; a scene needs at least one body or inflow");
}

TEST(SceneFaults, Shapes) {
  EXPECT_EQ(faults_of(with_shape("{ type = \"ball\" }")),
            "s.toml:12:18: 'bodies.0.shape.type' is \"ball\"; it must be one of \"box\", \"sphere\", \"cylinder\", "
            "\"capsule\", \"ellipsoid\", "
            "\"plane\", \"mesh\", \"union\", \"difference\", \"complement\"");
  EXPECT_EQ(faults_of(with_shape("{ radius = 1 }")), "s.toml:12:9: required key 'type' is missing in [bodies.0.shape]");
  EXPECT_EQ(faults_of(with_shape("{ type = \"sphere\", center = [0, 0, 0], radius = 0 }")),
            "s.toml:12:57: 'bodies.0.shape.radius' is 0; it must be greater than 0");
  EXPECT_EQ(faults_of(with_shape("{ type = \"box\", lower = [0, 1, 0], upper = [1, 1, 1] }")),
            "s.toml:12:52: 'bodies.0.shape.upper' must be greater than 'lower' along every axis; it is not along y");
  EXPECT_EQ(faults_of(with_shape("{ type = \"cylinder\", start = [0, 0, 0], end = [0, 0, 0], radius = 1 }")),
            "s.toml:12:9: 'bodies.0.shape' has 'start' equal to 'end'; they must differ");
  EXPECT_EQ(faults_of(with_shape("{ type = \"union\", parts = [] }")),
            "s.toml:12:35: 'bodies.0.shape.parts' is empty; it must hold at least one shape");
  EXPECT_EQ(faults_of(with_shape("{ type = \"union\", parts = [{ type = \"sphere\", radius = 1 }] }")),
            "s.toml:12:36: required key 'center' is missing in [bodies.0.shape.parts.0]");
  EXPECT_EQ(faults_of(with_shape(
                "{ type = \"sphere\", center = [0, 0, 0], radius = 1, rotation = { axis = [0, 0, 0], angle = 1 } }")),
            "s.toml:12:80: 'bodies.0.shape.rotation.axis' has no length; it must not be [0, 0, 0]");
  EXPECT_EQ(
      faults_of(with_shape("{ type = \"union\", parts = [{ type = \"plane\", point = [0, 0, 0], normal = [0, 0, 1] }] }")),
      "s.toml:12:9: 'bodies.0.shape' of body 'ball' contains a plane or complement, which is for colliders only");
}

TEST(SceneFaults, OutputFields) {
  EXPECT_EQ(faults_of(small_scene, {"output.fields=[\"velocity\",\"velocity\"]"}),
            "--set output.fields=[\"velocity\",\"velocity\"]: 'output.fields' names \"velocity\" twice");
  EXPECT_NE(faults_of(small_scene, {"output.fields=[\"presure\"]"}).find("did you mean \"pressure\"?"), std::string::npos);
}

TEST(SceneFaults, TimeStepsThatContradict) {
  EXPECT_EQ(faults_of(small_scene, {"time.dt=1e-4"}),
            "--set time.dt=1e-4: 'time.dt' is given but applies only with mode = \"fixed\"");
  EXPECT_EQ(faults_of(small_scene, {"time.dt_max=1e-4", "time.dt_initial=1e-3"}),
            "--set time.dt_initial=1e-3: 'time.dt_initial' is 0.001; it must be at most 'time.dt_max' = 0.0001");
  EXPECT_EQ(faults_of(small_scene, {"time.dt_max=1e-4", "time.dt_min=1e-3"}),
            "--set time.dt_min=1e-3: 'time.dt_min' is 0.001; it must be at most 'time.dt_max' = 0.0001");
}

}  // namespace
}  // namespace bulkley::scene_test::scene_test
