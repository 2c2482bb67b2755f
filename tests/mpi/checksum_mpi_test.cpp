// ranks: 1 2 5
#include "io/arrays/checksum.hpp"

#include <gtest/gtest.h>

#include "support/io_particles.hpp"

namespace bulkley::checksum_mpi_test {
namespace {

std::vector<std::byte> some_bytes(GlobalIndex n) {
  std::vector<std::byte> bytes;
  for (GlobalIndex i = 0; i < n; ++i) bytes.push_back(static_cast<std::byte>(bits_of(i, 0) >> 20));
  return bytes;
}

std::uint32_t crc_of(const std::vector<std::byte>& bytes) { return bulkley::crc_of(bytes.data(), bytes.size()); }

// Columns of ranks in steps of unequal width, the runs of each scattered over the array; rank 1 has none.
TEST(Checksum, OfBlocksIsThatOfTheWholeArray) {
  const Comm comm(PETSC_COMM_WORLD);
  const GlobalIndex n_z = 3, n_y = 4, width = comm.size() * (comm.size() + 1) / 2,
                    first = comm.rank() * (comm.rank() + 1) / 2;
  const Extents shape{n_z, n_y, width};
  const bool empty = comm.rank() == 1, takes_more = comm.size() > 1 && comm.rank() == 0;
  Array array{
      "/block", ArrayType::float64, shape, {0, 0, first}, {empty ? 0 : n_z, n_y, takes_more ? 3 : comm.rank() + 1}, "1", "",
      {}};
  const std::vector<std::byte> whole = some_bytes(stored_bytes(array));
  const Runs runs = runs_of(array);
  std::vector<std::uint32_t> crcs;
  for (const GlobalIndex offset : runs.offsets)
    crcs.push_back(bulkley::crc_of(whole.data() + offset, static_cast<std::size_t>(runs.length)));
  std::vector<std::uint32_t> parts{crc_part(runs, crcs, stored_bytes(array)), 0};
  combine_parts(comm, parts);
  EXPECT_EQ(parts, (std::vector<std::uint32_t>{crc_of(whole), 0}));
}

TEST(Checksum, OfPiecesInRankOrderIsThatOfTheWholeArray) {
  const Comm comm(PETSC_COMM_WORLD);
  std::vector<Piece> pieces;
  std::vector<std::uint32_t> expected;
  for (const GlobalIndex n : {0, 1, 3, 1000}) {
    const std::vector<std::byte> whole = some_bytes(n);
    const EvenShare share = even_share(comm, n);
    pieces.push_back({bulkley::crc_of(whole.data() + share.first, static_cast<std::size_t>(share.count())), share.count()});
    expected.push_back(crc_of(whole));
  }
  EXPECT_EQ(combine_pieces(comm, pieces), expected);
}

}  // namespace
}  // namespace bulkley::checksum_mpi_test
