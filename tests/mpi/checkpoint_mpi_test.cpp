// ranks: 1 3 4
#include "io/checkpoint/checkpoint.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <bit>
#include <cmath>
#include <csignal>
#include <limits>

#include "io/arrays/array_file.hpp"
#include "io/checkpoint/compare.hpp"
#include "io/files/text_file.hpp"
#include "support/altered_checkpoint.hpp"

namespace bulkley::checkpoint_mpi_test {
namespace {

const std::vector<std::string> materials{"cream", "pie"};

CheckpointHeader make_header(GlobalIndex step) {
  CheckpointHeader header;
  header.step = step;
  header.time = 0.1 + 1e-17 * static_cast<double>(step);
  header.scene_text = "title = \"ä \\\"quoted\\\"\"\n[domain]\n";
  header.code_version = "0.1.0-test";
  header.reals = {{"time_step", 0.1}, {"denormal", 5e-324}, {"minus_zero", -0.0}, {"nan", std::nan("7")}};
  header.integers = {{"cooldown", -3}, {"large", std::numeric_limits<GlobalIndex>::max()}};
  return header;
}

class Checkpoint : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  SharedFolder folder{comm};

  std::string write(GlobalIndex step, GlobalIndex n_particles, int keep = 100) {
    write_checkpoint(comm, folder.path(), make_header(step), make_uneven_particles(comm, n_particles), materials, keep);
    return checkpoint_path(folder.path(), step);
  }
  // Even shares.
  ParticleSet read(const std::string& file) {
    const EvenShare share = even_share(comm, read_header(comm, file).n_particles);
    ParticleSet particles;
    read_checkpoint(comm, file, share.first, share.count(), particles);
    return particles;
  }
  void on_root(const std::function<void()>& work) { root_guard(comm, work); }
  // Everything that reads a checkpoint must refuse `file`, on every rank, with a sentence that holds `fault` and the path.
  void expect_refused(const std::string& file, const std::string& fault) {
    for (const std::string& sentence :
         {sentence_of<RunError>([&] { read(file); }), sentence_of<RunError>([&] { verify_checkpoint(comm, file); }),
          sentence_of<RunError>([&] { describe_file(comm, file); }),
          sentence_of<RunError>([&] { compare_checkpoints(comm, file, file); })}) {
      EXPECT_NE(sentence.find(fault), std::string::npos) << sentence;
      EXPECT_NE(sentence.find(file), std::string::npos) << sentence;
      EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
      EXPECT_EQ(broadcast_text(comm, sentence), sentence) << "the ranks say different things";
    }
  }
};

// Particles [first, ...) of a file written in rank order, hence in order of id, with every written field bit for bit.
int n_wrong(const ParticleSet& particles, GlobalIndex first) {
  ParticleSet expected = make_particles(first, particles.size());
  int wrong = 0;
  for (std::size_t c = 0; c < particles.columns().size(); ++c) {
    if (!info(particles.columns()[c].field).written) continue;
    const std::size_t bytes = static_cast<std::size_t>(particles.size()) * particles.columns()[c].element_size;
    wrong += bytes > 0 && std::memcmp(particles.data(c), expected.data(c), bytes) != 0;
  }
  return wrong;
}

TEST_F(Checkpoint, ReadsBackBitForBitInOtherShares) {
  for (const GlobalIndex n : {0, 1, 2, 1000, 40001}) {
    const std::string file = write(n, n);
    const ParticleSet particles = read(file);
    EXPECT_EQ(sum_global(comm, particles.size()), n);
    EXPECT_EQ(n_wrong(particles, exclusive_sum(comm, particles.size())), 0) << n << " particles";
  }
}

TEST_F(Checkpoint, OneRankMayTakeEverything) {
  const std::string file = write(1, 500);
  const bool mine = comm.rank() == comm.size() - 1;
  ParticleSet particles = make_particles(0, 7);
  read_checkpoint(comm, file, 0, mine ? 500 : 0, particles);
  EXPECT_EQ(particles.size(), mine ? 500 : 0);
  EXPECT_EQ(n_wrong(particles, 0), 0);
}

TEST_F(Checkpoint, RefusesSharesThatLeaveParticlesOut) {
  const std::string file = write(1, 100);
  ParticleSet particles;
  const std::string sentence =
      sentence_of<RunError>([&] { read_checkpoint(comm, file, 0, comm.is_root() ? 99 : 0, particles); });
  EXPECT_NE(sentence.find("do not make up the 100 particles"), std::string::npos) << sentence;
}

TEST_F(Checkpoint, HeaderSurvivesBitForBit) {
  CheckpointHeader given = make_header(123456789);
  given.scene_text += std::string(200000, 'x');  // above the 64 KiB of an HDF5 attribute of the old kind
  if (!comm.is_root()) given.time = 99.0;        // the root's header counts
  write_checkpoint(comm, folder.path(), given, make_uneven_particles(comm, 10), materials, 1);
  const CheckpointHeader read = read_header(comm, checkpoint_path(folder.path(), 123456789));
  const CheckpointHeader expected = make_header(123456789);
  EXPECT_EQ(read.step, 123456789);
  EXPECT_EQ(std::bit_cast<GlobalIndex>(read.time), std::bit_cast<GlobalIndex>(expected.time));
  EXPECT_EQ(read.scene_text, given.scene_text);
  EXPECT_EQ(read.code_version, expected.code_version);
  EXPECT_EQ(read.n_ranks, comm.size());
  EXPECT_EQ(read.n_particles, 10);
  EXPECT_EQ(read.material_names, materials);
  EXPECT_EQ(read.integers, expected.integers);
  EXPECT_EQ(read.reals.size(), expected.reals.size());
  for (const auto& [name, value] : expected.reals)
    EXPECT_EQ(std::bit_cast<GlobalIndex>(read.reals.at(name)), std::bit_cast<GlobalIndex>(value)) << name;
}

TEST_F(Checkpoint, ChecksumsDoNotDependOnTheRanks) {
  const std::string file = write(1, 5000);
  // The same particles, all on the root.
  SharedFolder other(comm);
  write_checkpoint(comm, other.path(), make_header(1), make_particles(0, comm.is_root() ? 5000 : 0), materials, 1);
  const Hdf5Reader a(file), b(checkpoint_path(other.path(), 1));
  for (const std::string& name : a.members("/particles"))
    EXPECT_EQ(stored_crc(a, "/particles/" + name), stored_crc(b, "/particles/" + name)) << name;
  EXPECT_NE(stored_crc(a, "/particles/velocity"), stored_crc(a, "/particles/position"));
}

TEST_F(Checkpoint, KeepsTheNewestAndCleansUp) {
  on_root([&] { replace_file(folder.file("checkpoint_000000007.h5.tmp"), "left by a killed run"); });
  for (const GlobalIndex step : {10, 20, 30}) write(step, 50, 2);
  EXPECT_FALSE(folder.has("checkpoint_000000010.h5"));
  EXPECT_FALSE(folder.has("checkpoint_000000010.xdmf"));
  EXPECT_TRUE(folder.has("checkpoint_000000020.h5"));
  EXPECT_TRUE(folder.has("checkpoint_000000030.h5"));
  EXPECT_TRUE(folder.has("checkpoint_000000030.xdmf"));
  EXPECT_FALSE(folder.has("checkpoint_000000007.h5.tmp"));
  EXPECT_FALSE(folder.has("checkpoint_000000030.h5.tmp"));

  write(15, 50, 1);  // after going back: later steps are not ours to count
  EXPECT_TRUE(folder.has("checkpoint_000000015.h5"));
  EXPECT_TRUE(folder.has("checkpoint_000000030.h5"));
  EXPECT_EQ(remove_checkpoints_after(comm, folder.path(), 15, 2), 2);
  EXPECT_FALSE(folder.has("checkpoint_000000030.xdmf"));
  EXPECT_TRUE(folder.has("checkpoint_000000015.h5"));

  for (const GlobalIndex step : {16, 17}) write(step, 50, 3);  // as if the writer had been killed before it could remove any
  EXPECT_EQ(remove_checkpoints_after(comm, folder.path(), 17, 2), 0);
  EXPECT_FALSE(folder.has("checkpoint_000000015.h5"));
  EXPECT_FALSE(folder.has("checkpoint_000000015.xdmf"));
  EXPECT_TRUE(folder.has("checkpoint_000000016.h5"));
  EXPECT_TRUE(folder.has("checkpoint_000000017.h5"));
}

TEST_F(Checkpoint, LatestPassesOverDamagedOnes) {
  std::vector<std::string> warnings;
  EXPECT_FALSE(find_latest_checkpoint(comm, folder.path(), warnings).has_value());
  EXPECT_FALSE(find_latest_checkpoint(comm, folder.file("nowhere"), warnings).has_value());
  EXPECT_TRUE(warnings.empty());
  for (const GlobalIndex step : {10, 9, 200}) write(step, 300);
  EXPECT_EQ(find_latest_checkpoint(comm, folder.path(), warnings).value_or(""), checkpoint_path(folder.path(), 200));
  EXPECT_TRUE(warnings.empty());
  on_root([&] {
    const std::string newest = checkpoint_path(folder.path(), 200);
    replace_file(newest, whole_file(newest).substr(0, 5000));
  });
  EXPECT_EQ(find_latest_checkpoint(comm, folder.path(), warnings).value_or(""), checkpoint_path(folder.path(), 10));
  EXPECT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings.at(0).find("checkpoint_000000200.h5"), std::string::npos) << warnings.at(0);
}

