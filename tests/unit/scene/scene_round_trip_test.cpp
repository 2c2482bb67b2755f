// The effective input gives the scene again, the shipped scenes are sound, and the reference page is current.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>

#include "geometry/builtin_mesh.hpp"
#include "geometry/mesh_format.hpp"
#include "geometry/mesh_shape.hpp"
#include "material/preset.hpp"
#include "particle/feed_frames.hpp"
#include "scene/scene_difference.hpp"
#include "support/scene_text.hpp"

namespace bulkley::scene_test::scene_round_trip_test {
namespace {

const std::filesystem::path source_folder =
    std::filesystem::path(__FILE__).parent_path().parent_path().parent_path().parent_path();

std::string content(const std::filesystem::path& file) {
  std::ifstream stream(file);
  EXPECT_TRUE(stream) << file;
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

void expect_round_trip(const Scene& scene) {
  const Scene again = parse_scene(scene.effective_text, "effective.toml", {});
  EXPECT_EQ(again.effective_text, scene.effective_text);
  EXPECT_EQ(again.grid.lower, scene.grid.lower);
  EXPECT_EQ(again.grid.n_cells, scene.grid.n_cells);
  EXPECT_EQ(again.grid.periodic, scene.grid.periodic);
  ASSERT_EQ(again.bodies.size(), scene.bodies.size());
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    EXPECT_EQ(again.bodies[b].center, scene.bodies[b].center);
    EXPECT_EQ(again.bodies[b].density, scene.bodies[b].density);
    EXPECT_EQ(again.bodies[b].material_index, scene.bodies[b].material_index);
    EXPECT_EQ(again.bodies[b].seed, scene.bodies[b].seed);
  }
}

TEST(SceneRoundTrip, FlowsAreWrittenInTheConventionTheyWereReadIn) {
  for (const std::string law : {"herschel_bulkley", "thixotropic_herschel_bulkley"}) {
    const std::string kinetics = law == "herschel_bulkley" ? "" : "build_up = 0.1\nbreakdown = 0.2\n";
    const std::string start = "law = \"" + law + "\"\ndensity = 1000\nbulk_modulus = 1e5\nshear_modulus = 300\n" + kinetics;
    const std::string flow = "yield_stress = 18.3\nconsistency = 17.7\nflow_index = 0.37\n";
    const Scene rheometer = parsed(with(small_scene, "preset = \"cream\"\n", start + flow));
    expect_round_trip(rheometer);
    for (const std::string line : {"yield_stress = 18.3 ", "consistency = 17.7 ", "flow_index = 0.37\n"})
      EXPECT_NE(rheometer.effective_text.find("\n" + line), std::string::npos) << rheometer.effective_text;
    EXPECT_EQ(rheometer.effective_text.find("\nsigma_Y"), std::string::npos) << rheometer.effective_text;
    const Scene again = parse_scene(rheometer.effective_text, "effective.toml", {});
    const auto parameters = [](const Scene& scene) {
      return std::visit(
          [](const auto& l) -> HerschelBulkley::Parameters {
            if constexpr (requires { l.parameters.sigma_Y; })
              return l.parameters;
            else
              return {};
          },
          scene.materials[0].material);
    };
    EXPECT_EQ(parameters(again).sigma_Y, parameters(rheometer).sigma_Y);
    EXPECT_EQ(parameters(again).eta, parameters(rheometer).eta);
  }
}

// The same flow in the two conventions is the same scene, as in checkpoints of versions that wrote Yue's only.
TEST(SceneDifferences, FlowsAreComparedInOneConvention) {
  const std::string start = "law = \"herschel_bulkley\"\ndensity = 1000\nbulk_modulus = 1e5\nshear_modulus = 300\n";
  const std::string flow = "yield_stress = 18.3\nconsistency = 17.7\nflow_index = 0.37\n";
  const Scene rheometer = parsed(with(small_scene, "preset = \"cream\"\n", start + flow));
  Scene yue = rheometer;
  std::get<HerschelBulkley>(yue.materials[0].material).parameters.given = {};
  ASSERT_NE(effective_text(yue).find("\nsigma_Y"), std::string::npos);
  EXPECT_TRUE(scene_differences(effective_text(yue), rheometer).empty());
  const auto changed = [&](const std::string& text) {
    const std::vector<std::string> all = scene_differences(text, rheometer);
    return all.size() == 1 ? all[0] : "";
  };
  EXPECT_EQ(changed(with(rheometer.effective_text, "\nyield_stress = 18.3", "\nyield_stress = 20.0")),
            "materials.fluid.yield_stress: 20.0 -> 18.3");
  EXPECT_EQ(changed(with(effective_text(yue), "\nsigma_Y = 31.6", "\nsigma_Y = 41.6")).substr(0, 24),
            "materials.fluid.sigma_Y:");
}

// Checkpoints of versions without transfer.dilation, close_voids and thin_layers: only where a fluid would go on with others.
TEST(SceneDifferences, FluidsOfThenKeptTheVolumeOfParticlesLeftVoidsAndShearedInCells) {
  const auto changed = [](const std::string& text, const std::vector<std::string>& overrides, bool before_dilation = true) {
    const Scene scene = parsed(text, overrides);
    std::string then = scene.effective_text;
    const auto erase = [&](const std::string& key) {
      const std::size_t line = then.find("\n" + key + " = ");
      ASSERT_NE(line, std::string::npos);
      then.erase(line, then.find('\n', line + 1) - line);
    };
    erase("close_voids");
    erase("thin_layers");
    if (before_dilation) erase("dilation");
    return scene_differences(then, scene);
  };
  using Changes = std::vector<std::string>;
  const std::string voids = "transfer.close_voids: false -> true";
  const std::string solid = with(small_scene, "preset = \"cream\"\n",
                                 "law = \"neo_hookean\"\ndensity = 1000\nbulk_modulus = 1e5\nshear_modulus = 300\n");
  const std::string layers = "transfer.thin_layers: false -> true";
  const std::string syrup = with(small_scene, "preset = \"cream\"\n", "preset = \"cream\"\nyield_stress = 0.0\n");
  EXPECT_EQ(changed(small_scene, {}), (Changes{"transfer.dilation: \"particle\" -> \"auto\"", voids, layers}));
  EXPECT_EQ(changed(small_scene, {}, false), (Changes{voids, layers}));
  EXPECT_EQ(changed(small_scene, {"transfer.dilation=particle"}), Changes{layers});
  EXPECT_EQ(changed(small_scene, {"time.integrator=imex"}), (Changes{voids, layers}));
  EXPECT_TRUE(changed(small_scene, {"time.integrator=imex", "transfer.close_voids=false", "transfer.thin_layers=false"}).empty());
  EXPECT_EQ(changed(syrup, {}, false), Changes{voids}) << "no yield stress";
  EXPECT_TRUE(changed(solid, {}).empty());
}

TEST(SceneRoundTrip, OfASceneThatUsesEverything) {
  const std::string rest =
      "velocity = [0.1, -0.3, 1e-7]\nangular_velocity = [0, 0, 6.283185307179586]\nparticles_per_cell = 64\n"
      "lattice = \"jittered\"\nseed = 9223372036854775807\n"
      "[[bodies]]\nname = \"a \\\"b\\\" \\\\ c\"\nmaterial = \"my rubber\"\n"
      "shape = { type = \"union\", parts = [{ type = \"box\", lower = [0, 0, 0], upper = [0.1, 0.1, 0.1], rotation = { "
      "angle = 33.3, "
      "axis = [1, 1, 0], origin = [0.1, 0.2, 0.3] } }, { type = \"capsule\", start = [0, 0, 0], end = [0, 0, 0.1], radius = "
      "0.01, "
      "translation = [0, 0.1, 0] }], translation = [0.01, 0, 0] }\n"
      "[[bodies]]\nname = \"shell\"\nmaterial = \"my rubber\"\nshape = { type = \"difference\", parts = [{ type = "
      "\"ellipsoid\", center = [0.5, 0.5, 0.2], radii = [0.2, 0.1, 0.3] }, { type = \"sphere\", center = [0.5, 0.5, 0.2], "
      "radius = 0.05 }] }\n"
      "[materials.\"my rubber\"]\nlaw = \"neo_hookean\"\ndensity = 3\nyoungs_modulus = 1e5\npoisson_ratio = 0.3\n"
      "[materials.aaa]\npreset = \"pie\"\nconsistency = 7\n"
      "[[colliders]]\nname = \"floor\"\nshape = { type = \"plane\", point = [0, 0, 0.05], normal = [0, 0.1, 1] }\n"
      "contact = \"separating\"\nfriction = 0.3\n"
      "[[colliders]]\nname = \"pipe\"\nshape = { type = \"complement\", parts = [{ type = \"cylinder\", start = [0, 0, 0], "
      "end = [0, 0, 1], radius = 0.3 }] }\n"
      "[boundaries]\nx_lower = \"periodic\"\nx_upper = \"periodic\"\nz_lower = { type = \"separating\", friction = 0.1 }\n"
      "z_upper = { type = \"separating\" }\ny_upper = { type = \"sticky\", velocity = [0.1, 0, -0.2] }\n"
      "[transfer]\nscheme = \"blend\"\nflip_ratio = 0.9\norder = \"cubic\"\ngradient = \"bspline\"\n"
      "[output]\nfields = []\nprecision = \"float64\"\ngrid = true\ntiles = true\nframe_interval = 0.1\nprogress_interval = "
      "\"1m\"\n"
      "[checkpoint]\nsteps = 100\nwall_time = \"1h30m\"\nkeep = 3\nat_end = false\n[partition]\nmethod = \"uniform\"\n";
  const Scene scene =
      parsed(small_scene + rest, {"title=two words", "time.mode=fixed", "time.dt=0.0001", "allow_overlap=true"});
  expect_round_trip(scene);
  const Scene again = parse_scene(scene.effective_text, "effective.toml", {});
  EXPECT_EQ(again.bodies[1].name, "a \"b\" \\ c");
  EXPECT_EQ(std::get<Difference>(again.bodies[2].shape.kind).parts.size(), 2u);
  EXPECT_EQ(again.faces[4].friction, 0.1);
  EXPECT_EQ(again.faces[3].velocity, Vec3(0.1, 0.0, -0.2));
  EXPECT_GT(signed_distance(again.colliders[1].shape, Vec3(0.0, 0.0, 0.5)), 0.0);
  EXPECT_TRUE(again.output.fields.empty());
  EXPECT_TRUE(again.output.tiles);
  EXPECT_EQ(again.materials[1].name, "my rubber");
  EXPECT_EQ(again.time_stepping.dt_fixed, 0.0001);
}

TEST(SceneRoundTrip, KeepsAnglesBitForBit) {
  for (const double angle :
       {0.1, 1.0, 7.7, 29.999999999999996, 30.0, 33.3, 45.0, 90.0, 123.456789012345, -271.3, 359.9, 1e-9}) {
    const auto angle_of = [](const Scene& scene) { return std::get<Placed>(scene.bodies[0].shape.kind).angle; };
    std::ostringstream degrees;
    degrees.precision(17);
    degrees << angle;
    const Scene scene = parsed(with_shape(
        "{ type = \"sphere\", center = [0.5, 0.5, 0.25], radius = 0.2, rotation = { angle = " + degrees.str() + " } }"));
    EXPECT_EQ(angle_of(parse_scene(scene.effective_text, "effective.toml", {})), angle_of(scene)) << angle;
  }
}

TEST(SceneRoundTrip, StatesTheFlowInBothConventions) {
  const std::string text = parsed(small_scene).effective_text;
  EXPECT_NE(text.find("sigma_Y = 31.9  # Pa\n"), std::string::npos);
  EXPECT_NE(text.find("yield_stress = 18.4175 Pa, consistency = 17.8214 Pa s^n, flow_index = 0.22"), std::string::npos);
}

/// Shipped scenes use no other meshes than the program's own.
// Those of files are PLY.
void fill_meshes(Scene& scene) {
  const auto fill = [](const Mesh& mesh) {
    const bool is_file = !mesh.file.starts_with(builtin_prefix);
    return filled(mesh, is_file ? parse_mesh(content(mesh.file), MeshFormat::ply)
                                : builtin_mesh(mesh.file.substr(std::string(builtin_prefix).size())));
  };
  for (Body& body : scene.bodies) body.shape = with_meshes(body.shape, fill);
  for (Collider& collider : scene.colliders) collider.shape = with_meshes(collider.shape, fill);
}

void read_ways(Scene& scene) {
  for (Inflow& inflow : scene.inflows)
    if (!inflow.key_frames_file.empty()) inflow.key_frames = parse_key_frames(content(inflow.key_frames_file));
}

TEST(SceneRoundTrip, OfMeshes) {
  const std::string mesh =
      "[[bodies]]\nname = \"mesh\"\nmaterial = \"pie\"\nshape = { type = \"mesh\", file = \"../a/b.ply\", up = \"y\", size "
      "= 0.3, "
      "center = [0.1, 0.2, 0.3], rotation = { angle = 30 } }\n"
      "[[colliders]]\nname = \"hare\"\nshape = { type = \"mesh\", file = \"builtin:hare\", scale = 0.1 }\n";
  const std::string text = small_scene + mesh;
  const Scene scene =
      parse_scene(text, "/scenes/s.toml", {"bodies.mesh.material=" + parsed(small_scene).bodies[0].material});
  EXPECT_NE(scene.effective_text.find("file = \"/a/b.ply\""), std::string::npos) << scene.effective_text;
  EXPECT_NE(scene.effective_text.find("file = \"builtin:hare\""), std::string::npos);
  EXPECT_FALSE(scene.bodies.back().center.has_value());  // known once the mesh is read
  expect_round_trip(scene);
}

TEST(ShippedScenes, AreSound) {
  int n_scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder / "drivers" / "scenes")) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path().string());
    const std::string name = entry.path().filename().string();
    // Coarser cells say as much of a figure's bodies, and sooner.
    const std::vector<std::string> coarser = {"domain.cell_size=0.0125"};
    Scene scene = parse_scene(content(entry.path()), entry.path().string(),
                              name.starts_with("figure_") ? coarser : std::vector<std::string>{});
    fill_meshes(scene);
    expect_round_trip(scene);
    read_ways(scene);
    EXPECT_NO_THROW(check_bodies(scene));
    EXPECT_FALSE(scene.title.empty());
    EXPECT_GT(scene.output.frame_interval, 0.0);
    ++n_scenes;
  }
  EXPECT_GE(n_scenes, 3);
}

