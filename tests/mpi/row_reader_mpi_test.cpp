// ranks: 1 3
// Rows of arrays at places that the root has found.
#include <gtest/gtest.h>

#include <cstring>

#include "io/arrays/array_file.hpp"
#include "support/io_particles.hpp"

namespace bulkley::row_reader_mpi_test {
namespace {

constexpr GlobalIndex n_rows = 1000;

class Rows : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  SharedFolder folder{comm};

  // Row r is {r, r + 1/4}.
  std::string write(int deflate_level) {
    const EvenShare share = even_share(comm, n_rows);
    Array array{"/data/rows", ArrayType::float64, {n_rows, 2}, {share.first, 0}, {share.count(), 2}, "1", "", {}};
    array.fill = [first_row = share.first](GlobalIndex first, GlobalIndex n, std::byte* out) {
      for (GlobalIndex value = 2 * first; value < 2 * (first + n); ++value, out += sizeof(double)) {
        const double number = static_cast<double>(first_row + value / 2) + 0.25 * static_cast<double>(value % 2);
        std::memcpy(out, &number, sizeof number);
      }
    };
    const std::string file = folder.file("a.h5");
    write_array_file(comm, file, {"bulkley test", 1, {}, {array}, deflate_level});
    return file;
  }
  static std::vector<std::string> all(const Hdf5Reader&) { return {"/data/rows"}; }
  int n_wrong(const std::string& file, const StoredArray& array) {
    int wrong = 0;
    const GlobalIndex first = 10 * comm.rank();
    RowReader reader(file);
    const Piece piece = reader.read(array, first, 500, [&](GlobalIndex row, GlobalIndex n, const std::byte* rows) {
      for (GlobalIndex r = 0; r < n; ++r) {
        double number[2];
        std::memcpy(number, rows + static_cast<std::size_t>(r) * sizeof number, sizeof number);
        const auto expected = static_cast<double>(first + row + r);
        wrong += number[0] != expected || number[1] != expected + 0.25;
      }
    });
    EXPECT_EQ(piece.bytes, 500 * 16);
    return wrong;
  }
  // As if HDF5 had never seen the file.
  void destroy_structure(const std::string& file) {
    BULKLEY_MPI(MPI_Barrier(comm.get()));  // after all have read
    root_guard(comm, [&] {
      std::string bytes = whole_file(file);
      bytes.replace(0, 16, 16, '\0');
      replace_file(file, bytes);
    });
  }
};

TEST_F(Rows, AreReadPastHdf5) {
  const std::string file = write(0);
  const std::vector<StoredArray> arrays = find_arrays(comm, file, all);
  ASSERT_EQ(arrays.size(), 1u);
  EXPECT_EQ(arrays[0].info.path, "/data/rows");
  EXPECT_EQ(arrays[0].info.shape, (Extents{n_rows, 2}));
  EXPECT_EQ(arrays[0].info.type, ArrayType::float64);
  EXPECT_GT(arrays[0].place, 0);
  EXPECT_EQ(n_wrong(file, arrays[0]), 0);
  destroy_structure(file);
  EXPECT_EQ(n_wrong(file, arrays[0]), 0);
  EXPECT_NE(sentence_of<RunError>([&] { find_arrays(comm, file, all); }).find("it is not an HDF5 file"), std::string::npos);
}

TEST_F(Rows, OfCompressedArraysAreReadWithHdf5) {
  const std::string file = write(1);
  const std::vector<StoredArray> arrays = find_arrays(comm, file, all);
  EXPECT_EQ(arrays.at(0).place, -1);
  EXPECT_EQ(n_wrong(file, arrays[0]), 0);
  destroy_structure(file);
  EXPECT_NE(sentence_of<RunError>([&] { n_wrong(file, arrays[0]); }).find("it is not an HDF5 file"), std::string::npos);
}

TEST_F(Rows, BeyondTheEndAreAnError) {
  const std::string file = write(0);
  const std::vector<StoredArray> arrays = find_arrays(comm, file, all);
  GlobalIndex end = 0;
  root_guard(comm, [&] {
    end = arrays[0].place + 16 * (n_rows - 1);
    replace_file(file, whole_file(file).substr(0, static_cast<std::size_t>(end)));
  });
  const std::string sentence = sentence_of<RunError>([&] {
    RowReader reader(file);
    reader.read(arrays[0], 0, n_rows, [](GlobalIndex, GlobalIndex, const std::byte*) {});
  });
  EXPECT_EQ(sentence, fmt::format("cannot read '{}': it is damaged (it ends at {} bytes)", file, max_global(comm, end)));
}

}  // namespace
}  // namespace bulkley::row_reader_mpi_test