TEST_F(Checkpoint, RefusesWhatIsNotACheckpoint) {
  expect_refused(folder.file("missing.h5"), "there is no such file");
  expect_refused(folder.path(), "it is not a file");
  on_root([&] {
    replace_file(folder.file("empty.h5"), "");
    replace_file(folder.file("text.h5"), "step,time\n1,2\n");
  });
  expect_refused(folder.file("empty.h5"), "it is empty");
  expect_refused(folder.file("text.h5"), "it is not an HDF5 file");

  const std::string foreign = folder.file("foreign.h5");
  on_root([&] {
    Hdf5Writer file(foreign, Hdf5Writer::Mode::create);
    file.create_array("/particles", ArrayType::float64, {4});
    file.close();
  });
  expect_refused(foreign, "it is an HDF5 file, but not");
  on_root([&] {
    Hdf5Writer file(foreign, Hdf5Writer::Mode::create);
    file.set_attribute("/", "format", std::string("somebody's"));
    file.set_attribute("/", "format_version", GlobalIndex{1});
    file.close();
  });
  expect_refused(foreign, "it is a 'somebody's', not a bulkley checkpoint");
}

TEST_F(Checkpoint, RefusesNewerVersions) {
  write_array_file(comm, folder.file("new.h5"), {"bulkley checkpoint", checkpoint_version + 1, {}, {}});
  expect_refused(folder.file("new.h5"), "its format version is 2, and this program reads versions up to 1");
}

