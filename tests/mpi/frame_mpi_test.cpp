// ranks: 1 3 8
#include "io/frames/frame.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>

#include "io/arrays/array_file.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "io/files/text_file.hpp"
#include "support/io_particles.hpp"

namespace bulkley::frame_mpi_test {
namespace {

const std::vector<NamedMaterial> materials{{"cream", HerschelBulkley{{1000.0, 3.0, 2.0, 1.0, 1.0, 0.5}}},
                                           {"pie", NeoHookean{{1000.0, 5.0, 7.0}}}};

class Frame : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  SharedFolder folder{comm};
  OutputSettings settings;

  std::string write(GlobalIndex index, GlobalIndex step, double time, GlobalIndex n, const GridNodes* nodes = nullptr,
                    const TileValues* tiles = nullptr) {
    write_frame(comm, folder.path(), {index, step, time, 0}, make_uneven_particles(comm, n), materials, settings, nodes,
                tiles);
    return frame_path(folder.path(), index);
  }
  // The root's copy of a text file, on every rank.
  std::string text_of(const std::string& name) {
    std::string text;
    if (comm.is_root()) text = whole_file(folder.file(name));
    return broadcast_text(comm, text);
  }
};

// Chunks of one array are of several ranks, and ranks have unequal numbers of particles, or none.
TEST_F(Frame, CompressedFramesHoldTheSameInLessSpace) {
  settings.fields = {"id", "velocity", "cauchy_stress"};
  for (const GlobalIndex n : {0, 3, 40000}) {
    settings.compression = 0;
    const std::string plain = write(0, 1, 0.0, n);
    settings.compression = 1;
    const std::string compressed = write(1, 1, 0.0, n);
    const Hdf5Reader a(plain), b(compressed);
    for (const char* array : {"/particles/position", "/particles/velocity", "/particles/cauchy_stress"})
      EXPECT_EQ(whole_array<float>(a, array), whole_array<float>(b, array)) << array << ", " << n;
    EXPECT_EQ(whole_array<GlobalIndex>(a, "/particles/id"), whole_array<GlobalIndex>(b, "/particles/id"));
    verify_arrays(comm, compressed, {"/particles/position", "/particles/id"});
    if (n == 40000) {
      EXPECT_LT(std::filesystem::file_size(compressed), std::filesystem::file_size(plain) * 9 / 10);
    }
    BULKLEY_MPI(MPI_Barrier(comm.get()));  // before the next round replaces what is still read
  }
}

TEST_F(Frame, HoldsWhatTheSettingsSay) {
  settings.fields = frame_field_names();
  std::erase_if(settings.fields, [](const std::string& name) {  // what these particles do not have
    return std::any_of(field_table.begin(), field_table.end(),
                       [&](const FieldInfo& field) { return field.optional && field.name == name; });
  });
  settings.precision = FloatPrecision::float64;
  const std::string path = write(3, 17, 0.25, 500);
  const Hdf5Reader file(path);
  EXPECT_EQ(file.integer("/", "step"), 17);
  EXPECT_EQ(file.real("/", "time"), 0.25);
  EXPECT_EQ(file.text("/", "materials"), "cream\npie");
  EXPECT_EQ(file.members("/particles").size(), settings.fields.size() + 2);  // position and connectivity

  const ParticleSet particles = make_particles(0, 500);
  const auto id = whole_array<GlobalIndex>(file, "/particles/id");
  const auto material = whole_array<std::uint8_t>(file, "/particles/material");
  const auto position = whole_array<double>(file, "/particles/position");
  const auto pressure = whole_array<double>(file, "/particles/pressure");
  const auto deviatoric = whole_array<double>(file, "/particles/deviatoric_stress");
  const auto density = whole_array<double>(file, "/particles/density");
  const auto cauchy = whole_array<double>(file, "/particles/cauchy_stress");
  const auto left = whole_array<double>(file, "/particles/left_cauchy_green");
  const auto connectivity = whole_array<std::int32_t>(file, "/particles/connectivity");
  EXPECT_EQ(file.array("/particles/cauchy_stress").shape, (Extents{500, 3, 3}));
  for (std::size_t p = 0; p < 500; ++p) {
    const auto local = static_cast<LocalIndex>(p);
    EXPECT_EQ(id[p], static_cast<GlobalIndex>(p));
    EXPECT_EQ(connectivity[p], local);
    EXPECT_EQ(material[p], p % 2);
    EXPECT_EQ(position[3 * p + 2], particles.real(Field::position, 2)[local]);
    // Written out in full, apart from the code's tensor functions.
    const double J = particles.real(Field::volume_ratio)[local];
    const double bulk_modulus = p % 2 == 0 ? 3.0 : 5.0, shear_modulus = p % 2 == 0 ? 2.0 : 7.0;
    const auto b = [&](int c) { return particles.real(Field::left_cauchy_green, c)[local]; };
    double tau[6];
    for (int c = 0; c < 6; ++c)
      tau[c] = c < 3 ? shear_modulus * (b(c) - (b(0) + b(1) + b(2)) / 3.0) + 0.5 * bulk_modulus * (J * J - 1.0)
                     : shear_modulus * b(c);
    const double mean = (tau[0] + tau[1] + tau[2]) / 3.0;
    const double norm =
        std::sqrt((tau[0] - mean) * (tau[0] - mean) + (tau[1] - mean) * (tau[1] - mean) + (tau[2] - mean) * (tau[2] - mean) +
                  2 * (tau[3] * tau[3] + tau[4] * tau[4] + tau[5] * tau[5]));
    EXPECT_NEAR(pressure[p], -mean / J, 1e-14);
    EXPECT_NEAR(deviatoric[p], norm / J, 1e-14);
    EXPECT_NEAR(density[p], (p % 2 == 0 ? 1.25 : 1.5) / J, 1e-14);
    const int full[9] = {0, 3, 5, 3, 1, 4, 5, 4, 2};  // xx yy zz xy yz xz in a row-major matrix
    for (std::size_t c = 0; c < 9; ++c) {
      EXPECT_NEAR(cauchy[9 * p + c], tau[full[c]] / J, 1e-14);
      EXPECT_EQ(left[9 * p + c], particles.real(Field::left_cauchy_green, full[c])[local]);
    }
  }
}

TEST_F(Frame, SaysWhichRankHoldsAParticle) {
  settings.fields = {"id", "rank"};
  const Hdf5Reader file(write(0, 0, 0.0, 500));
  const auto id = whole_array<GlobalIndex>(file, "/particles/id");
  const auto rank = whole_array<std::int32_t>(file, "/particles/rank");
  const ParticleSet mine = make_uneven_particles(comm, 500);
  std::vector<bool> is_mine(500, false);
  for (LocalIndex p = 0; p < mine.size(); ++p) is_mine[static_cast<std::size_t>(mine.id()[p])] = true;
  ASSERT_EQ(rank.size(), 500u);
  for (std::size_t p = 0; p < 500; ++p)
    EXPECT_EQ(rank[p] == comm.rank(), is_mine[static_cast<std::size_t>(id[p])]) << "particle " << id[p];
}

TEST_F(Frame, SinglePrecisionKeepsIdsWhole) {
  settings.fields = {"id", "velocity"};
  const GlobalIndex large = (GlobalIndex{1} << 40) + 1;  // neither a float nor 32 bits hold it
  write_frame(comm, folder.path(), {}, make_particles(large + 10 * comm.rank(), 10), materials, settings, nullptr, nullptr);
  const Hdf5Reader file(frame_path(folder.path(), 0));
  EXPECT_EQ(file.array("/particles/velocity").type, ArrayType::float32);
  EXPECT_EQ(whole_array<GlobalIndex>(file, "/particles/id").back(), large + 10 * comm.size() - 1);
  const ParticleSet first = make_particles(large, 1);
  EXPECT_EQ(whole_array<float>(file, "/particles/velocity")[1], static_cast<float>(first.real(Field::velocity, 1)[0]));
}

TEST_F(Frame, ChecksumsAreVerified) {
  const std::string path = write(0, 0, 0.0, 300);
  EXPECT_NE(describe_file(comm, path).find("frame 0 of step 0"), std::string::npos);
  root_guard(comm, [&] {
    std::string bytes = whole_file(path);
    const auto bits = static_cast<float>(make_particles(123, 1).real(Field::velocity, 0)[0]);
    const std::size_t at = bytes.find(std::string(reinterpret_cast<const char*>(&bits), sizeof bits));
    if (at == std::string::npos) throw RunError("the test's particle is not in the file");
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    replace_file(path, bytes);
  });
  EXPECT_NE(sentence_of<RunError>([&] { describe_file(comm, path); }).find("is damaged"), std::string::npos);
}

TEST_F(Frame, RefusesUnknownFields) {
  settings.fields = {"presure"};
  EXPECT_NE(sentence_of<UsageError>([&] { write(0, 0, 0.0, 5); }).find("there is no field 'presure'"), std::string::npos);
  EXPECT_FALSE(folder.has("frame_000000.h5"));
}

// Every node says where it is: mass density = index along the whole grid, velocity = its indices.
TEST_F(Frame, GridFileIsInZyxOrder) {
  GridGeometry geometry;
  geometry.lower = Vec3(1.0, 2.0, 3.0);
  geometry.cell_size = 0.5;
  geometry.n_cells = {8, 12, 4};
  geometry.periodic = {false, false, true};
  // Ranks along y, as a DMDA may cut it; the last takes the rest and may be empty.
  const int n_y = geometry.n_nodes(1), share = (n_y + comm.size() - 1) / comm.size();
  const int first = std::min(comm.rank() * share, n_y), last = std::min(first + share, n_y);
  GridNodes nodes{geometry, {0, first, 0}, {geometry.n_nodes(0), last - first, geometry.n_nodes(2)}, {}};
  std::vector<Node> values;
  for (int i = 0; i < nodes.count[0]; ++i)
    for (int j = first; j < last; ++j)
      for (int k = 0; k < nodes.count[2]; ++k)
        values.push_back({{1.0 * i, 1.0 * j, 1.0 * k, i == 0 ? 0.0 : 0.125 * (i + 100 * j + 10000 * k)}});
  nodes.nodes = values;
  settings.precision = FloatPrecision::float64;
  const Hdf5Reader file(write(0, 0, 0.0, 10, &nodes));
  describe_file(comm, frame_path(folder.path(), 0));  // throws if a checksum is wrong

  const auto density = whole_array<double>(file, "/grid/mass_density");
  const auto velocity = whole_array<double>(file, "/grid/velocity");
  EXPECT_EQ(file.array("/grid/mass_density").shape, (Extents{4, 16, 12}));
  EXPECT_EQ(file.reals("/grid", "origin"), (std::vector<double>{0.5, 1.5, 3.0}));  // one node below, but not along z
  std::size_t n = 0;
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 16; ++j)
      for (int i = 0; i < 12; ++i, ++n) {
        EXPECT_EQ(density[n], i == 0 ? 0.0 : i + 100 * j + 10000 * k);
        const bool empty = i == 0 || density[n] == 0.0;
        EXPECT_EQ(velocity[3 * n + 1], empty ? 0.0 : j);
        EXPECT_EQ(velocity[3 * n + 2], empty ? 0.0 : k);
      }
  FrameSeries series(comm, folder.path(), 0);
  const std::string text = text_of("grid.xdmf");
  EXPECT_NE(text.find("Dimensions=\"4 16 12\""), std::string::npos) << text;
  EXPECT_NE(text.find(">3 1.5 0.5<"), std::string::npos) << text;
}

