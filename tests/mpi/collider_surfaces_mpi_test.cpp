// ranks: 1 2 4
#include "io/frames/collider_surfaces.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "io/files/text_file.hpp"
#include "io/frames/frame.hpp"
#include "support/io_particles.hpp"

namespace bulkley::collider_surfaces_mpi_test {
namespace {

const Bounds window{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}};

Collider named(const std::string& name, const Shape& shape) {
  Collider collider;
  collider.name = name;
  collider.shape = shape;
  return collider;
}

std::vector<Collider> block_and_plate() {
  return {named("block", {Box{{0.1, 0.1, 0.1}, {0.3, 0.2, 0.2}}}), named("plate", {Box{{0.5, 0.5, 0.5}, {0.9, 0.6, 0.8}}})};
}

class ColliderFiles : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  SharedFolder folder{comm};

  void write_frames(FrameSeries& series, const ColliderSurfaces& surfaces, std::vector<GlobalIndex> indices) {
    for (const GlobalIndex index : indices) {
      const double time = 0.1 * static_cast<double>(index);
      write_frame(comm, folder.path(), {index, 100 * index, time, 0}, make_uneven_particles(comm, 40),
                  {{{"cream", HerschelBulkley{}}}}, OutputSettings{}, nullptr, nullptr, &surfaces);
      series.add(comm, index);
    }
  }
  std::string series_text() {
    std::string text;
    if (comm.is_root()) text = whole_file(folder.file("colliders.xdmf"));
    return broadcast_text(comm, text);
  }
};

TEST_F(ColliderFiles, FixedOnesAreWrittenOnce) {
  const ColliderSurfaces surfaces(block_and_plate(), {}, window);
  surfaces.write(comm, folder.path());
  const Hdf5Reader file(folder.file(collider_file));
  EXPECT_EQ(file.text("/colliders", "names"), "block\nplate");
  EXPECT_EQ(file.array("/colliders/vertices").shape, (Extents{16, 3}));
  EXPECT_EQ(file.array("/colliders/triangles").shape, (Extents{24, 3}));
  const auto owner = whole_array<std::int32_t>(file, "/colliders/collider");
  EXPECT_EQ(owner.front(), 0);
  EXPECT_EQ(owner.back(), 1);

  FrameSeries series(comm, folder.path(), -1);
  write_frames(series, surfaces, {0, 1, 2});
  const std::string text = series_text();
  EXPECT_EQ(count(text, "<Time "), 3) << text;
  EXPECT_EQ(count(text, "colliders.h5:/colliders/vertices"), 3);
  EXPECT_EQ(count(text, "frame_"), 0) << "nothing of fixed colliders is written again";
  const Hdf5Reader frame(frame_path(folder.path(), 2));
  EXPECT_FALSE(frame.has("/colliders/vertices"));
  const std::vector<double> identity{1, 0, 0, 0, 1, 0, 0, 0, 1};
  const auto rotation = whole_array<double>(frame, "/colliders/rotation");
  EXPECT_EQ(std::vector<double>(rotation.begin() + 9, rotation.end()), identity);
}

TEST_F(ColliderFiles, MovingOnesAreMovedInEveryFrame) {
  std::vector<Collider> colliders = block_and_plate();
  colliders[1].motion.velocity = Vec3(1.0, 0.0, 0.0);
  colliders[1].motion.angular_velocity = Vec3(0.0, 0.0, 5.0);
  colliders[1].motion.center = Vec3(0.7, 0.55, 0.6);
  const ColliderSurfaces surfaces(colliders, {}, window);
  surfaces.write(comm, folder.path());
  FrameSeries series(comm, folder.path(), -1);
  write_frames(series, surfaces, {0, 1, 2});
  EXPECT_EQ(count(series_text(), "frame_000002.h5:/colliders/vertices"), 1);
  EXPECT_EQ(count(series_text(), "colliders.h5:/colliders/triangles"), 3);

  const auto before = whole_array<float>(Hdf5Reader(folder.file(collider_file)), "/colliders/vertices");
  const Hdf5Reader frame(frame_path(folder.path(), 2));
  const auto after = whole_array<float>(frame, "/colliders/vertices");
  const auto rotation = whole_array<double>(frame, "/colliders/rotation");
  const auto translation = whole_array<double>(frame, "/colliders/translation");
  for (std::size_t v = 0; v < 16; ++v) {
    const std::size_t c = v / 8;
    for (std::size_t row = 0; row < 3; ++row) {
      double expected = translation[3 * c + row];
      for (std::size_t k = 0; k < 3; ++k) expected += rotation[9 * c + 3 * row + k] * before[3 * v + k];
      EXPECT_NEAR(after[3 * v + row], expected, 1e-6);
      if (c == 0) {
        EXPECT_EQ(after[3 * v + row], before[3 * v + row]);
      }
    }
  }
  // At t = 0.2 s the plate has gone 0.2 m and turned by 1 rad about its centre.
  EXPECT_NEAR(rotation[9], std::cos(1.0), 1e-12);
  EXPECT_NEAR(rotation[9] * 0.7 + rotation[10] * 0.55 + translation[3], 0.9, 1e-12);
}

TEST_F(ColliderFiles, SeriesFollowsRestarts) {
  const ColliderSurfaces surfaces(block_and_plate(), {}, window);
  surfaces.write(comm, folder.path());
  {
    FrameSeries series(comm, folder.path(), -1);
    write_frames(series, surfaces, {0, 1, 2, 3});
  }
  const FrameSeries again(comm, folder.path(), 150);  // restarted from step 150
  EXPECT_EQ(count(series_text(), "<Time "), 2);

  // Restarted with other colliders: earlier frames do not fit them.
  std::vector<Collider> others = block_and_plate();
  others[0].name = "brick";
  ColliderSurfaces(others, {}, window).write(comm, folder.path());
  const FrameSeries changed(comm, folder.path(), 150);
  EXPECT_FALSE(folder.has("colliders.xdmf"));
  EXPECT_TRUE(folder.has("frames.xdmf"));
  if (comm.is_root()) {
    EXPECT_EQ(changed.warnings().size(), 2u);
  }

  ColliderSurfaces().write(comm, folder.path());  // a run without any
  EXPECT_FALSE(folder.has(collider_file));
  const FrameSeries fresh(comm, folder.path(), -1);
  EXPECT_FALSE(folder.has("colliders.xdmf"));
}

}  // namespace
}  // namespace bulkley::collider_surfaces_mpi_test