TEST_F(Checkpoint, RefusesTruncatedFiles) {
  const std::string file = write(1, 2000);
  std::string bytes;
  on_root([&] { bytes = whole_file(file); });
  for (const double part : {0.01, 0.3, 0.999}) {
    on_root(
        [&] { replace_file(file, bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size())))); });
    expect_refused(file, "it is damaged");
  }
}

TEST_F(Checkpoint, FindsEveryFlippedByte) {
  const std::string file = write(1, 300);
  std::string bytes;
  GlobalIndex size = 0;
  on_root([&] { bytes = whole_file(file); });
  size = max_global(comm, static_cast<GlobalIndex>(bytes.size()));
  // Over data and metadata alike. A byte in a hole between objects belongs to nothing and may go unnoticed.
  int n_tried = 0, n_refused = 0, n_accepted_wrong = 0;
  for (GlobalIndex at = 0; at < size; at += size / 60) {
    on_root([&] {
      std::string changed = bytes;
      changed[static_cast<std::size_t>(at)] = static_cast<char>(changed[static_cast<std::size_t>(at)] ^ 0x10);
      replace_file(file, changed);
    });
    ++n_tried;
    try {
      const ParticleSet particles = read(file);
      n_accepted_wrong += n_wrong(particles, exclusive_sum(comm, particles.size()));
    } catch (const RunError&) {
      ++n_refused;
    }
  }
  EXPECT_EQ(n_accepted_wrong, 0);
  EXPECT_GE(n_refused, n_tried - 6) << "of " << n_tried;
}

