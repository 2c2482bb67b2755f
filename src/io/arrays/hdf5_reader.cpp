#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "io/arrays/hdf5_types.hpp"

namespace bulkley {

namespace {

// Called back by HDF5.
herr_t collect_link(hid_t, const char* name, const H5L_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}
herr_t collect_attribute(hid_t, const char* name, const H5A_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

double size_of_file(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  return error ? 0.0 : static_cast<double>(size);
}

/// Whether an array of this shape can be read plane by plane. It may be larger than the file, where nothing was written to
/// it.
bool is_possible(const std::vector<hsize_t>& extents, double element_bytes, double file_bytes) {
  constexpr double small_plane = 1 << 24, most_bytes = 0x1p62;
  double plane = element_bytes;
  for (std::size_t axis = 1; axis < extents.size(); ++axis) plane *= static_cast<double>(extents[axis]);
  const double whole = extents.empty() ? plane : plane * static_cast<double>(extents[0]);
  return whole < most_bytes && plane < most_bytes && (plane <= small_plane || plane <= file_bytes);
}

}  // namespace

Hdf5Reader::Hdf5Reader(const std::string& path) : path_(path) {
  silence_hdf5();
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) fail("there is no such file");
  if (!std::filesystem::is_regular_file(status)) fail("it is not a file");
  if (std::filesystem::file_size(path, error) == 0) fail("it is empty");
  const std::string what = fmt::format("cannot read '{}'", path);
  // It may be removed or renamed at any time; then it is not damaged, but gone.
  const auto opened = [&](auto result) {
    if (result < 0 && !std::filesystem::exists(path, error)) fail("there is no such file");
    return result;
  };
  if (BULKLEY_HDF5_LOCAL(what, opened(H5Fis_hdf5(path.c_str()))) == 0) fail("it is not an HDF5 file");
  const HdfList access(BULKLEY_HDF5(H5Pcreate(H5P_FILE_ACCESS)));
  // Locks are for concurrent writers, and some cluster file systems have none.
  BULKLEY_HDF5(H5Pset_file_locking(access.get(), false, true));
  file_ = HdfFile(BULKLEY_HDF5_LOCAL(damaged("it"), opened(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()))));
}

void Hdf5Reader::fail(const std::string& fault) const { throw RunError(fmt::format("cannot read '{}': {}", path_, fault)); }

std::string Hdf5Reader::damaged(const std::string& what) const {
  return fmt::format("cannot read '{}': {} is damaged", path_, what);
}

bool Hdf5Reader::has(const std::string& object) const {
  // Every group on the way is checked in turn: HDF5 fails on a missing one.
  for (std::size_t end = object.find('/', 1);; end = object.find('/', end + 1)) {
    const std::string part = object.substr(0, end);
    if (BULKLEY_HDF5_LOCAL(damaged(part), H5Lexists(file_.get(), part.c_str(), H5P_DEFAULT)) == 0) return false;
    if (end == std::string::npos) return true;
  }
}

bool Hdf5Reader::has_attribute(const std::string& object, const std::string& name) const {
  return BULKLEY_HDF5_LOCAL(damaged(object), H5Aexists_by_name(file_.get(), object.c_str(), name.c_str(), H5P_DEFAULT)) > 0;
}