/// Tiles of a grid of which particles of make_particles, all in [1, 2)^3, fill a part; z is periodic.
struct SampleTiles {
  SampleTiles(const Comm& comm, SplineOrder order, GlobalIndex n) {
    geometry.lower = Vec3(1.0, 0.75, 1.0);
    geometry.cell_size = 0.125;
    geometry.n_cells = {8, 12, 16};
    geometry.periodic = {false, false, true};
    geometry.order = order;
    particles.resize(static_cast<std::size_t>(geometry.n_tiles()), 0);
    const ParticleSet mine = make_uneven_particles(comm, n);
    for (LocalIndex p = 0; p < mine.size(); ++p)
      ++particles[static_cast<std::size_t>(geometry.tile_of(mine.vector(Field::position, p)))];
    MPI_Allreduce(MPI_IN_PLACE, particles.data(), static_cast<int>(particles.size()), MPI_INT64_T, MPI_SUM, comm.get());
    std::vector<std::int32_t> rank;
    for (TileIndex t = 0; t < geometry.n_tiles(); ++t) {
      rank.push_back(7 * t % 5);
      tile.push_back(t);
      load.push_back(0.1 * t);
    }
    owners = TileMap(5, std::move(rank));
  }
  TileValues values() const { return {geometry, owners, tile, particles, load}; }

