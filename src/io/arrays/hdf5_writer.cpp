#include <unistd.h>

#include <algorithm>

#include <fmt/format.h>

#include "io/arrays/hdf5_types.hpp"

namespace bulkley {

namespace {

HdfType text_type(std::size_t length, H5T_cset_t characters) {
  HdfType type(BULKLEY_HDF5(H5Tcopy(H5T_C_S1)));
  BULKLEY_HDF5(H5Tset_size(type.get(), std::max<std::size_t>(length, 1)));  // HDF5 has no strings of no length
  BULKLEY_HDF5(H5Tset_cset(type.get(), characters));
  BULKLEY_HDF5(H5Tset_strpad(type.get(), H5T_STR_NULLPAD));
  return type;
}

// Attributes and links stay in the object's header, which the file format protects by a checksum. Elsewhere it has none, and
// HDF5 crashes over a flipped bit in the table of a large group.
constexpr unsigned most_in_header = 65535;
constexpr std::size_t longest_text = 60000;        // bytes of one attribute in a header
constexpr hsize_t chunk_bytes = hsize_t{1} << 18;  // of a compressed array, before compression

HdfList creation_list(hid_t kind) {
  HdfList list(BULKLEY_HDF5(H5Pcreate(kind)));
  BULKLEY_HDF5(H5Pset_attr_phase_change(list.get(), most_in_header, most_in_header));
  BULKLEY_HDF5(H5Pset_obj_track_times(list.get(), false));  // the same content makes the same bytes
  return list;
}

HdfList group_creation_list(hid_t kind) {
  HdfList list = creation_list(kind);
  BULKLEY_HDF5(H5Pset_link_phase_change(list.get(), most_in_header, most_in_header));
  return list;
}

}  // namespace

Hdf5Writer::Hdf5Writer(const std::string& path, Mode mode) : path_(path) {
  silence_hdf5();
  const HdfList access(BULKLEY_HDF5(H5Pcreate(H5P_FILE_ACCESS)));
  // Locks are for concurrent writers, and some cluster file systems have none.
  BULKLEY_HDF5(H5Pset_file_locking(access.get(), false, true));
  // The format of HDF5 1.8 puts checksums on the metadata and is read by everything since.
  BULKLEY_HDF5(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_V18));
  if (mode == Mode::create) {
    const HdfList creation = group_creation_list(H5P_FILE_CREATE);
    file_ = HdfFile(BULKLEY_HDF5_LOCAL(what(), H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.get(), access.get())));
  } else {
    file_ = HdfFile(BULKLEY_HDF5_LOCAL(what(), H5Fopen(path.c_str(), H5F_ACC_RDWR, access.get())));
  }
}

std::string Hdf5Writer::what() const { return fmt::format("cannot write '{}'", path_); }

void Hdf5Writer::create_group(const std::string& path) {
  const HdfList links(BULKLEY_HDF5_LOCAL(what(), H5Pcreate(H5P_LINK_CREATE)));
  BULKLEY_HDF5_LOCAL(what(), H5Pset_create_intermediate_group(links.get(), 1));
  const HdfList creation = group_creation_list(H5P_GROUP_CREATE);
  const HdfGroup group(
      BULKLEY_HDF5_LOCAL(what(), H5Gcreate2(file_.get(), path.c_str(), links.get(), creation.get(), H5P_DEFAULT)));
}

void Hdf5Writer::set_attribute(const std::string& object, const std::string& name, const AttributeValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (!text || text->size() <= longest_text) return set_one_attribute(object, name, value);
  for (std::size_t start = 0, part = 1; start < text->size(); start += longest_text, ++part)
    set_one_attribute(object, part_name(name, static_cast<int>(part)), text->substr(start, longest_text));
}

void Hdf5Writer::set_one_attribute(const std::string& object, const std::string& name, const AttributeValue& value) {
  Extents shape;
  HdfType type;
  const void* data = nullptr;
  if (const auto* integer = std::get_if<GlobalIndex>(&value)) {
    type = HdfType(BULKLEY_HDF5_LOCAL(what(), H5Tcopy(H5T_STD_I64LE)));
    data = integer;
  } else if (const auto* real = std::get_if<double>(&value)) {
    type = HdfType(BULKLEY_HDF5_LOCAL(what(), H5Tcopy(H5T_IEEE_F64LE)));
    data = real;
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    type = text_type(text->size(), H5T_CSET_UTF8);
    data = text->c_str();
  } else if (const auto* ascii = std::get_if<AsciiText>(&value)) {
    type = text_type(ascii->text.size(), H5T_CSET_ASCII);
    data = ascii->text.c_str();
  } else if (const auto* integers = std::get_if<std::vector<GlobalIndex>>(&value)) {
    type = HdfType(BULKLEY_HDF5_LOCAL(what(), H5Tcopy(H5T_STD_I64LE)));
    shape = {static_cast<GlobalIndex>(integers->size())};
    data = integers->data();
  } else {
    const auto& reals = std::get<std::vector<double>>(value);
    type = HdfType(BULKLEY_HDF5_LOCAL(what(), H5Tcopy(H5T_IEEE_F64LE)));
    shape = {static_cast<GlobalIndex>(reals.size())};
    data = reals.data();
  }
  const HdfObject holder(BULKLEY_HDF5_LOCAL(what(), H5Oopen(file_.get(), object.c_str(), H5P_DEFAULT)));
  HdfAttribute attribute;
  if (BULKLEY_HDF5_LOCAL(what(), H5Aexists(holder.get(), name.c_str())) > 0) {
    attribute = HdfAttribute(BULKLEY_HDF5_LOCAL(what(), H5Aopen(holder.get(), name.c_str(), H5P_DEFAULT)));
  } else {
    const HdfSpace space = make_space(shape);
    attribute = HdfAttribute(BULKLEY_HDF5_LOCAL(
        what(), H5Acreate2(holder.get(), name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT)));
  }
  BULKLEY_HDF5_LOCAL(what(), H5Awrite(attribute.get(), type.get(), data));
}