AttributeValue Hdf5Reader::attribute(const std::string& object, const std::string& name) const {
  if (!has_attribute(object, name)) fail(fmt::format("attribute '{}' of {} is missing", name, object));
  const std::string what = damaged(fmt::format("attribute '{}' of {}", name, object));
  const HdfAttribute attribute(
      BULKLEY_HDF5_LOCAL(what, H5Aopen_by_name(file_.get(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT)));
  const HdfType type(BULKLEY_HDF5_LOCAL(what, H5Aget_type(attribute.get())));
  const HdfSpace space(BULKLEY_HDF5_LOCAL(what, H5Aget_space(attribute.get())));
  const hssize_t n = BULKLEY_HDF5_LOCAL(what, H5Sget_simple_extent_npoints(space.get()));
  const bool scalar = BULKLEY_HDF5_LOCAL(what, H5Sget_simple_extent_type(space.get())) == H5S_SCALAR;
  const H5T_class_t kind = BULKLEY_HDF5_LOCAL(what, H5Tget_class(type.get()));

  // Before memory is taken: a corrupted size may be anything.
  const double bytes = static_cast<double>(n) * static_cast<double>(BULKLEY_HDF5_LOCAL(what, H5Tget_size(type.get())));
  if (!(bytes >= 0.0 && bytes <= size_of_file(path_)))
    fail(fmt::format("attribute '{}' of {} is damaged (its size)", name, object));
  AttributeValue value;
  if (scalar && kind == H5T_INTEGER) {
    BULKLEY_HDF5_LOCAL(what, H5Aread(attribute.get(), H5T_NATIVE_INT64, &value.emplace<GlobalIndex>()));
  } else if (scalar && kind == H5T_FLOAT) {
    BULKLEY_HDF5_LOCAL(what, H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &value.emplace<double>()));
  } else if (scalar && kind == H5T_STRING && BULKLEY_HDF5_LOCAL(what, H5Tis_variable_str(type.get())) == 0) {
    auto& text = value.emplace<std::string>(BULKLEY_HDF5_LOCAL(what, H5Tget_size(type.get())), '\0');
    BULKLEY_HDF5_LOCAL(what, H5Aread(attribute.get(), type.get(), text.data()));
    text.resize(std::min(text.find('\0'), text.size()));
  } else if (!scalar && kind == H5T_INTEGER) {
    auto& integers = value.emplace<std::vector<GlobalIndex>>(static_cast<std::size_t>(n));
    BULKLEY_HDF5_LOCAL(what, H5Aread(attribute.get(), H5T_NATIVE_INT64, integers.data()));
  } else if (!scalar && kind == H5T_FLOAT) {
    auto& reals = value.emplace<std::vector<double>>(static_cast<std::size_t>(n));
    BULKLEY_HDF5_LOCAL(what, H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, reals.data()));
  } else {
    fail(fmt::format("attribute '{}' of {} has a type that does not belong here", name, object));
  }
  return value;
}

template <class Value>
Value Hdf5Reader::attribute_as(const std::string& object, const std::string& name, const char* kind) const {
  const AttributeValue value = attribute(object, name);
  if (!std::holds_alternative<Value>(value)) fail(fmt::format("attribute '{}' of {} is not {}", name, object, kind));
  return std::get<Value>(value);
}

GlobalIndex Hdf5Reader::integer(const std::string& object, const std::string& name) const {
  return attribute_as<GlobalIndex>(object, name, "an integer");
}
double Hdf5Reader::real(const std::string& object, const std::string& name) const {
  return attribute_as<double>(object, name, "a number");
}
std::string Hdf5Reader::text(const std::string& object, const std::string& name) const {
  std::string text = attribute_as<std::string>(object, name, "text");
  for (int part = 2; has_attribute(object, part_name(name, part)); ++part)
    text += attribute_as<std::string>(object, part_name(name, part), "text");
  return text;
}
std::vector<double> Hdf5Reader::reals(const std::string& object, const std::string& name) const {
  return attribute_as<std::vector<double>>(object, name, "a list of numbers");
}

std::vector<GlobalIndex> Hdf5Reader::integers(const std::string& object, const std::string& name) const {
  return attribute_as<std::vector<GlobalIndex>>(object, name, "a list of integers");
}

std::vector<std::string> Hdf5Reader::attribute_names(const std::string& object) const {
  std::vector<std::string> names;
  BULKLEY_HDF5_LOCAL(damaged(object), H5Aiterate_by_name(file_.get(), object.c_str(), H5_INDEX_NAME, H5_ITER_INC, nullptr,
                                                         collect_attribute, &names, H5P_DEFAULT));
  return names;
}