TEST(ShippedScenes, TakeTheOverridesTheyRecommend) {
  const auto scene = [](const char* name) { return content(source_folder / "drivers" / "scenes" / name); };
  EXPECT_NO_THROW(parse_scene(scene("figure_8_colliding_balls.toml"), "s", {"materials.fluid.preset=pie"}));
  EXPECT_NO_THROW(parse_scene(scene("figure_1_oobleck_bunny.toml"), "s", {"materials.fluid.preset=bouncing_oobleck"}));
  EXPECT_NO_THROW(parse_scene(scene("cream_splash.toml"), "s", {"materials.fluid.preset=pie"}));
  EXPECT_EQ(parse_scene(scene("figure_3_spinning_body.toml"), "s", {"transfer.scheme=pic"}).transfer.scheme,
            TransferScheme::pic);
}

TEST(ShippedScenes, OneCellSizeScalesEveryFigure) {
  int n_figures = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder / "drivers" / "scenes")) {
    if (!entry.path().filename().string().starts_with("figure_")) continue;
    SCOPED_TRACE(entry.path().string());
    for (const char* cell_size : {"0.025", "0.0125", "0.00125"})
      EXPECT_NO_THROW(parse_scene(content(entry.path()), "s", {std::string("domain.cell_size=") + cell_size}));
    ++n_figures;
  }
  EXPECT_EQ(n_figures, 8);
}

TEST(InputReference, IsCurrent) {
  EXPECT_TRUE(content(source_folder / "docs" / "input.md") == input_reference())
      << "docs/input.md is out of date: bulkley input-reference > docs/input.md";
}

TEST(PresetReference, IsCurrent) {
  EXPECT_TRUE(content(source_folder / "docs" / "materials" / "presets.md") == preset_reference())
      << "docs/materials/presets.md is out of date: bulkley presets --markdown > docs/materials/presets.md";
}

}  // namespace
}  // namespace bulkley::scene_test::scene_round_trip_test