GlobalIndex Hdf5Writer::create_array(const std::string& path, ArrayType type, const Extents& shape) {
  const HdfList creation = creation_list(H5P_DATASET_CREATE);
  BULKLEY_HDF5_LOCAL(what(), H5Pset_layout(creation.get(), H5D_CONTIGUOUS));
  BULKLEY_HDF5_LOCAL(what(), H5Pset_alloc_time(creation.get(), H5D_ALLOC_TIME_EARLY));
  BULKLEY_HDF5_LOCAL(what(), H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER));
  const HdfSpace space = make_space(shape);
  const HdfDataset dataset(BULKLEY_HDF5_LOCAL(what(), H5Dcreate2(file_.get(), path.c_str(), hdf5_type(type), space.get(),
                                                                 H5P_DEFAULT, creation.get(), H5P_DEFAULT)));
  if (n_elements(shape) == 0) return 0;  // has no place in the file
  const haddr_t place = H5Dget_offset(dataset.get());
  if (place == HADDR_UNDEF) throw_for_hdf5(what());
  return static_cast<GlobalIndex>(place);
}

void Hdf5Writer::create_compressed(const std::string& path, ArrayType type, const Extents& shape, int deflate_level) {
  std::vector<hsize_t> chunk(shape.begin(), shape.end());
  const auto row_bytes = static_cast<hsize_t>(n_elements(shape) / shape[0]) * element_size(type);
  chunk[0] = std::clamp<hsize_t>(chunk_bytes / row_bytes, 1, chunk[0]);
  const HdfList creation = creation_list(H5P_DATASET_CREATE);
  BULKLEY_HDF5_LOCAL(what(), H5Pset_chunk(creation.get(), static_cast<int>(chunk.size()), chunk.data()));
  BULKLEY_HDF5_LOCAL(what(), H5Pset_shuffle(creation.get()));
  BULKLEY_HDF5_LOCAL(what(), H5Pset_deflate(creation.get(), static_cast<unsigned>(deflate_level)));
  BULKLEY_HDF5_LOCAL(what(), H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER));
  const HdfSpace space = make_space(shape);
  const HdfDataset dataset(BULKLEY_HDF5_LOCAL(what(), H5Dcreate2(file_.get(), path.c_str(), hdf5_type(type), space.get(),
                                                                 H5P_DEFAULT, creation.get(), H5P_DEFAULT)));
}

void Hdf5Writer::write_block(const std::string& array, const Extents& start, const Extents& count, const void* data) {
  const HdfDataset dataset(BULKLEY_HDF5_LOCAL(what(), H5Dopen2(file_.get(), array.c_str(), H5P_DEFAULT)));
  const HdfSpace file_space(BULKLEY_HDF5_LOCAL(what(), H5Dget_space(dataset.get())));
  const HdfType type(BULKLEY_HDF5_LOCAL(what(), H5Dget_type(dataset.get())));
  const HdfSpace memory_space = make_space(count);
  select_block(file_space.get(), start, count, what());
  BULKLEY_HDF5_LOCAL(what(), H5Dwrite(dataset.get(), type.get(), memory_space.get(), file_space.get(), H5P_DEFAULT, data));
}

void Hdf5Writer::close() {
  BULKLEY_HDF5_LOCAL(what(), H5Fflush(file_.get(), H5F_SCOPE_GLOBAL));
  close_file();
}

Hdf5Writer::~Hdf5Writer() {
  if (file_) close_file();  // after a failure; what is in the file no longer matters
}

// HDF5 keeps a file open that it could not close, and crashes over it in MPI_Finalize: there is no way out in order.
void Hdf5Writer::close_file() {
  if (H5Fclose(file_.release()) >= 0) return;
  const std::string reason = hdf5_reason();
  ::unlink(path_.c_str());
  abort_all_ranks(fmt::format("{}: {}", what(), reason), __FILE__, __LINE__);
}

}  // namespace bulkley