TEST_F(Checkpoint, NamesTheDamagedArray) {
  const std::string file = write(1, 1000);
  on_root([&] {
    std::string bytes = whole_file(file);
    const std::uint64_t bits = bits_of(777, 0);  // position x of particle 777
    const std::size_t at = bytes.find(std::string(reinterpret_cast<const char*>(&bits), sizeof bits));
    if (at == std::string::npos) throw RunError("the test's particle is not in the file");
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    replace_file(file, bytes);
  });
  expect_refused(file, "/particles/position is damaged (its checksum is");
}

class Altered : public Checkpoint {
 protected:
  std::string write_altered(const std::function<void(FileContent&)>& alter) {
    const std::string altered = folder.file("altered.h5");
    bulkley::write_altered(comm, write(1, 20), altered, alter);
    return altered;
  }
};

TEST_F(Altered, NothingIsAccepted) {
  const std::string file = write_altered([](FileContent&) {});
  EXPECT_EQ(sentence_of<RunError>([&] { verify_checkpoint(comm, file); }), "nothing thrown");
}

TEST_F(Altered, MissingArray) {
  const std::string file = write_altered([](FileContent& content) {
    std::erase_if(content.arrays, [](const Array& array) { return array.path == "/particles/reference_volume"; });
  });
  expect_refused(file, "/particles/reference_volume is missing");
}

TEST_F(Altered, WrongType) {
  const std::string file =
      write_altered([](FileContent& content) { array_of(content, "/particles/id").type = ArrayType::float64; });
  expect_refused(file, "/particles/id is float64 (20) and should be int64 (20)");
}

TEST_F(Altered, WrongShape) {
  const std::string file = write_altered([](FileContent& content) {
    Array& array = array_of(content, "/particles/velocity");
    array.shape[1] = 2;
    array.count[1] = 2;
    array.fill = [](GlobalIndex, GlobalIndex, std::byte*) {};
  });
  expect_refused(file, "/particles/velocity is float64 (20, 2) and should be float64 (20, 3)");
}

TEST_F(Altered, WrongValues) {
  expect_refused(write_altered(with_value("velocity", 3 * 7 + 1, std::nan(""))), "velocity of the particle in row 7 is nan");
  expect_refused(write_altered(with_value("reference_volume", 19, 0.0)),
                 "reference_volume of the particle in row 19 is 0 and must be greater than 0");
  expect_refused(write_altered(with_value("id", 4, GlobalIndex{-3})),
                 "id of the particle in row 4 is -3 and must not be negative");
  expect_refused(write_altered(with_value("material", 11, std::uint8_t{2})),
                 "material of the particle in row 11 is 2, and the file has 2 materials");
}

// Rows of the same rank, and of the first and the last.
TEST_F(Altered, IdsThatOccurTwice) {
  const GlobalIndex id = whole_array<GlobalIndex>(Hdf5Reader(write(1, 20)), "/particles/id").at(0);
  for (const std::size_t row : {1, 19})
    expect_refused(write_altered(with_value("id", row, id)), fmt::format("the particle id {} occurs twice", id));
}

