// ranks: 1 3 4
#include "io/checkpoint/fingerprint.hpp"

#include <gtest/gtest.h>

#include "io/checkpoint/checkpoint.hpp"
#include "support/altered_checkpoint.hpp"

namespace bulkley::fingerprint_mpi_test {
namespace {

class Fingerprints : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  SharedFolder folder{comm};
  const std::vector<std::string> materials{"cream", "pie"};

  Fingerprint of(const ParticleSet& particles, Field field) {
    std::vector<Fingerprint> sums{fingerprint_of(particles, info(field))};
    sum_global(comm, sums);
    return sums[0];
  }
  // All on the last rank, in descending order of id.
  ParticleSet reversed(GlobalIndex n) {
    ParticleSet particles;
    particles.resize(comm.rank() == comm.size() - 1 ? static_cast<LocalIndex>(n) : 0);
    for (LocalIndex p = 0; p < particles.size(); ++p) fill_particle(particles, p, n - 1 - p);
    return particles;
  }
  std::string write(const ParticleSet& particles) {
    CheckpointHeader header;
    header.step = 1;
    header.reals = {{"time_step", 0.1}};
    header.integers = {{"cooldown", -3}};
    write_checkpoint(comm, folder.path(), header, particles, materials, 1);
    return checkpoint_path(folder.path(), 1);
  }
  std::string fault_of(const std::string& file) {
    return sentence_of<RunError>([&] { verify_checkpoint(comm, file); });
  }
};

TEST_F(Fingerprints, DoNotDependOnOrderAndRanks) {
  const ParticleSet particles = make_uneven_particles(comm, 3000), others = reversed(3000);
  for (const Field field : {Field::position, Field::reference_volume, Field::left_cauchy_green, Field::material, Field::id})
    EXPECT_EQ(of(particles, field), of(others, field)) << info(field).name;
  EXPECT_FALSE(of(particles, Field::position) == of(particles, Field::velocity));
}

TEST_F(Fingerprints, ChangeWithEveryBitAndItsPlace) {
  const ParticleSet right = reversed(50);
  const bool mine = right.size() > 0;
  const auto expect_other = [&](Field field, const std::function<void(ParticleSet&)>& change) {
    ParticleSet changed = reversed(50);
    if (mine) change(changed);
    const Fingerprint a = of(right, field), b = of(changed, field);
    EXPECT_NE(a.first, b.first) << info(field).name;
    EXPECT_NE(a.second, b.second) << info(field).name;
  };
  const auto velocity = [](ParticleSet& particles, int component) { return particles.real(Field::velocity, component); };
  expect_other(Field::velocity, [&](ParticleSet& p) { velocity(p, 2)[31] = std::nextafter(velocity(p, 2)[31], 10.0); });
  expect_other(Field::velocity, [&](ParticleSet& p) { std::swap(velocity(p, 0)[3], velocity(p, 1)[3]); });
  expect_other(Field::velocity, [&](ParticleSet& p) { std::swap(velocity(p, 0)[3], velocity(p, 0)[4]); });
  expect_other(Field::velocity, [&](ParticleSet& p) { std::swap(p.id()[3], p.id()[4]); });
  expect_other(Field::material, [&](ParticleSet& p) { p.material()[7] ^= 1; });
  expect_other(Field::id, [&](ParticleSet& p) { p.id()[7] = 1000; });
  expect_other(Field::id, [&](ParticleSet& p) { p.id()[7] = p.id()[8]; });
  // Two ids whose sum stays.
  expect_other(Field::id, [&](ParticleSet& p) { ++p.id()[0], --p.id()[49]; });
}

TEST_F(Fingerprints, AreThoseOfTheParticlesThatWereWritten) {
  const std::string file = write(make_uneven_particles(comm, 500));
  const CheckpointHeader header = read_header(comm, file), verified = verify_checkpoint(comm, file);
  EXPECT_EQ(header.fingerprints.size(), Hdf5Reader(file).members("/particles").size() - 1);  // all but connectivity
  EXPECT_EQ(header.fingerprints, verified.fingerprints);
  EXPECT_EQ(header.fingerprints.at("velocity"), of(reversed(500), Field::velocity));
  EXPECT_EQ(verify_checkpoint(comm, write(reversed(500))).fingerprints, header.fingerprints);
}

// Files are kept: these are the values that programs have written so far.
TEST_F(Fingerprints, KeepTheirValues) {
  const ParticleSet particles = reversed(3);
  const Fingerprint id = of(particles, Field::id), position = of(particles, Field::position);
  EXPECT_EQ(id, (Fingerprint{0x277d3606972297de, 0x7386754be3da70d3})) << fmt::format("{:#x} {:#x}", id.first, id.second);
  EXPECT_EQ(position, (Fingerprint{0x747ed241ef3225a5, 0x33f0d97aab93caad}))
      << fmt::format("{:#x} {:#x}", position.first, position.second);
}

// The checksums are right.
TEST_F(Fingerprints, RefuseOtherIdsAndValues) {
  const std::string file = write(make_uneven_particles(comm, 20)), altered = folder.file("altered.h5");
  const auto ids = whole_array<GlobalIndex>(Hdf5Reader(file), "/particles/id");
  const auto fault_with = [&](const std::function<void(FileContent&)>& alter) {
    write_altered(comm, file, altered, alter);
    return fault_of(altered);
  };
  EXPECT_EQ(fault_with([](FileContent&) {}), "nothing thrown");
  const auto expect_fault = [&](const std::string& sentence, const std::string& fault) {
    EXPECT_NE(sentence.find(fmt::format("cannot read '{}': {}", altered, fault)), std::string::npos) << sentence;
  };
  expect_fault(fault_with(with_value("id", 19, ids[0])), fmt::format("the particle id {} occurs twice", ids[0]));
  expect_fault(fault_with(with_value("id", 3, GlobalIndex{12345})),
               "id is not what was written (the fingerprint of the values and their ids does not match)");
  expect_fault(fault_with(with_value("velocity", 7, 0.5)), "velocity is not what was written");
  EXPECT_NE(fault_with([](FileContent& content) {
              for (Attribute& attribute : content.attributes)
                if (attribute.object == "/state/fingerprints" && attribute.name == "reference_volume")
                  attribute.value = std::vector<GlobalIndex>{1, 2, 3};
            }).find("the fingerprint of reference_volume is damaged"),
            std::string::npos);
}

// As programs wrote them that had no fingerprints.
TEST_F(Fingerprints, AreNotNeeded) {
  const std::string file = write(make_uneven_particles(comm, 20)), old = folder.file("old.h5");
  const auto ids = whole_array<GlobalIndex>(Hdf5Reader(file), "/particles/id");
  const std::vector<std::string> groups{"/", "/state/reals", "/state/integers"};
  write_altered(
      comm, file, old, [](FileContent&) {}, groups);
  EXPECT_TRUE(read_header(comm, old).fingerprints.empty());
  EXPECT_EQ(verify_checkpoint(comm, old).fingerprints, read_header(comm, file).fingerprints);
  write_altered(comm, file, old, with_value("id", 3, GlobalIndex{12345}), groups);
  EXPECT_EQ(fault_of(old), "nothing thrown");
  write_altered(comm, file, old, with_value("id", 19, ids[0]), groups);
  EXPECT_NE(fault_of(old).find(fmt::format("cannot read '{}': the particle id {} occurs twice", old, ids[0])),
            std::string::npos)
      << fault_of(old);
}

}  // namespace
}  // namespace bulkley::fingerprint_mpi_test