  GridGeometry geometry;
  TileMap owners;
  std::vector<TileIndex> tile;
  std::vector<GlobalIndex> particles;
  std::vector<double> load;
};

TEST_F(Frame, TileFileIsInZyxOrder) {
  const SampleTiles tiles(comm, SplineOrder::quadratic, 500);
  const TileValues values = tiles.values();
  const Hdf5Reader file(write(0, 0, 0.0, 500, nullptr, &values));  // there are four z-planes: with 8 ranks some write none
  describe_file(comm, frame_path(folder.path(), 0));               // throws if a checksum is wrong
  const auto rank = whole_array<std::int32_t>(file, "/tiles/rank");
  const auto particles = whole_array<GlobalIndex>(file, "/tiles/particles");
  const auto load = whole_array<double>(file, "/tiles/load");
  for (const char* name : {"/tiles/rank", "/tiles/particles", "/tiles/load"})
    EXPECT_EQ(file.array(name).shape, (Extents{4, 4, 3})) << name;
  std::size_t n = 0;
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 3; ++i, ++n) {
        const int tile = (i * 4 + j) * 4 + k;
        EXPECT_EQ(rank[n], 7 * tile % 5);
        EXPECT_EQ(particles[n], tiles.particles[static_cast<std::size_t>(tile)]);
        EXPECT_EQ(load[n], 0.1 * tile);
      }
}