TEST_F(Checkpoint, IdsMayBeAnyDifferentNumbers) {
  ParticleSet particles = make_particles(1000 * comm.rank(), 500);
  for (LocalIndex p = 0; p < particles.size(); ++p)
    particles.id()[p] = (particles.id()[p] << 40) + 7 * (comm.rank() + 1);  // alike in their low bits
  write_checkpoint(comm, folder.path(), make_header(1), particles, materials, 1);
  const std::string file = checkpoint_path(folder.path(), 1);
  EXPECT_EQ(sentence_of<RunError>([&] { verify_checkpoint(comm, file); }), "nothing thrown");
}

TEST_F(Altered, MissingAttribute) {
  const std::string file = write_altered(
      [](FileContent& content) { std::erase_if(content.attributes, [](const Attribute& a) { return a.name == "time"; }); });
  expect_refused(file, "attribute 'time' of / is missing");
}

TEST_F(Altered, ChangedHeader) {
  const std::string file = write_altered([](FileContent& content) {
    for (Attribute& attribute : content.attributes)
      if (attribute.name == "cooldown") attribute.value = GlobalIndex{4};
  });
  expect_refused(file, "its header is damaged");
}

TEST_F(Checkpoint, AFailedWriteLeavesTheOldOnesAlone) {
  write(1, 100);
  const std::string sentence = sentence_of<RunError>([&] {
    write_checkpoint(comm, folder.file("no_such_folder"), make_header(2), make_uneven_particles(comm, 100), materials, 1);
  });
  EXPECT_NE(sentence.find("no_such_folder"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("No such file or directory"), std::string::npos) << sentence;
  EXPECT_TRUE(folder.has("checkpoint_000000001.h5"));
}

TEST_F(Checkpoint, OneRankThatFailsStopsTheWriteOnAll) {
  FileContent content{"bulkley test", 1, {}, {}};
  Array array{"/data", ArrayType::int64, {comm.size()}, {comm.rank()}, {1}, "1", "", {}};
  const int failing = comm.size() - 1;
  array.fill = [&](GlobalIndex, GlobalIndex, std::byte*) {
    if (comm.rank() == failing) throw RunError("out of ink");
  };
  content.arrays = {array};
  const std::string sentence = sentence_of<RunError>([&] { write_array_file(comm, folder.file("a.h5"), content); });
  EXPECT_EQ(sentence, fmt::format("rank {}: out of ink", failing));
  EXPECT_FALSE(folder.has("a.h5"));
  EXPECT_FALSE(folder.has("a.h5.tmp"));
}

// The disk refuses the last bytes of the file to the last rank alone: the root's reservation did not see it coming.
TEST_F(Checkpoint, OneRankThatCannotWriteStopsTheWriteOnAll) {
  if (comm.size() < 3) GTEST_SKIP() << "needs a rank with particles besides the root";
  const std::string whole = write(1, 40000);
  const bool mine = comm.rank() == comm.size() - 1;
  struct rlimit before = {};
  if (mine) {
    getrlimit(RLIMIT_FSIZE, &before);
    struct rlimit less = before;
    less.rlim_cur = std::filesystem::file_size(whole) - 2000;  // inside the last array
    std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &less);
  }
  const std::string sentence = sentence_of<RunError>([&] { write(2, 40000); });
  if (mine) setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_NE(sentence.find(fmt::format("rank {}: cannot write '{}.tmp': File too large", comm.size() - 1,
                                      checkpoint_path(folder.path(), 2))),
            std::string::npos)
      << sentence;
  EXPECT_FALSE(folder.has("checkpoint_000000002.h5"));
  EXPECT_FALSE(folder.has("checkpoint_000000002.h5.tmp"));
  EXPECT_EQ(sentence_of<RunError>([&] { verify_checkpoint(comm, whole); }), "nothing thrown");
}

