#include "io/arrays/checksum.hpp"

#include <algorithm>

namespace bulkley {

Runs runs_of(const Array& array) {
  Runs runs;
  if (n_elements(array.count) == 0) return runs;
  // Axes from `axis` on are covered in full, so one run spans them and the block's extent along the axis before them.
  std::size_t axis = array.shape.size() - 1;
  GlobalIndex stride = static_cast<GlobalIndex>(element_size(array.type));
  while (axis > 0 && array.count[axis] == array.shape[axis]) stride *= array.shape[axis--];
  runs.length = stride * array.count[axis];

  std::vector<GlobalIndex> strides(array.shape.size(), stride);
  for (std::size_t a = axis; a > 0; --a) strides[a - 1] = strides[a] * array.shape[a];
  Extents index = array.start;
  for (GlobalIndex left = n_elements(Extents(array.count.begin(), array.count.begin() + static_cast<std::ptrdiff_t>(axis)));
       left > 0; --left) {
    GlobalIndex offset = 0;
    for (std::size_t a = 0; a <= axis; ++a) offset += index[a] * strides[a];
    runs.offsets.push_back(offset);
    for (std::size_t a = axis; a > 0; --a) {  // the next run, last axis fastest
      if (++index[a - 1] < array.start[a - 1] + array.count[a - 1]) break;
      index[a - 1] = array.start[a - 1];
    }
  }
  return runs;
}

void RunChecksums::add(const std::byte* data, GlobalIndex bytes) {
  while (bytes > 0) {
    if (filled_ == 0) values_.push_back(0);
    const GlobalIndex n = std::min(bytes, run_length_ - filled_);
    values_.back() = crc_of(data, static_cast<std::size_t>(n), values_.back());
    filled_ = (filled_ + n) % run_length_;
    data += n;
    bytes -= n;
  }
}

namespace {

/// A CRC is linear, and zlib's crc32_combine(a, b, n) is b XOR a moved by n bytes.
std::uint32_t moved(std::uint32_t crc, GlobalIndex bytes) {
  return static_cast<std::uint32_t>(crc32_combine(crc, 0, bytes));
}

}  // namespace

std::uint32_t crc_part(const Runs& runs, const std::vector<std::uint32_t>& crcs, GlobalIndex array_bytes) {
  std::uint32_t part = 0;
  for (std::size_t i = 0; i < crcs.size(); ++i) part ^= moved(crcs[i], array_bytes - runs.offsets[i] - runs.length);
  return part;
}

void combine_parts(const Comm& comm, std::vector<std::uint32_t>& parts) {
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, parts.data(), static_cast<int>(parts.size()), MPI_UINT32_T, MPI_BXOR, comm.get()));
}

std::vector<std::uint32_t> combine_pieces(const Comm& comm, std::span<const Piece> pieces) {
  std::vector<GlobalIndex> behind;  // bytes of this rank's pieces and of those behind
  for (const Piece& piece : pieces) behind.push_back(piece.bytes);
  const int n = static_cast<int>(behind.size());
  std::vector<GlobalIndex> up_to_mine(behind.size());
  BULKLEY_MPI(MPI_Scan(behind.data(), up_to_mine.data(), n, MPI_INT64_T, MPI_SUM, comm.get()));
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, behind.data(), n, MPI_INT64_T, MPI_SUM, comm.get()));
  std::vector<std::uint32_t> crcs;
  for (std::size_t i = 0; i < pieces.size(); ++i) crcs.push_back(moved(pieces[i].crc, behind[i] - up_to_mine[i]));
  combine_parts(comm, crcs);
  return crcs;
}

}  // namespace bulkley