TEST_F(Frame, ItsSizeIsPredicted) {
  constexpr GlobalIndex n = 500;
  settings.fields = {"id", "velocity", "cauchy_stress"};
  const SampleTiles tiles(comm, SplineOrder::quadratic, n);
  const TileValues values = tiles.values();
  const GridGeometry& grid = tiles.geometry;
  // All nodes are the root's.
  const Int3 all{grid.n_nodes(0), grid.n_nodes(1), grid.n_nodes(2)};
  const int n_z = comm.is_root() ? all[2] : 0;
  const std::vector<Node> nodes(static_cast<std::size_t>(all[0] * all[1] * n_z));
  const GridNodes grid_nodes{grid, {0, 0, comm.is_root() ? 0 : all[2]}, {all[0], all[1], n_z}, nodes};
  for (const bool more : {false, true}) {
    settings.grid = settings.tiles = more;
    const Hdf5Reader file(write(more, 0, 0.0, n, more ? &grid_nodes : nullptr, more ? &values : nullptr));
    GlobalIndex bytes = 0;
    for (const std::string group : {"/particles", "/grid", "/tiles"})
      if (group == "/particles" || more)
        for (const std::string& name : file.members(group)) {
          const ArrayInfo array = file.array(group + "/" + name);
          bytes += n_elements(array.shape) * static_cast<GlobalIndex>(element_size(array.type));
        }
    EXPECT_EQ(frame_bytes(settings, {}, grid, n), bytes);
  }
}