TEST_F(Checkpoint, DescribesItself) {
  const std::string text = describe_file(comm, write(42, 77));
  for (const char* part : {"checkpoint of step 42", "77 particles", "cream, pie", "/particles/affine_velocity", "(77, 3, 3)",
                           "time_step = 0.1", "checksums are right"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST_F(Checkpoint, ComparesById) {
  const std::string a = write(5, 400);
  SharedFolder other(comm);
  const std::string b = checkpoint_path(other.path(), 5);
  const auto write_other = [&](GlobalIndex n, const std::function<void(ParticleSet&)>& change) {
    // In descending order of id, all on the last rank.
    ParticleSet particles;
    particles.resize(comm.rank() == comm.size() - 1 ? static_cast<LocalIndex>(n) : 0);
    for (LocalIndex p = 0; p < particles.size(); ++p) fill_particle(particles, p, n - 1 - p);
    if (particles.size() > 0) change(particles);
    write_checkpoint(comm, other.path(), make_header(5), particles, materials, 1);
  };

  write_other(400, [](ParticleSet&) {});
  Comparison comparison = compare_checkpoints(comm, a, b);
  EXPECT_TRUE(comparison.identical);
  if (comm.is_root()) {
    EXPECT_EQ(comparison_text(comparison), "identical\n");
  }

  write_other(400, [](ParticleSet& particles) {
    particles.real(Field::velocity, 1)[399 - 12] += 0.25;             // particle 12
    particles.real(Field::reference_volume)[399 - 3] *= 1.0 + 1e-12;  // particle 3
  });
  comparison = compare_checkpoints(comm, a, b);
  EXPECT_FALSE(comparison.identical);
  if (comm.is_root()) {
    for (const FieldDifference& field : comparison.fields) {
      const bool changed = field.name == "velocity" || field.name == "reference_volume";
      EXPECT_EQ(field.n_different, changed ? 1 : 0) << field.name;
      if (field.name == "velocity") {
        EXPECT_NEAR(field.largest_absolute, 0.25, 1e-15);
        EXPECT_EQ(field.absolute_id, 12);
        EXPECT_EQ(field.relative_id, 12);
      }
    }
    EXPECT_FALSE(within(comparison, 0.01));
    EXPECT_TRUE(within(comparison, 0.25));
    EXPECT_NE(comparison_text(comparison).find("velocity: 1 values differ, by at most 0.25 m/s (particle 12)"),
              std::string::npos)
        << comparison_text(comparison);
  }

  write_other(390, [](ParticleSet&) {});
  comparison = compare_checkpoints(comm, a, b);
  EXPECT_FALSE(comparison.identical);
  if (comm.is_root()) {
    EXPECT_EQ(comparison.n_only_a, 10);
    EXPECT_EQ(comparison.first_only_a, 390);
    EXPECT_EQ(comparison.n_only_b, 0);
    EXPECT_FALSE(within(comparison, 1.0));
  }

  write_other(400, [](ParticleSet& particles) {
    particles.id()[399 - 12] = 2000;  // was 12
    particles.id()[399 - 50] = 1000;  // was 50
  });
  comparison = compare_checkpoints(comm, a, b);
  EXPECT_FALSE(comparison.identical);
  if (comm.is_root()) {
    EXPECT_EQ(comparison.n_only_a, 2);
    EXPECT_EQ(comparison.first_only_a, 12);
    EXPECT_EQ(comparison.n_only_b, 2);
    EXPECT_EQ(comparison.first_only_b, 1000);
    for (const FieldDifference& field : comparison.fields) EXPECT_EQ(field.n_different, 0) << field.name;
  }

  const std::string refused = sentence_of<RunError>(
      [&] { write_other(400, [](ParticleSet& particles) { particles.real(Field::volume_ratio)[0] = std::nan(""); }); });
  EXPECT_NE(refused.find("volume_ratio of the particle in row 0 is nan, not a finite number"), std::string::npos) << refused;

  EXPECT_FALSE(compare_checkpoints(comm, a, write(6, 400)).identical);  // another step and time

  write_other(400, [](ParticleSet& particles) { particles.id()[0] = 7; });
  const std::string sentence = sentence_of<RunError>([&] { compare_checkpoints(comm, a, b); });
  EXPECT_NE(sentence.find("the particle id 7 occurs twice"), std::string::npos) << sentence;
}

}  // namespace
}  // namespace bulkley::checkpoint_mpi_test
