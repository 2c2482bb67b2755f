// VTK's XML file of an unstructured grid: a vertex for each particle, the arrays raw behind the XML, each after its size.

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "io/convert/selected_rows.hpp"
#include "io/files/placed_file.hpp"

namespace bulkley {

namespace {

constexpr const char* footer = "\n  </AppendedData>\n</VTKFile>\n";

/// An array behind the XML; `fill` gives the bytes of rows [first, first + n) of this rank.
struct Block {
  std::string name;
  const char* type;
  int n_components;
  GlobalIndex row_bytes;
  std::function<void(GlobalIndex first, GlobalIndex n, std::byte* out)> fill;
};

const char* vtk_type(ArrayType type) {
  switch (type) {
    case ArrayType::float32:
      return "Float32";
    case ArrayType::float64:
      return "Float64";
    case ArrayType::int32:
      return "Int32";
    case ArrayType::int64:
      return "Int64";
    case ArrayType::uint8:
      return "UInt8";
  }
  return "";
}

Block block_of(const Share& share, const Column& column) {
  return {column.name, vtk_type(column.array.type), column.n_components, column.row_bytes(),
          [&share, &column](GlobalIndex first, GlobalIndex n, std::byte* out) { share.rows.read(column, first, n, out); }};
}

/// Points, cells, then the fields.
std::vector<Block> blocks_of(const Share& share) {
  const auto numbers_from = [](GlobalIndex begin) {
    return [begin](GlobalIndex first, GlobalIndex n, std::byte* out) {
      auto* numbers = reinterpret_cast<GlobalIndex*>(out);
      std::iota(numbers, numbers + n, begin + first);
    };
  };
  std::vector<Block> blocks{block_of(share, share.snapshot.position),
                            {"connectivity", "Int64", 1, sizeof(GlobalIndex), numbers_from(share.first)},
                            {"offsets", "Int64", 1, sizeof(GlobalIndex), numbers_from(share.first + 1)},
                            {"types", "UInt8", 1, 1, [](GlobalIndex, GlobalIndex n, std::byte* out) {
                               std::fill_n(out, n, std::byte{vtk_vertex});
                             }}};
  for (const Column& column : share.snapshot.fields) blocks.push_back(block_of(share, column));
  return blocks;
}

/// The offset of the size of each array, from the beginning of the data, and the end of all.
std::vector<GlobalIndex> offsets_of(const std::vector<Block>& blocks, GlobalIndex n_rows) {
  std::vector<GlobalIndex> offsets{0};
  for (const Block& block : blocks)
    offsets.push_back(offsets.back() + static_cast<GlobalIndex>(sizeof(std::uint64_t)) + n_rows * block.row_bytes);
  return offsets;
}

std::string element(const Block& block, GlobalIndex offset) {
  return fmt::format(
      "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
      block.type, block.name, block.n_components, offset);
}

std::string head_of(const Share& share, const std::vector<Block>& blocks, const std::vector<GlobalIndex>& offsets) {
  std::string points, cells, fields;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    (i == 0 ? points : i < 4 ? cells : fields) += element(blocks[i], offsets[i]);
  return fmt::format(R"(<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
  <UnstructuredGrid>
    <FieldData>
      <DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{}</DataArray>
      <DataArray type="Int64" Name="Step" NumberOfTuples="1" format="ascii">{}</DataArray>
    </FieldData>
    <Piece NumberOfPoints="{}" NumberOfCells="{}">
      <Points>
{}      </Points>
      <Cells>
{}      </Cells>
      <PointData>
{}      </PointData>
    </Piece>
  </UnstructuredGrid>
  <AppendedData encoding="raw">
   _)",
                     share.snapshot.time, share.snapshot.step, share.total, share.total, points, cells, fields);
}

void write_block(const PlacedFile& file, const Block& block, GlobalIndex place, const Share& share) {
  const GlobalIndex count = share.rows.count(), step = std::min(rows_at_a_time(block.row_bytes), count);
  std::vector<std::byte> rows(static_cast<std::size_t>(step * block.row_bytes));
  for (GlobalIndex first = 0; first < count; first += step) {
    const GlobalIndex n = std::min(step, count - first);
    block.fill(first, n, rows.data());
    file.write(rows.data(), n * block.row_bytes, place + (share.first + first) * block.row_bytes);
  }
}

}  // namespace

void write_vtu(const Comm& comm, const std::string& path, const Share& share) {
  const std::vector<Block> blocks = blocks_of(share);
  const std::vector<GlobalIndex> offsets = offsets_of(blocks, share.total);
  const std::string head = head_of(share, blocks, offsets), foot = footer;
  const auto data_begin = static_cast<GlobalIndex>(head.size());
  const GlobalIndex data_end = data_begin + offsets.back();
  write_in_places(comm, path, data_end + static_cast<GlobalIndex>(foot.size()), [&](const PlacedFile& file) {
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const GlobalIndex place = data_begin + offsets[i];
      const auto size = static_cast<std::uint64_t>(share.total * blocks[i].row_bytes);
      if (comm.is_root()) file.write(&size, sizeof size, place);
      write_block(file, blocks[i], place + static_cast<GlobalIndex>(sizeof size), share);
    }
    if (!comm.is_root()) return;
    file.write(head.data(), data_begin, 0);
    file.write(foot.data(), static_cast<GlobalIndex>(foot.size()), data_end);
  });
}

}  // namespace bulkley
