// VTK's HDF5 file of an unstructured grid, version 1.0: a vertex for each particle.

#include <algorithm>
#include <cstring>
#include <numeric>

#include "io/arrays/array_file.hpp"
#include "io/convert/selected_rows.hpp"

namespace bulkley {

namespace {

/// An array of `n_total` rows, of which this rank has `count` from `first` on.
Array array_of(const std::string& name, ArrayType type, GlobalIndex n_total, GlobalIndex first, GlobalIndex count,
               const std::string& meaning) {
  Array array;
  array.path = "/VTKHDF/" + name;
  array.type = type;
  array.shape = {n_total};
  array.start = {first};
  array.count = {count};
  array.meaning = meaning;
  return array;
}

Array column_array(const Share& share, const Column& column, const std::string& name) {
  Array array = array_of(name, column.array.type, share.total, share.first, share.rows.count(), column.name);
  array.unit = column.unit;
  if (column.n_components > 1) {  // the reader supports at most two axes
    array.shape.push_back(column.n_components);
    array.start.push_back(0);
    array.count.push_back(column.n_components);
  }
  array.fill = [&share, &column](GlobalIndex first, GlobalIndex n, std::byte* out) {
    share.rows.read(column, first, n, out);
  };
  return array;
}

/// `n_total` numbers that count up from 0.
Array counting_array(const std::string& name, GlobalIndex n_total, GlobalIndex first, GlobalIndex count) {
  Array array = array_of(name, ArrayType::int64, n_total, first, count, "one vertex a particle");
  array.fill = [begin = first](GlobalIndex at, GlobalIndex n, std::byte* out) {
    auto* numbers = reinterpret_cast<GlobalIndex*>(out);
    std::iota(numbers, numbers + n, begin + at);
  };
  return array;
}

template <class Number>
Array single_value(const Comm& comm, const std::string& name, ArrayType type, Number value, const std::string& meaning) {
  Array array = array_of(name, type, 1, 0, comm.is_root() ? 1 : 0, meaning);
  array.fill = [value](GlobalIndex, GlobalIndex, std::byte* out) { std::memcpy(out, &value, sizeof value); };
  return array;
}

}  // namespace

void write_vtkhdf(const Comm& comm, const std::string& path, const Share& share) {
  const GlobalIndex count = share.rows.count(), total = share.total;
  const bool is_last = comm.rank() + 1 == comm.size();
  FileContent content{"bulkley conversion", 1, {}, {}, 0};
  content.attributes = {{"/", "step", share.snapshot.step},
                        {"/", "time", share.snapshot.time},
                        {"/VTKHDF", "Version", std::vector<GlobalIndex>{1, 0}},
                        {"/VTKHDF", "Type", AsciiText{"UnstructuredGrid"}}};
  for (const char* name : {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"})
    content.arrays.push_back(single_value(comm, name, ArrayType::int64, total, "one vertex a particle"));
  content.arrays.push_back(column_array(share, share.snapshot.position, "Points"));
  content.arrays.push_back(counting_array("Connectivity", total, share.first, count));
  content.arrays.push_back(counting_array("Offsets", total + 1, share.first, count + (is_last ? 1 : 0)));
  Array types = array_of("Types", ArrayType::uint8, total, share.first, count, "VTK_VERTEX");
  types.fill = [](GlobalIndex, GlobalIndex n, std::byte* out) { std::fill_n(out, n, std::byte{vtk_vertex}); };
  content.arrays.push_back(std::move(types));
  for (const Column& column : share.snapshot.fields)
    content.arrays.push_back(column_array(share, column, "PointData/" + column.name));
  content.arrays.push_back(single_value(comm, "FieldData/TimeValue", ArrayType::float64, share.snapshot.time, "s"));
  write_array_file(comm, path, content);
}

}  // namespace bulkley