std::vector<std::string> Hdf5Reader::members(const std::string& group) const {
  std::vector<std::string> names;
  BULKLEY_HDF5_LOCAL(damaged(group), H5Literate_by_name(file_.get(), group.c_str(), H5_INDEX_NAME, H5_ITER_INC, nullptr,
                                                        collect_link, &names, H5P_DEFAULT));
  return names;
}

ArrayInfo Hdf5Reader::array(const std::string& path) const {
  if (!has(path)) fail(fmt::format("{} is missing", path));
  const std::string what = damaged(path);
  const HdfDataset dataset(BULKLEY_HDF5_LOCAL(what, H5Dopen2(file_.get(), path.c_str(), H5P_DEFAULT)));
  const HdfSpace space(BULKLEY_HDF5_LOCAL(what, H5Dget_space(dataset.get())));
  const HdfType type(BULKLEY_HDF5_LOCAL(what, H5Dget_type(dataset.get())));
  std::vector<hsize_t> extents(static_cast<std::size_t>(BULKLEY_HDF5_LOCAL(what, H5Sget_simple_extent_ndims(space.get()))));
  BULKLEY_HDF5_LOCAL(what, H5Sget_simple_extent_dims(space.get(), extents.data(), nullptr));
  for (const ArrayType known :
       {ArrayType::float32, ArrayType::float64, ArrayType::int32, ArrayType::int64, ArrayType::uint8})
    if (BULKLEY_HDF5_LOCAL(what, H5Tequal(type.get(), hdf5_type(known))) > 0) {
      if (!is_possible(extents, static_cast<double>(element_size(known)), size_of_file(path_)))
        fail(fmt::format("{} is damaged (its shape is {})", path, fmt::join(extents, " x ")));
      return {path, known, Extents(extents.begin(), extents.end())};
    }
  fail(fmt::format("{} has an element type that does not belong here", path));
}

GlobalIndex Hdf5Reader::place(const ArrayInfo& array) const {
  const std::string what = damaged(array.path);
  const HdfList of_file(BULKLEY_HDF5_LOCAL(what, H5Fget_create_plist(file_.get())));
  hsize_t user_block = 0;
  BULKLEY_HDF5_LOCAL(what, H5Pget_userblock(of_file.get(), &user_block));
  const HdfDataset dataset(BULKLEY_HDF5_LOCAL(what, H5Dopen2(file_.get(), array.path.c_str(), H5P_DEFAULT)));
  const HdfList creation(BULKLEY_HDF5_LOCAL(what, H5Dget_create_plist(dataset.get())));
  if (user_block > 0 || H5Pget_layout(creation.get()) != H5D_CONTIGUOUS || H5Pget_external_count(creation.get()) != 0)
    return -1;
  const haddr_t place = H5Dget_offset(dataset.get());  // undefined where nothing has been written
  const double end = static_cast<double>(place) +
                     static_cast<double>(n_elements(array.shape)) * static_cast<double>(element_size(array.type));
  return place != HADDR_UNDEF && end <= size_of_file(path_) ? static_cast<GlobalIndex>(place) : -1;
}

void Hdf5Reader::read(const ArrayInfo& array, const Extents& start, const Extents& count, void* data) const {
  if (n_elements(count) == 0) return;
  const std::string what = damaged(array.path);
  const HdfDataset dataset(BULKLEY_HDF5_LOCAL(what, H5Dopen2(file_.get(), array.path.c_str(), H5P_DEFAULT)));
  const HdfSpace file_space(BULKLEY_HDF5_LOCAL(what, H5Dget_space(dataset.get())));
  const HdfSpace memory_space = make_space(count);
  select_block(file_space.get(), start, count, what);
  BULKLEY_HDF5_LOCAL(what,
                     H5Dread(dataset.get(), hdf5_type(array.type), memory_space.get(), file_space.get(), H5P_DEFAULT, data));
}

}  // namespace bulkley