// Particles counted in the boxes that a viewer draws are those of the tiles.
TEST_F(Frame, TilesAreDrawnWhereTheirParticlesLie) {
  settings.precision = FloatPrecision::float64;
  for (const SplineOrder order : {SplineOrder::quadratic, SplineOrder::cubic}) {
    const SampleTiles tiles(comm, order, 2000);
    const TileValues values = tiles.values();
    const Hdf5Reader file(write(0, 0, 0.0, 2000, nullptr, &values));
    const auto position = whole_array<double>(file, "/particles/position");
    const std::vector<double> origin = file.reals("/tiles", "origin");
    const double size = file.real("/tiles", "tile_size");
    std::vector<GlobalIndex> counted(tiles.particles.size(), 0);
    for (std::size_t p = 0; p < 2000; ++p) {
      int box[3];
      for (std::size_t a = 0; a < 3; ++a) box[a] = static_cast<int>(std::floor((position[3 * p + a] - origin[a]) / size));
      if (box[2] < 0) box[2] += 4;  // periodic
      ASSERT_TRUE(box[0] >= 0 && box[0] < 3 && box[1] >= 0 && box[1] < 4 && box[2] < 4);
      ++counted[static_cast<std::size_t>((box[2] * 4 + box[1]) * 3 + box[0])];
    }
    EXPECT_EQ(counted, whole_array<GlobalIndex>(file, "/tiles/particles"));
    EXPECT_GT(std::accumulate(counted.end() - 3 * 4, counted.end(), GlobalIndex{0}), 0)
        << "none below the first tile along z";
  }
}

TEST_F(Frame, SeriesOfTilesFollowsTheRun) {
  const SampleTiles tiles(comm, SplineOrder::quadratic, 500);
  const TileValues values = tiles.values();
  FrameSeries series(comm, folder.path(), -1);
  write(0, 0, 0.0, 500);
  series.add(comm, 0);
  EXPECT_FALSE(folder.has("tiles.xdmf"));
  for (const GlobalIndex index : {1, 2}) {
    write(index, 100 * index, 0.1 * static_cast<double>(index), 500, nullptr, &values);
    series.add(comm, index);
  }
  series.add(comm, 2);  // the same frame twice counts once
  std::string text = text_of("tiles.xdmf");
  EXPECT_EQ(count(text, "<Time "), 2) << text;
  EXPECT_EQ(count(text, "Dimensions=\"5 5 4\""), 2) << "nodes of the mesh; tiles are its cells";
  EXPECT_EQ(count(text, "Center=\"Cell\""), 6);
  EXPECT_EQ(count(text, "Center=\"Node\""), 0);
  EXPECT_NE(text.find(">1.0625 0.6875 0.9375<"), std::string::npos) << "half a cell above the face along z only";
  EXPECT_NE(text.find("frame_000001.h5:/tiles/rank"), std::string::npos);

  const FrameSeries again(comm, folder.path(), 150);  // restarted from step 150
  text = text_of("tiles.xdmf");
  EXPECT_EQ(count(text, "<Time "), 1);
  EXPECT_NE(text.find("frame_000001.h5:/tiles/rank"), std::string::npos);

  const FrameSeries fresh(comm, folder.path(), -1);
  EXPECT_FALSE(folder.has("tiles.xdmf"));
}

