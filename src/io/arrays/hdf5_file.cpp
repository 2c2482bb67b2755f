#include "io/arrays/hdf5_file.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "io/arrays/hdf5_types.hpp"

namespace bulkley {

namespace {

struct TypeName {
  ArrayType type;
  const char* name;
  std::size_t size;
};
constexpr TypeName types[] = {{ArrayType::float32, "float32", 4},
                              {ArrayType::float64, "float64", 8},
                              {ArrayType::int32, "int32", 4},
                              {ArrayType::int64, "int64", 8},
                              {ArrayType::uint8, "uint8", 1}};

herr_t keep_innermost(unsigned depth, const H5E_error2_t* error, void* reason) {
  if (depth == 0) *static_cast<std::string*>(reason) = error->desc;
  return 0;
}

}  // namespace

hid_t hdf5_type(ArrayType type) {
  switch (type) {
    case ArrayType::float32:
      return H5T_IEEE_F32LE;
    case ArrayType::float64:
      return H5T_IEEE_F64LE;
    case ArrayType::int32:
      return H5T_STD_I32LE;
    case ArrayType::int64:
      return H5T_STD_I64LE;
    case ArrayType::uint8:
      return H5T_STD_U8LE;
  }
  return H5I_INVALID_HID;
}

HdfSpace make_space(const Extents& shape) {
  if (shape.empty()) return HdfSpace(BULKLEY_HDF5(H5Screate(H5S_SCALAR)));
  const std::vector<hsize_t> extents(shape.begin(), shape.end());
  return HdfSpace(BULKLEY_HDF5(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr)));
}

void select_block(hid_t space, const Extents& start, const Extents& count, const std::string& what) {
  const std::vector<hsize_t> first(start.begin(), start.end()), extent(count.begin(), count.end());
  BULKLEY_HDF5_LOCAL(what, H5Sselect_hyperslab(space, H5S_SELECT_SET, first.data(), nullptr, extent.data(), nullptr));
}

void abort_for_hdf5(const char* call, const char* file, int line) {
  abort_all_ranks(fmt::format("{} failed: {}", call, hdf5_reason()), file, line);
}

void throw_for_hdf5(const std::string& what) { throw RunError(fmt::format("{}: {}", what, hdf5_reason())); }

void silence_hdf5() { BULKLEY_HDF5(H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr)); }

std::string hdf5_reason() {
  std::string reason = "HDF5 gave no reason";
  BULKLEY_HDF5(H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &reason));
  // A failed system call is reported in two lines with time, buffer and sizes; its own text is enough.
  const std::string begin = "error message = '";
  if (const std::size_t at = reason.find(begin); at != std::string::npos) {
    const std::size_t words = at + begin.size();
    return reason.substr(words, reason.find('\'', words) - words);
  }
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return reason;
}

std::size_t element_size(ArrayType type) { return types[static_cast<std::size_t>(type)].size; }
const char* name(ArrayType type) { return types[static_cast<std::size_t>(type)].name; }

std::string part_name(const std::string& name, int part) { return part == 1 ? name : fmt::format("{}_{}", name, part); }

GlobalIndex n_elements(const Extents& shape) {
  GlobalIndex n = 1;
  for (const GlobalIndex extent : shape) n *= extent;
  return n;
}

}  // namespace bulkley
