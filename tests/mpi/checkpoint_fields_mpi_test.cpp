// ranks: 1 2 3
// Checkpoints of particles with internal variables, which only some laws need.
#include "io/checkpoint/checkpoint.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "io/arrays/array_file.hpp"
#include "io/checkpoint/compare.hpp"
#include "support/io_particles.hpp"
#include "support/particle_builders.hpp"

namespace bulkley::checkpoint_fields_mpi_test {
namespace {

const std::vector<std::string> materials{"sand", "snow"};

class CheckpointFields : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  SharedFolder folder{comm};
};

CheckpointHeader make_header(GlobalIndex step) {
  CheckpointHeader header;
  header.step = step;
  header.time = 0.1;
  return header;
}

const OptionalFields internal_variables_of_all{Field::structure, Field::hardening, Field::plastic_volume_ratio,
                                               Field::viscous_left_cauchy_green, Field::added_law_variables};

ParticleSet with_fields(const ParticleSet& given, OptionalFields fields) {
  ParticleSet particles(fields);
  particles.resize(given.size());
  for (LocalIndex p = 0; p < given.size(); ++p) fill_particle(particles, p, given.id()[p]);
  return particles;
}

TEST_F(CheckpointFields, InternalVariablesAreWrittenAndReadBackBitForBit) {
  for (const OptionalFields fields : {internal_variables_of_all, OptionalFields{Field::hardening}}) {
    const ParticleSet given = with_fields(make_uneven_particles(comm, 1000), fields);
    write_checkpoint(comm, folder.path(), make_header(1), given, materials, 1);
    const std::string file = checkpoint_path(folder.path(), 1);
    const Hdf5Reader reader(file);
    GlobalIndex bytes = 0;
    for (const std::string& name : reader.members("/particles")) {
      const ArrayInfo array = reader.array("/particles/" + name);
      bytes += n_elements(array.shape) * static_cast<GlobalIndex>(element_size(array.type));
    }
    EXPECT_EQ(checkpoint_bytes(fields, 1000), bytes);
    ParticleSet read(fields);
    const EvenShare share = even_share(comm, 1000);
    read_checkpoint(comm, file, share.first, share.count(), read);
    EXPECT_TRUE(read.optional_fields() == fields);
    ASSERT_EQ(read.size(), share.count());
    ParticleSet expected(fields);
    expected.resize(read.size());
    for (LocalIndex p = 0; p < read.size(); ++p) fill_particle(expected, p, share.first + p);
    EXPECT_TRUE(same_particles(read, expected));
    EXPECT_NE(describe_file(comm, file).find("/particles/hardening"), std::string::npos);
  }
}

// Other fields than those of the scene's laws are passed over; one that is needed must be there.
TEST_F(CheckpointFields, RefusesAFileWithoutAnInternalVariableThatIsNeeded) {
  write_checkpoint(comm, folder.path(), make_header(1), with_fields(make_uneven_particles(comm, 50), {Field::hardening}),
                   materials, 1);
  const std::string file = checkpoint_path(folder.path(), 1);
  const GlobalIndex first = comm.is_root() ? 0 : 50, count = 50 - first;
  ParticleSet snow({Field::hardening, Field::plastic_volume_ratio});
  const std::string sentence = sentence_of<RunError>([&] { read_checkpoint(comm, file, first, count, snow); });
  const std::string expected =
      "'" + file + "' does not hold 'plastic_volume_ratio', which the law of a material or output.fields in the scene needs";
  EXPECT_NE(sentence.find(expected), std::string::npos) << sentence;
  ParticleSet plain;
  EXPECT_EQ(sentence_of<RunError>([&] { read_checkpoint(comm, file, first, count, plain); }), "nothing thrown");
  EXPECT_TRUE(same_particles(plain, make_particles(0, count)) || count == 0);
}

// A scene may ask for the stress of particles that did not store it.
TEST_F(CheckpointFields, SaysWhetherAFileLacksTheStress) {
  const OptionalFields stress{Field::kirchhoff_stress};
  const std::string file = checkpoint_path(folder.path(), 1);
  for (const bool stored : {true, false}) {
    write_checkpoint(comm, folder.path(), make_header(1),
                     with_fields(make_uneven_particles(comm, 50), stored ? stress : OptionalFields{}), materials, 1);
    const EvenShare share = even_share(comm, 50);
    ParticleSet asking(stress), plain;
    EXPECT_EQ(read_checkpoint(comm, file, share.first, share.count(), asking), stored);
    EXPECT_TRUE(read_checkpoint(comm, file, share.first, share.count(), plain));
    for (LocalIndex p = 0; p < asking.size(); ++p) EXPECT_EQ(asking.real(Field::kirchhoff_stress)[p] != 0.0, stored);
  }
}

TEST_F(CheckpointFields, CompareNamesAFieldThatOnlyOneFileHas) {
  SharedFolder other(comm);
  const ParticleSet plain = make_uneven_particles(comm, 60);
  write_checkpoint(comm, folder.path(), make_header(1), with_fields(plain, {Field::structure}), materials, 1);
  const std::string a = checkpoint_path(folder.path(), 1), b = checkpoint_path(other.path(), 1);
  write_checkpoint(comm, other.path(), make_header(1), with_fields(plain, {Field::structure}), materials, 1);
  EXPECT_TRUE(compare_checkpoints(comm, a, b).identical);
  write_checkpoint(comm, other.path(), make_header(1), plain, materials, 1);
  for (const Comparison& comparison : {compare_checkpoints(comm, a, b), compare_checkpoints(comm, b, a)}) {
    EXPECT_FALSE(comparison.identical);
    if (!comm.is_root()) continue;
    EXPECT_EQ(comparison.only_in_one, std::vector<std::string>{"structure"});
    EXPECT_FALSE(within(comparison, 1.0));
    EXPECT_NE(comparison_text(comparison).find("structure: only in one of the files"), std::string::npos);
  }
}

}  // namespace
}  // namespace bulkley::checkpoint_fields_mpi_test