// Frames that are added one by one make the same files as frames that are found.
TEST_F(Frame, SeriesAreTheirMomentsInOrder) {
  const SampleTiles tiles(comm, SplineOrder::quadratic, 100);
  const TileValues values = tiles.values();
  FrameSeries series(comm, folder.path(), -1);
  std::string particles = xdmf_opening("particles"), boxes = xdmf_opening("tiles");
  for (const GlobalIndex index : {0, 1, 2, 3, 7, 8}) {
    write(index, 100 * index, 0.1 * static_cast<double>(index), index == 2 ? 0 : 100, nullptr,
          index % 2 ? &values : nullptr);
    series.add(comm, index);
    root_guard(comm, [&] {
      const Hdf5Reader frame(frame_path(folder.path(), index));
      if (index != 2) particles += xdmf_moment(xdmf_particles(frame));
      EXPECT_EQ(whole_file(folder.file("frames.xdmf")), particles + xdmf_closing());
      if (index == 0) return;
      if (index % 2) boxes += xdmf_moment(xdmf_tiles(frame));
      EXPECT_EQ(whole_file(folder.file("tiles.xdmf")), boxes + xdmf_closing());
    });
  }
  const std::string text = text_of("frames.xdmf");
  FrameSeries again(comm, folder.path(), 800);
  EXPECT_EQ(text_of("frames.xdmf"), text);
  EXPECT_FALSE(folder.has("frames.xdmf.next"));
  FrameSeries earlier(comm, folder.path(), 150);
  EXPECT_EQ(text_of("frames.xdmf"), text.substr(0, text.find("      <Grid", text.find("frame_000001"))) + xdmf_closing());
}

TEST_F(Frame, SeriesFollowsTheRun) {
  {
    FrameSeries series(comm, folder.path(), -1);
    EXPECT_FALSE(folder.has("frames.xdmf"));
    for (const GlobalIndex index : {0, 1, 2, 3}) {
      write(index, 100 * index, 0.1 * static_cast<double>(index), index == 2 ? 0 : 50);  // frame 2 is empty
      series.add(comm, index);
    }
  }
  std::string text = text_of("frames.xdmf");
  EXPECT_EQ(count(text, "<Time "), 3) << text;
  EXPECT_EQ(count(text, "frame_000002"), 0) << "an empty frame cannot be opened";
  EXPECT_NE(text.find("frame_000001.h5:/particles/position"), std::string::npos);
  EXPECT_EQ(text.find(folder.path()), std::string::npos) << "names are relative";
  EXPECT_EQ(text.find("\"UInt\""), std::string::npos);
  EXPECT_TRUE(folder.has("frame_000001.xdmf"));
  EXPECT_FALSE(folder.has("frame_000002.xdmf"));

  // Restarted from step 150: frames of steps 200 and 300 are to be made again.
  FrameSeries again(comm, folder.path(), 150);
  EXPECT_EQ(count(text_of("frames.xdmf"), "<Time "), 2);
  EXPECT_FALSE(folder.has("frame_000003.h5"));
  EXPECT_FALSE(folder.has("frame_000003.xdmf"));
  write(2, 200, 0.2, 50);
  again.add(comm, 2);
  again.add(comm, 2);  // the same frame twice counts once
  text = text_of("frames.xdmf");
  EXPECT_EQ(count(text, "<Time "), 3);
  EXPECT_LT(text.find("frame_000001"), text.find("frame_000002"));

  root_guard(comm, [&] { replace_file(frame_path(folder.path(), 1), "not a frame"); });
  const FrameSeries damaged(comm, folder.path(), 250);
  EXPECT_EQ(count(text_of("frames.xdmf"), "<Time "), 2);
  if (comm.is_root()) {
    EXPECT_EQ(damaged.warnings().size(), 1u);
  }

  const FrameSeries fresh(comm, folder.path(), -1);
  EXPECT_FALSE(folder.has("frame_000000.h5"));
  EXPECT_FALSE(folder.has("frames.xdmf"));
}

}  // namespace
}  // namespace bulkley::frame_mpi_test
