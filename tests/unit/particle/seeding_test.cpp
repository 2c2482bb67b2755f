#include "particle/seeding.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>

#include "bulkley/base/error.hpp"

namespace bulkley::seeding_test {
namespace {

constexpr double pi = 3.14159265358979323846;

GridGeometry unit_grid(int n, SplineOrder order = SplineOrder::quadratic) {
  GridGeometry grid;
  grid.lower = Vec3(-0.5, 0.1, 0.3);
  grid.cell_size = 1.0 / n;
  grid.n_cells = {n, n, n};
  grid.order = order;
  return grid;
}

Body body_of(const Shape& shape, int particles_per_cell = 8) {
  Body body;
  body.name = "a";
  body.shape = shape;
  body.density = 1200.0;
  body.particles_per_cell = particles_per_cell;
  return body;
}

std::vector<TileIndex> all_tiles(const GridGeometry& grid) {
  std::vector<TileIndex> tiles(static_cast<std::size_t>(grid.n_tiles()));
  std::iota(tiles.begin(), tiles.end(), 0);
  return tiles;
}

ParticleSet seeded(const GridGeometry& grid, const std::vector<Body>& bodies) {
  std::vector<double> densities(256, 0.0);
  for (const Body& body : bodies) densities[body.material_index] = body.density;
  ParticleSet particles(OptionalFields{}, Densities(densities));
  seed_particles(grid, bodies, all_tiles(grid), particles);
  return particles;
}

double total_volume(const ParticleSet& set) {
  return std::accumulate(set.real(Field::reference_volume), set.real(Field::reference_volume) + set.size(), 0.0);
}

/// All bytes of each particle, by id.
std::map<GlobalIndex, std::string> particles_by_id(const ParticleSet& set) {
  std::map<GlobalIndex, std::string> result;
  for (LocalIndex p = 0; p < set.size(); ++p) {
    std::string bytes;
    for (std::size_t c = 0; c < set.columns().size(); ++c) {
      const std::size_t width = set.columns()[c].element_size;
      bytes.append(reinterpret_cast<const char*>(set.data(c)) + static_cast<std::size_t>(p) * width, width);
    }
    result[set.id()[p]] = bytes;
  }
  return result;
}

// In general position: ends along a plane of the lattice would bias the count of its points.
const Vec3 start(-0.2, 0.4, 0.6), end(0.213, 0.687, 1.041);
const Shape slanted_cylinder{Cylinder{start, end, 0.22}};

// --- how much --------------------------------------------------------------------------------------------------------

TEST(Seeding, AnAlignedBoxIsFilledExactly) {
  for (const int per_cell : {1, 8, 27, 64}) {
    const GridGeometry grid = unit_grid(10);
    const ParticleSet set = seeded(grid, {body_of({Box{{-0.3, 0.4, 0.5}, {0.1, 0.7, 1.1}}}, per_cell)});
    EXPECT_EQ(set.size(), 4 * 3 * 6 * per_cell);
    EXPECT_NEAR(total_volume(set), 0.4 * 0.3 * 0.6, 1e-13);
    double mass = 0.0;
    for (LocalIndex p = 0; p < set.size(); ++p) mass += set.mass(p);
    EXPECT_NEAR(mass, 1200.0 * 0.4 * 0.3 * 0.6, 1e-10);
  }
}

TEST(Seeding, RoundBodiesHaveTheirVolume) {
  const double length = (end - start).norm(), r = 0.22;
  const double cylinder = pi * r * r * length, ball = 4.0 / 3.0 * pi;
  const struct {
    Shape shape;
    double volume;
  } cases[] = {{{Sphere{{0.0, 0.6, 0.8}, 0.4}}, ball * 0.064},
               {slanted_cylinder, cylinder},
               {{Capsule{start, end, r}}, cylinder + ball * r * r * r}};
  for (const auto& [shape, volume] : cases)
    for (const auto lattice : {SeedingLattice::regular, SeedingLattice::jittered}) {
      Body body = body_of(shape);
      body.lattice = lattice;
      EXPECT_NEAR(total_volume(seeded(unit_grid(40), {body})), volume, 2e-3 * volume) << shape.kind.index();
    }
}

TEST(Seeding, FillsTheDomainAndNothingOutsideIt) {
  for (const auto order : {SplineOrder::quadratic, SplineOrder::cubic})
    for (const bool periodic : {false, true})
      for (const int n : {4, 8, 12}) {
        GridGeometry grid = unit_grid(n, order);
        grid.periodic = {periodic, periodic, false};
        Body body = body_of({Box{Vec3::Constant(-9.0), Vec3::Constant(9.0)}}, 27);
        body.lattice = SeedingLattice::jittered;
        const ParticleSet set = seeded(grid, {body});
        EXPECT_EQ(set.size(), 27 * n * n * n);
        EXPECT_EQ(particles_by_id(set).size(), static_cast<std::size_t>(set.size()));  // no id twice
        for (LocalIndex p = 0; p < set.size(); ++p) {
          const Vec3 x = set.vector(Field::position, p);
          EXPECT_TRUE((x.array() > grid.lower.array()).all() && (x.array() < grid.upper().array()).all());
        }
      }
}

// --- where -----------------------------------------------------------------------------------------------------------

TEST(Seeding, RegularParticlesStandOnTheLattice) {
  const GridGeometry grid = unit_grid(8);
  const ParticleSet set = seeded(grid, {body_of(slanted_cylinder, 27)});
  ASSERT_GT(set.size(), 100);
  for (LocalIndex p = 0; p < set.size(); ++p) {
    const Vec3 x = set.vector(Field::position, p);
    EXPECT_LE(signed_distance(slanted_cylinder, x), 0.0);
    for (int a = 0; a < 3; ++a) {
      const double place = (x[a] - grid.lower[a]) * 24.0 - 0.5;  // three places in each of eight cells
      EXPECT_NEAR(place, std::round(place), 1e-11);
    }
  }
}

TEST(Seeding, APlaneFlowHasOneLayer) {
  for (std::size_t across = 0; across < 3; ++across) {
    GridGeometry grid = unit_grid(8);
    grid.n_cells[across] = 1;
    grid.periodic[across] = true;
    Body body = body_of({Box{grid.lower, grid.upper()}}, 27);
    EXPECT_EQ(particles_in_cell(grid, body), 9);
    for (const SeedingLattice lattice : {SeedingLattice::regular, SeedingLattice::jittered}) {
      body.lattice = lattice;
      const ParticleSet set = seeded(grid, {body});
      EXPECT_EQ(set.size(), 64 * 9);
      EXPECT_EQ(static_cast<LocalIndex>(particles_by_id(set).size()), set.size()) << "every id once";
      EXPECT_NEAR(total_volume(set), 0.125, 1e-14);
      const double middle = grid.lower[static_cast<int>(across)] + 0.5 * grid.cell_size;
      for (LocalIndex p = 0; p < set.size(); ++p)
        EXPECT_EQ(set.vector(Field::position, p)[static_cast<int>(across)], middle);
    }
  }
}

TEST(Seeding, IdsNameBodyCellAndPlace) {
  const GridGeometry grid = unit_grid(8);
  const ParticleSet set =
      seeded(grid, {body_of({Sphere{{-0.3, 0.3, 0.5}, 0.15}}), body_of({Sphere{{0.3, 0.9, 1.1}, 0.15}})});
  ASSERT_GT(set.size(), 40);
  for (LocalIndex p = 0; p < set.size(); ++p) {
    const Vec3 x = set.vector(Field::position, p);
    GlobalIndex cell = 0, place = 0;
    for (int a = 0; a < 3; ++a) {
      const int half_cell = static_cast<int>((x[a] - grid.lower[a]) * 16.0);
      cell = 8 * cell + half_cell / 2;
      place = 2 * place + half_cell % 2;
    }
    const GlobalIndex body = x.x() > 0.0 ? 1 : 0;
    EXPECT_EQ(set.id()[p], (body * 512 + cell) * 64 + place);
  }
}

TEST(Seeding, TheSameParticlesHoweverTilesAreSplit) {
  for (const auto order : {SplineOrder::quadratic, SplineOrder::cubic}) {
    GridGeometry grid = unit_grid(12, order);
    grid.periodic = {false, true, false};
    Body jittered = body_of({Sphere{{0.1, 0.2, 0.8}, 0.45}}, 27);
    jittered.lattice = SeedingLattice::jittered;
    jittered.seed = 5;
    jittered.velocity = Vec3(0.1, 0.2, 0.3);
    jittered.angular_velocity = Vec3(1.0, 2.0, 3.0);
    const std::vector<Body> bodies = {body_of(slanted_cylinder), jittered};
    const auto expected = particles_by_id(seeded(grid, bodies));
    for (const int n_parts : {2, 3, 7}) {
      std::map<GlobalIndex, std::string> together;
      std::size_t count = 0;
      for (int part = 0; part < n_parts; ++part) {
        std::vector<TileIndex> tiles;
        for (TileIndex t = part; t < grid.n_tiles(); t += n_parts) tiles.push_back(t);
        ParticleSet set;
        seed_particles(grid, bodies, tiles, set);
        for (LocalIndex p = 0; p < set.size(); ++p) EXPECT_EQ(grid.tile_of(set.vector(Field::position, p)) % n_parts, part);
        count += static_cast<std::size_t>(set.size());
        together.merge(particles_by_id(set));
      }
      EXPECT_EQ(count, expected.size());
      EXPECT_TRUE(together == expected);
    }
  }
}

TEST(Seeding, CountsAgreeWithParticles) {
  const GridGeometry grid = unit_grid(12);
  std::vector<Body> bodies = {body_of(slanted_cylinder), body_of({Sphere{{0.1, 0.5, 0.8}, 0.3}}, 27)};
  bodies[0].material_index = 2;
  const ParticleSet set = seeded(grid, bodies);
  const TileIndex middle = grid.n_tiles() / 2;
  for (const TileIndex first : {TileIndex{0}, middle}) {
    std::map<TileIndex, std::array<GlobalIndex, 3>> expected;
    std::map<TileIndex, std::uint64_t> cells;
    for (LocalIndex p = 0; p < set.size(); ++p) {
      const Vec3 x = set.vector(Field::position, p);
      const TileIndex tile = grid.tile_of(x);
      if (tile < first) continue;
      ++expected[tile][set.material()[p]];
      int place = 0;
      for (int axis = 0; axis < 3; ++axis) place = 4 * place + grid.base_node(axis, x[axis]) % 4;
      cells[tile] |= std::uint64_t{1} << place;
    }
    const TileCensus census = count_particles(grid, bodies, first, grid.n_tiles());
    ASSERT_EQ(census.n_materials, 3);
    ASSERT_EQ(census.size(), expected.size());
    std::size_t t = 0;
    for (const auto& [tile, count] : expected) {
      EXPECT_EQ(census.tile[t], tile);
      EXPECT_EQ(census.cells[t], cells[tile]);
      for (int m = 0; m < 3; ++m) EXPECT_EQ(census.count[3 * t + m], count[m]);
      EXPECT_EQ(census.n_particles(t), count[0] + count[2]);
      ++t;
    }
  }
  EXPECT_EQ(count_particles(grid, bodies, 5, 5).size(), 0u);
}

TEST(Seeding, JitterIsBoundedReproducibleAndFollowsTheSeed) {
  const GridGeometry grid = unit_grid(8);
  Body body = body_of({Box{Vec3::Constant(-9.0), Vec3::Constant(9.0)}});
  const ParticleSet regular = seeded(grid, {body});
  body.lattice = SeedingLattice::jittered;
  body.seed = 1;
  const ParticleSet first = seeded(grid, {body}), again = seeded(grid, {body});
  body.seed = 2;
  const ParticleSet other = seeded(grid, {body});
  EXPECT_TRUE(particles_by_id(first) == particles_by_id(again));

  const double spacing = 0.5 * grid.cell_size;
  Vec3 mean = Vec3::Zero();
  Mat3 moments = Mat3::Zero();
  int same = 0;
  for (LocalIndex p = 0; p < regular.size(); ++p) {
    ASSERT_EQ(first.id()[p], other.id()[p]);
    const Vec3 x = first.vector(Field::position, p);
    same += x == other.vector(Field::position, p) ? 1 : 0;
    const GlobalIndex id = first.id()[p], cell = id / 64, place = id % 64;
    Vec3 offset;
    for (int a = 0; a < 3; ++a) {
      const int shift = 2 - a;
      const double home =
          grid.lower[a] + spacing * (static_cast<double>(2 * (cell >> (3 * shift) & 7) + (place >> shift & 1)) + 0.5);
      offset[a] = (x[a] - home) / spacing;
      EXPECT_LE(std::abs(offset[a]), 0.4 + 1e-12);
    }
    mean += offset / regular.size();
    moments += offset * offset.transpose() / regular.size();
  }
  EXPECT_EQ(same, 0);
  // Uniform in [-0.4, 0.4], the axes independent: within five standard errors of 4096 samples.
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(mean[a], 0.0, 5.0 * 0.231 / 64.0);
    for (int b = 0; b < 3; ++b) EXPECT_NEAR(moments(a, b), a == b ? 0.16 / 3.0 : 0.0, 5.0 * (a == b ? 0.048 : 0.053) / 64.0);
  }
}

// --- what they carry -------------------------------------------------------------------------------------------------

TEST(Seeding, ParticlesCarryTheStateOfTheirBody) {
  const GridGeometry grid = unit_grid(8);
  Body body = body_of({Sphere{{0.0, 0.6, 0.8}, 0.3}});
  body.material_index = 3;
  body.velocity = Vec3(0.1, 0.2, 0.3);
  body.angular_velocity = Vec3(1.0, -2.0, 3.0);
  body.center = Vec3(0.1, 0.5, 0.9);
  const ParticleSet set = seeded(grid, {body});
  ASSERT_GT(set.size(), 100);
  for (LocalIndex p = 0; p < set.size(); ++p) {
    const Vec3 arm = set.vector(Field::position, p) - *body.center;
    const Vec3 spin = body.angular_velocity.cross(arm);
    EXPECT_LE((set.vector(Field::velocity, p) - body.velocity - spin).norm(), 1e-15);
    Mat3 C;
    for (int c = 0; c < 9; ++c) C(c / 3, c % 3) = set.real(Field::affine_velocity, c)[p];
    EXPECT_LE((C * arm - spin).norm(), 1e-15);
    for (int c = 0; c < 6; ++c) EXPECT_EQ(set.real(Field::left_cauchy_green, c)[p], c < 3 ? 1.0 : 0.0);
    EXPECT_EQ(set.real(Field::volume_ratio)[p], 1.0);
    EXPECT_EQ(set.real(Field::reference_volume)[p], 1.0 / 4096.0);
    EXPECT_EQ(set.mass(p), 1200.0 / 4096.0);
    EXPECT_EQ(set.material()[p], 3);
    EXPECT_EQ(set.real(Field::plastic_shear_rate)[p], 0.0);
    EXPECT_EQ(set.real(Field::plastic_dissipation)[p], 0.0);
  }
}

TEST(Seeding, AppendsToWhatIsThere) {
  const GridGeometry grid = unit_grid(8);
  const std::vector<Body> bodies = {body_of(slanted_cylinder)};
  ParticleSet set = seeded(grid, bodies);
  const LocalIndex n = set.size();
  const auto before = particles_by_id(set);
  seed_particles(grid, bodies, all_tiles(grid), set);
  ASSERT_EQ(set.size(), 2 * n);
  EXPECT_TRUE(particles_by_id(set) == before);
  EXPECT_EQ(set.vector(Field::position, 5), set.vector(Field::position, n + 5));
}

TEST(Seeding, OverlapGoesToTheFirstBody) {
  const GridGeometry grid = unit_grid(20);
  Body first = body_of({Sphere{{0.0, 0.6, 0.8}, 0.3}}), second = body_of({Box{{-0.4, 0.2, 0.4}, {0.1, 1.0, 1.2}}}, 27);
  first.material_index = 1;
  second.material_index = 2;
  for (const bool swapped : {false, true}) {
    const std::vector<Body> bodies = swapped ? std::vector{second, first} : std::vector{first, second};
    const ParticleSet set = seeded(grid, bodies);
    int n_first = 0, n_second = 0;
    for (LocalIndex p = 0; p < set.size(); ++p) {
      const Vec3 x = set.vector(Field::position, p);
      const std::uint8_t owner =
          signed_distance(bodies[0].shape, x) <= 0.0 ? bodies[0].material_index : bodies[1].material_index;
      EXPECT_EQ(set.material()[p], owner);
      ++(owner == bodies[0].material_index ? n_first : n_second);
    }
    EXPECT_EQ(n_first, seeded(grid, {bodies[0]}).size());
    EXPECT_GT(n_second, 0);
    EXPECT_LT(n_second, seeded(grid, {bodies[1]}).size());
  }
}

TEST(Seeding, UnionsHoldEachParticleOnceAndPlacedBodiesKeepTheirVolume) {
  const GridGeometry grid = unit_grid(20);
  const Shape left{Box{{-0.4, 0.3, 0.5}, {0.0, 0.6, 0.8}}}, right{Box{{-0.1, 0.3, 0.5}, {0.3, 0.6, 0.8}}};
  const ParticleSet set = seeded(grid, {body_of({Union{{left, right}}})});
  EXPECT_NEAR(total_volume(set), 0.7 * 0.3 * 0.3, 1e-13);
  EXPECT_EQ(particles_by_id(set).size(), static_cast<std::size_t>(set.size()));

  // Turned by a right angle about its own corner and moved: the box (0, 0.2) x (-0.3, 0.1) x (0.5, 0.8) shifted by y = 0.6.
  const Shape flat{Box{{0.0, 0.0, 0.5}, {0.4, 0.2, 0.8}}};
  const Shape turned{Placed{std::make_shared<const Shape>(flat), Vec3::UnitZ(), pi / 2, Vec3::Zero(), Vec3(0.1, 0.4, 0.0)}};
  const ParticleSet moved = seeded(grid, {body_of(turned)});
  EXPECT_NEAR(total_volume(moved), 0.4 * 0.2 * 0.3, 1e-13);
  for (LocalIndex p = 0; p < moved.size(); ++p) {
    const Vec3 x = moved.vector(Field::position, p);
    EXPECT_TRUE(x.x() > -0.1 && x.x() < 0.1 && x.y() > 0.4 && x.y() < 0.8);
  }
}

// --- what is refused -------------------------------------------------------------------------------------------------

TEST(Seeding, BadBodiesAreUsageErrors) {
  const GridGeometry grid = unit_grid(8);
  const auto attempt = [&](const Body& body) { return seeded(grid, {body}).size(); };
  Body body = body_of(slanted_cylinder);
  EXPECT_GT(attempt(body), 0);
  body.particles_per_cell = 9;
  EXPECT_THROW(attempt(body), UsageError);
  EXPECT_THROW(count_particles(grid, {body}, 0, 1), UsageError);
  EXPECT_THROW(attempt(body_of({Sphere{{0, 0, 0}, -1.0}})), UsageError);
  body = body_of(slanted_cylinder);
  body.density = 0.0;
  EXPECT_THROW(attempt(body), UsageError);
  body.density = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(attempt(body), UsageError);

  GridGeometry huge = grid;
  huge.n_cells = {1 << 19, 1 << 19, 1 << 19};
  EXPECT_THROW(count_particles(huge, {body_of(slanted_cylinder)}, 0, 0), UsageError);
}

TEST(Seeding, VelocityFieldAddsToVelocityAndSpin) {
  const GridGeometry grid = unit_grid(10);
  Body body = body_of({Box{grid.lower, grid.upper()}}, 27);
  body.velocity = Vec3(0.1, 0.2, 0.3);
  body.angular_velocity = Vec3(0.0, 0.0, 2.0);
  body.center = Vec3(0.05, 0.1, 0.2);
  body.velocity_field.text = {"sin(2*pi*x)", "y*z", "x*x"};
  const ParticleSet set = seeded(grid, {body});
  for (LocalIndex p = 0; p < set.size(); p += 7) {
    const Vec3 x = set.vector(Field::position, p);
    const Vec3 truth(0.1 - 2.0 * (x[1] - 0.1) + std::sin(2.0 * pi * x[0]), 0.2 + 2.0 * (x[0] - 0.05) + x[1] * x[2],
                     0.3 + x[0] * x[0]);
    EXPECT_LE((set.vector(Field::velocity, p) - truth).norm(), 1e-14);
    Mat3 gradient;
    gradient << 2.0 * pi * std::cos(2.0 * pi * x[0]), -2.0, 0.0, 2.0, x[2], x[1], 2.0 * x[0], 0.0, 0.0;
    for (int c = 0; c < 9; ++c)
      EXPECT_NEAR(set.real(Field::affine_velocity, c)[p], gradient(c / 3, c % 3), 1e-9 * 2.0 * pi) << c;
  }
}

TEST(Seeding, TheFirstUndefinedMotionIsFoundByTheShareThatHoldsIt) {
  const GridGeometry grid = unit_grid(20);
  Body body = body_of({Box{grid.lower, grid.upper()}});
  EXPECT_FALSE(find_undefined_motion(grid, {body}, 0, grid.n_tiles()));
  body.velocity_field.text = {"ln(0.2 - x)", "0", "0"};
  const auto whole = find_undefined_motion(grid, {body}, 0, grid.n_tiles());
  ASSERT_TRUE(whole);
  EXPECT_GT(whole->position[0], 0.2 - grid.cell_size);
  int n_finders = 0;
  for (TileIndex first = 0; first < grid.n_tiles(); first += 7) {
    const auto part = find_undefined_motion(grid, {body}, first, std::min<TileIndex>(first + 7, grid.n_tiles()));
    if (!part) continue;
    EXPECT_EQ(part->position == whole->position, n_finders == 0) << first;  // a share finds what is its own
    ++n_finders;
  }
  EXPECT_GT(n_finders, 1);
}

}  // namespace
}  // namespace bulkley::seeding_test
