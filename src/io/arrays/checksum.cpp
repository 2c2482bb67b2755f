#include "io/arrays/checksum.hpp"

#include <algorithm>

#include "parallel/gather.hpp"

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
struct Run {
  GlobalIndex offset, length, crc;
};
}  // namespace

std::uint32_t combine_runs(const Comm& comm, const Runs& runs, const std::vector<std::uint32_t>& crcs) {
  std::vector<Run> mine;
  for (std::size_t i = 0; i < runs.offsets.size(); ++i) mine.push_back({runs.offsets[i], runs.length, crcs[i]});

  std::vector<Run> all = gather_values(comm, mine);
  std::sort(all.begin(), all.end(), [](const Run& a, const Run& b) { return a.offset < b.offset; });

  std::uint32_t crc = 0;
  for (const Run& run : all)
    crc = static_cast<std::uint32_t>(crc32_combine(crc, static_cast<std::uint32_t>(run.crc), run.length));
  BULKLEY_MPI(MPI_Bcast(&crc, 1, MPI_UINT32_T, 0, comm.get()));
  return crc;
}

}  // namespace bulkley
