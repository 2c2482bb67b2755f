// ranks: 1 2 3 7
// Checkpoints compared by many ranks, against one process.
#include "io/checkpoint/compare.hpp"

#include <gtest/gtest.h>

#include <random>

#include "io/checkpoint/checkpoint.hpp"
#include "support/altered_checkpoint.hpp"
#include "support/serial_compare.hpp"

namespace bulkley::compare_mpi_test {
namespace {

constexpr GlobalIndex n_particles = 3000;

class Compare : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  SharedFolder folder_a{comm}, folder_b{comm};
  std::string a, b;

  std::string write(const SharedFolder& folder, const ParticleSet& particles, GlobalIndex step = 5, double time = 0.5) {
    CheckpointHeader header;
    header.step = step;
    header.time = time;
    write_checkpoint(comm, folder.path(), header, particles, std::vector<std::string>{"cream", "pie"}, 1);
    return checkpoint_path(folder.path(), step);
  }
  // The particles of file a, in an order without pattern, all on the last rank.
  ParticleSet shuffled(OptionalFields fields = {}) {
    ParticleSet particles(fields);
    if (comm.rank() != comm.size() - 1) return particles;
    std::vector<GlobalIndex> ids;
    for (GlobalIndex id = 0; id < n_particles; ++id) ids.push_back(id);
    std::shuffle(ids.begin(), ids.end(), std::mt19937(7));
    particles.resize(static_cast<LocalIndex>(n_particles));
    for (LocalIndex p = 0; p < particles.size(); ++p) fill_particle(particles, p, ids[static_cast<std::size_t>(p)]);
    return particles;
  }
  // The same particle in `particles`; none elsewhere.
  static void with(ParticleSet& particles, GlobalIndex id, const std::function<void(LocalIndex)>& change) {
    for (LocalIndex p = 0; p < particles.size(); ++p)
      if (particles.id()[p] == id) return change(p);
  }
  // What ranks say of files a and b, in one round and in many.
  void expect_as_serial() {
    const Comparison expected = serial_comparison(a, b);
    for (const GlobalIndex particles_per_round : {GlobalIndex{1} << 18, GlobalIndex{100}})
      for (const bool full : {false, true}) {
        const Comparison found = compare_checkpoints(comm, a, b, {full, particles_per_round});
        EXPECT_EQ(found.identical, expected.identical);
        EXPECT_EQ(comparison_text(found), comparison_text(expected));
        if (!full && expected.identical) continue;
        ASSERT_EQ(found.fields.size(), expected.fields.size());
        for (std::size_t f = 0; f < found.fields.size(); ++f) {
          EXPECT_EQ(found.fields[f].n_different, expected.fields[f].n_different) << found.fields[f].name;
          EXPECT_EQ(found.fields[f].scale, expected.fields[f].scale) << found.fields[f].name;
          EXPECT_EQ(found.fields[f].absolute_id, expected.fields[f].absolute_id) << found.fields[f].name;
          EXPECT_EQ(found.fields[f].relative_id, expected.fields[f].relative_id) << found.fields[f].name;
        }
        for (const double tolerance : {0.0, 1e-6, 0.1, 1.0})
          EXPECT_EQ(within(found, tolerance), within(expected, tolerance));
      }
  }
};

TEST_F(Compare, EqualParticlesInAnyOrder) {
  a = write(folder_a, make_uneven_particles(comm, n_particles));
  b = write(folder_b, shuffled());
  expect_as_serial();
  EXPECT_TRUE(compare_checkpoints(comm, a, b).identical);
}

TEST_F(Compare, NoParticles) {
  a = write(folder_a, ParticleSet());
  b = write(folder_b, ParticleSet());
  expect_as_serial();
  b = write(folder_b, shuffled());
  expect_as_serial();
}

TEST_F(Compare, PlantedDifferences) {
  a = write(folder_a, make_uneven_particles(comm, n_particles));
  ParticleSet particles = shuffled();
  for (GlobalIndex id = 100; id < n_particles; id += 37)
    with(particles, id, [&](LocalIndex p) { particles.real(Field::position, static_cast<int>(id % 3))[p] *= 1.0 + 1e-9; });
  with(particles, 1234, [&](LocalIndex p) { particles.real(Field::velocity, 1)[p] = -3.0; });
  with(particles, 77, [&](LocalIndex p) { particles.material()[p] ^= 1; });
  with(particles, 2000, [&](LocalIndex p) { particles.id()[p] = 50000; });
  with(particles, 2999, [&](LocalIndex p) { particles.id()[p] = 50001; });
  b = write(folder_b, particles);
  expect_as_serial();
  EXPECT_NE(comparison_text(compare_checkpoints(comm, a, b)).find("velocity: 1 values differ"), std::string::npos);
}

// Where differences are equally large, the particle with the smallest id is named, wherever it is.
TEST_F(Compare, TiesGoToTheSmallestId) {
  ParticleSet before = shuffled(), after = shuffled();
  for (GlobalIndex id = 2999; id > 40; id -= 29) {  // to 41
    with(before, id, [&](LocalIndex p) { before.real(Field::reference_volume)[p] = 1.0; });
    with(after, id, [&](LocalIndex p) { after.real(Field::reference_volume)[p] = 1.5; });
    with(before, id, [&](LocalIndex p) { before.real(Field::plastic_shear_rate)[p] = 0.0; });  // equal but for their bits
    with(after, id, [&](LocalIndex p) { after.real(Field::plastic_shear_rate)[p] = -0.0; });
  }
  a = write(folder_a, before);
  b = write(folder_b, after);
  expect_as_serial();
  EXPECT_EQ(comparison_text(compare_checkpoints(comm, a, b)),
            "plastic_shear_rate: 103 values differ, by at most 0 1/s (particle 41), relatively 0 (particle 41)\n"
            "reference_volume: 103 values differ, by at most 0.5 m^3 (particle 41), relatively 0.333 (particle 41)\n");
}

TEST_F(Compare, OtherMomentsAndFields) {
  a = write(folder_a, make_uneven_particles(comm, n_particles));
  b = write(folder_b, shuffled({Field::hardening}), 6, 0.75);
  expect_as_serial();
  std::swap(a, b);
  expect_as_serial();
}

TEST_F(Compare, FilesWithoutFingerprints) {
  b = write(folder_b, shuffled());
  CheckpointHeader header;
  header.step = 5;
  header.time = 0.5;
  header.reals = {{"x", 1.0}};
  header.integers = {{"n", 1}};
  write_checkpoint(comm, folder_a.path(), header, make_uneven_particles(comm, n_particles),
                   std::vector<std::string>{"cream", "pie"}, 1);
  const std::string old = folder_a.file("old.h5"), whole = checkpoint_path(folder_a.path(), 5);
  write_altered(comm, whole, old, [](FileContent&) {}, {"/", "/state/reals", "/state/integers"});
  a = old;
  expect_as_serial();
  EXPECT_TRUE(compare_checkpoints(comm, a, b).identical);
}

TEST_F(Compare, NamesTheSmallestIdThatOccursTwice) {
  a = write(folder_a, make_uneven_particles(comm, n_particles));
  ParticleSet particles = shuffled();
  for (const GlobalIndex id : {900, 300, 600}) with(particles, id, [&](LocalIndex p) { particles.id()[p] = id + 1; });
  b = write(folder_b, particles);
  for (const GlobalIndex particles_per_round : {10000, 50})
    EXPECT_EQ(sentence_of<RunError>([&] {
                compare_checkpoints(comm, a, b, {false, particles_per_round});
              }),
              fmt::format("in '{}' the particle id 301 occurs twice", b));
}

}  // namespace
}  // namespace bulkley::compare_mpi_test
