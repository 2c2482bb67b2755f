#include "io/arrays/array_file.hpp"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/arrays/checksum.hpp"
#include "io/files/placed_file.hpp"
#include "io/files/text_file.hpp"
#include "parallel/gather.hpp"

namespace bulkley {

namespace {

constexpr GlobalIndex portion = GlobalIndex{16} << 20;       // bytes in memory at a time
constexpr GlobalIndex metadata_room = GlobalIndex{1} << 20;  // bytes; headers of our files take some tens of KiB
static_assert(std::endian::native == std::endian::little, "values are written as they lie in memory");

/// What is being compressed; clean-ups look for names that end in ".packed.tmp", too.
std::string packed_name(const std::string& path) { return path + ".packed.tmp"; }

GlobalIndex plane_bytes(const Array& array) {
  GlobalIndex bytes = static_cast<GlobalIndex>(element_size(array.type));
  for (std::size_t axis = 1; axis < array.count.size(); ++axis) bytes *= array.count[axis];
  return bytes;
}

/// Calls `work(first, n, buffer)` for portions of the block's first axis.
void for_each_portion(GlobalIndex n_planes, GlobalIndex bytes_per_plane,
                      const std::function<void(GlobalIndex, GlobalIndex, std::byte*)>& work) {
  if (n_planes == 0 || bytes_per_plane == 0) return;
  const GlobalIndex step = std::clamp<GlobalIndex>(portion / bytes_per_plane, 1, n_planes);
  std::vector<std::byte> buffer(static_cast<std::size_t>(step * bytes_per_plane));
  for (GlobalIndex first = 0; first < n_planes; first += step) work(first, std::min(step, n_planes - first), buffer.data());
}

}  // namespace

GlobalIndex stored_bytes(const Array& array) {
  return n_elements(array.shape) * static_cast<GlobalIndex>(element_size(array.type));
}

namespace {

GlobalIndex size_on_disk(const FileContent& content) {
  GlobalIndex bytes = metadata_room;
  for (const Array& array : content.arrays) bytes += stored_bytes(array);
  for (const Attribute& attribute : content.attributes)
    if (const auto* text = std::get_if<std::string>(&attribute.value)) bytes += static_cast<GlobalIndex>(text->size());
  return bytes;
}

/// Where the values of each array begin. `deflate_level`: 0 for arrays as they are.
std::vector<GlobalIndex> create_structure(Hdf5Writer& file, const FileContent& content, int deflate_level) {
  std::vector<GlobalIndex> places;
  file.set_attribute("/", "format", content.format);
  file.set_attribute("/", "format_version", content.format_version);
  std::vector<std::string> groups{"/"};
  const auto need_group = [&](const std::string& path) {
    if (std::find(groups.begin(), groups.end(), path) != groups.end()) return;
    file.create_group(path);
    groups.push_back(path);
  };
  for (const Attribute& attribute : content.attributes) {
    need_group(attribute.object);
    file.set_attribute(attribute.object, attribute.name, attribute.value);
  }
  for (const Array& array : content.arrays) {
    const std::string parent = array.path.substr(0, array.path.rfind('/'));
    if (!parent.empty()) need_group(parent);
    if (deflate_level > 0 && n_elements(array.shape) > 0)
      file.create_compressed(array.path, array.type, array.shape, deflate_level);
    else
      places.push_back(file.create_array(array.path, array.type, array.shape));
    file.set_attribute(array.path, "unit", array.unit);
    file.set_attribute(array.path, "meaning", array.meaning);
    file.set_attribute(array.path, "crc32", GlobalIndex{0});  // takes its place now, its value after the data
  }
  return places;
}

/// The file with everything but the values of its arrays, and room for those. By one process.
std::vector<GlobalIndex> create_file(const std::string& temporary, const std::string& path, const FileContent& content) {
  const GlobalIndex bytes = size_on_disk(content);
  make_room(temporary, path, bytes);
  Hdf5Writer file(temporary, Hdf5Writer::Mode::create);
  std::vector<GlobalIndex> places = create_structure(file, content, 0);
  file.close();
  reserve(temporary, bytes);  // creating the file gave the room back
  return places;
}

/// Values of an array, from `place` on in an open file: a rank's runs, one after the other.
class RunWriter {
 public:
  RunWriter(const PlacedFile& file, GlobalIndex place, const Runs& runs) : file_(file), place_(place), runs_(runs) {}
  void add(const std::byte* data, GlobalIndex bytes) {
    while (bytes > 0) {
      const GlobalIndex n = std::min(bytes, runs_.length - filled_);
      file_.write(data, n, place_ + runs_.offsets[run_] + filled_);
      filled_ += n;
      if (filled_ == runs_.length) ++run_, filled_ = 0;
      data += n;
      bytes -= n;
    }
  }

 private:
  const PlacedFile& file_;
  GlobalIndex place_;
  const Runs& runs_;
  std::size_t run_ = 0;
  GlobalIndex filled_ = 0;  // bytes of the run
};

void write_block(const PlacedFile& file, GlobalIndex place, const Array& array, const Runs& runs, RunChecksums& checksums) {
  const GlobalIndex bytes = plane_bytes(array);
  RunWriter writer(file, place, runs);
  for_each_portion(array.count[0], bytes, [&](GlobalIndex first, GlobalIndex n, std::byte* buffer) {
    array.fill(first, n, buffer);
    checksums.add(buffer, n * bytes);
    writer.add(buffer, n * bytes);
  });
}

void expect_written(const std::string& path, const Array& array, const RunChecksums& read, const RunChecksums& written) {
  if (read.values() != written.values())
    throw RunError(fmt::format("'{}' does not hold what was written to it: {} reads back differently", path, array.path));
}

/// This rank's block of a compressed array.
RunChecksums read_back(const Hdf5Reader& file, const Array& array, const Runs& runs) {
  const ArrayInfo info = file.array(array.path);
  RunChecksums read(runs.length);
  const GlobalIndex bytes = plane_bytes(array);
  for_each_portion(array.count[0], bytes, [&](GlobalIndex first, GlobalIndex n, std::byte* buffer) {
    Extents start = array.start, count = array.count;
    start[0] += first;
    count[0] = n;
    file.read(info, start, count, buffer);
    read.add(buffer, n * bytes);
  });
  return read;
}

/// This rank's runs of an array that begins at `place`.
RunChecksums read_back(const PlacedReader& file, GlobalIndex place, const Runs& runs) {
  RunChecksums read(runs.length);
  std::vector<std::byte> buffer(static_cast<std::size_t>(std::min(portion, runs.length)));
  for (const GlobalIndex offset : runs.offsets)
    for (GlobalIndex done = 0; done < runs.length;) {
      const GlobalIndex n = std::min(portion, runs.length - done);
      file.read(buffer.data(), n, place + offset + done);
      read.add(buffer.data(), n);
      done += n;
    }
  return read;
}

/// By the root: HDF5 finds the arrays where the ranks have written them.
void expect_places(const std::string& path, const FileContent& content, const std::vector<GlobalIndex>& places) {
  const Hdf5Reader file(path);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Array& array = content.arrays[i];
    const ArrayInfo found = file.array(array.path);
    if (found.shape != array.shape || (n_elements(array.shape) > 0 && file.place(found) != places[i]))
      throw RunError(fmt::format("'{}' does not hold what was written to it: {} is elsewhere", path, array.path));
  }
}

void set_checksums(Hdf5Writer& file, const FileContent& content, const std::vector<std::uint32_t>& crcs) {
  for (std::size_t i = 0; i < content.arrays.size(); ++i)
    file.set_attribute(content.arrays[i].path, "crc32", GlobalIndex{crcs[i]});
}

/// Puts a file of compressed arrays in the place of one that is whole. By one process: HDF5 compresses in parallel only in calls
/// that hang where a rank cannot write.
void compress(const std::string& file, const std::string& packed, const FileContent& content,
              const std::vector<std::uint32_t>& crcs) {
  const Hdf5Reader from(file);
  Hdf5Writer to(packed, Hdf5Writer::Mode::create);
  create_structure(to, content, content.deflate_level);
  for (const Array& array : content.arrays) {
    if (n_elements(array.shape) == 0) continue;
    const ArrayInfo info = from.array(array.path);
    const GlobalIndex row_bytes =
        n_elements(array.shape) / array.shape[0] * static_cast<GlobalIndex>(element_size(array.type));
    for_each_portion(array.shape[0], row_bytes, [&](GlobalIndex first, GlobalIndex n, std::byte* buffer) {
      Extents start(array.shape.size(), 0), count = array.shape;
      start[0] = first;
      count[0] = n;
      from.read(info, start, count, buffer);
      to.write_block(array.path, start, count, buffer);
    });
  }
  set_checksums(to, content, crcs);
  to.close();
  if (::rename(packed.c_str(), file.c_str()) != 0)
    throw RunError(fmt::format("cannot write '{}': {}", file, std::strerror(errno)));
}

}  // namespace

void write_array_file(const Comm& comm, const std::string& path, const FileContent& content) {
  const std::string temporary = path + ".tmp";
  std::vector<Runs> runs;
  std::vector<RunChecksums> checksums;
  for (const Array& array : content.arrays) {
    runs.push_back(runs_of(array));
    checksums.emplace_back(runs.back().length);
  }
  try {
    std::vector<GlobalIndex> places(content.arrays.size());
    root_guard(comm, [&] { places = create_file(temporary, path, content); });
    broadcast_values(comm, places);
    collective_guard(comm, [&] {
      const PlacedFile file(temporary);
      for (std::size_t i = 0; i < content.arrays.size(); ++i)
        write_block(file, places[i], content.arrays[i], runs[i], checksums[i]);
      file.sync();
    });
    std::vector<std::uint32_t> crcs;
    for (std::size_t i = 0; i < content.arrays.size(); ++i)
      crcs.push_back(crc_part(runs[i], checksums[i].values(), stored_bytes(content.arrays[i])));
    combine_parts(comm, crcs);
    root_guard(comm, [&] {
      Hdf5Writer file(temporary, Hdf5Writer::Mode::change);
      set_checksums(file, content, crcs);
      file.close();
      if (content.deflate_level > 0)
        compress(temporary, packed_name(path), content, crcs);
      else
        expect_places(temporary, content, places);
    });
    collective_guard(comm, [&] {
      std::optional<Hdf5Reader> packed;
      std::optional<PlacedReader> plain;
      if (content.deflate_level > 0)
        packed.emplace(temporary);
      else
        plain.emplace(temporary);
      for (std::size_t i = 0; i < content.arrays.size(); ++i)
        expect_written(temporary, content.arrays[i],
                       packed ? read_back(*packed, content.arrays[i], runs[i]) : read_back(*plain, places[i], runs[i]),
                       checksums[i]);
    });
    root_guard(comm, [&] {
      sync_file(temporary);
      rename_durably(temporary, path);
    });
  } catch (const RunError&) {
    if (comm.is_root()) {
      ::unlink(temporary.c_str());
      ::unlink(packed_name(path).c_str());
    }
    throw;
  }
}

void check_format(const Hdf5Reader& file, const std::string& format, GlobalIndex newest_version) {
  const auto refuse = [&](const std::string& fault) {
    throw RunError(fmt::format("cannot read '{}': {}", file.path(), fault));
  };
  if (!file.has_attribute("/", "format") || !file.has_attribute("/", "format_version"))
    refuse(fmt::format("it is an HDF5 file, but not a {}", format));
  const std::string found = file.text("/", "format");
  if (found != format) refuse(fmt::format("it is a '{}', not a {}", found, format));
  const GlobalIndex version = file.integer("/", "format_version");
  if (version > newest_version)
    refuse(fmt::format("its format version is {}, and this program reads versions up to {}", version, newest_version));
  if (version < 1) refuse(fmt::format("its format version is {}, which never existed", version));
}

std::vector<StoredArray> find_arrays(const Comm& comm, const std::string& path,
                                     const std::function<std::vector<std::string>(const Hdf5Reader&)>& choose) {
  std::vector<std::string> lines;
  root_guard(comm, [&] {
    const Hdf5Reader file(path);
    for (const std::string& name : choose(file)) {
      const ArrayInfo info = file.array(name);
      if (name.find('\n') != std::string::npos)
        throw RunError(fmt::format("cannot read '{}': it is damaged (the name of an array has two lines)", path));
      lines.push_back(fmt::format("{} {} {} {} {} {}", static_cast<int>(info.type), file.place(info), stored_crc(file, name),
                                  info.shape.size(), fmt::join(info.shape, " "), name));
    }
  });
  std::vector<StoredArray> arrays;
  for (const std::string& line : split_lines(broadcast_text(comm, join_lines(lines)))) {
    std::istringstream text(line);
    StoredArray array;
    int type = 0;
    std::size_t n_axes = 0;
    text >> type >> array.place >> array.crc >> n_axes;
    array.info.type = static_cast<ArrayType>(type);
    array.info.shape.resize(n_axes);
    for (GlobalIndex& extent : array.info.shape) text >> extent;
    std::getline(text >> std::ws, array.info.path);
    arrays.push_back(std::move(array));
  }
  return arrays;
}

Piece RowReader::read(const StoredArray& array, GlobalIndex first, GlobalIndex n,
                      const std::function<void(GlobalIndex, GlobalIndex, const std::byte*)>& sink) {
  Piece piece;
  Extents start(array.info.shape.size(), 0), count = array.info.shape;
  count[0] = 1;
  const GlobalIndex row_bytes = n_elements(count) * static_cast<GlobalIndex>(element_size(array.info.type));
  for_each_portion(n, row_bytes, [&](GlobalIndex row, GlobalIndex n_rows, std::byte* buffer) {
    if (array.place >= 0) {
      if (!places_) places_.emplace(path_);
      places_->read(buffer, n_rows * row_bytes, array.place + (first + row) * row_bytes);
    } else {
      if (!file_) file_.emplace(path_);
      start[0] = first + row;
      count[0] = n_rows;
      file_->read(array.info, start, count, buffer);
    }
    piece.crc = crc_of(buffer, static_cast<std::size_t>(n_rows * row_bytes), piece.crc);
    piece.bytes += n_rows * row_bytes;
    sink(row, n_rows, buffer);
  });
  return piece;
}

std::uint32_t stored_crc(const Hdf5Reader& file, const std::string& array) {
  return static_cast<std::uint32_t>(file.integer(array, "crc32"));
}

Piece read_share(const Comm& comm, RowReader& reader, const StoredArray& array) {
  const EvenShare share = even_share(comm, array.info.shape.empty() ? 0 : array.info.shape[0]);
  return reader.read(array, share.first, share.count(), [](GlobalIndex, GlobalIndex, const std::byte*) {});
}

void check_pieces(const Comm& comm, const std::string& path, std::span<const StoredArray> arrays,
                  std::span<const Piece> pieces) {
  const std::vector<std::uint32_t> crcs = combine_pieces(comm, pieces);
  for (std::size_t i = 0; i < crcs.size(); ++i)
    if (crcs[i] != arrays[i].crc)
      throw RunError(fmt::format("cannot read '{}': {} is damaged (its checksum is {:08x} and should be {:08x})", path,
                                 arrays[i].info.path, crcs[i], arrays[i].crc));
}

void verify_arrays(const Comm& comm, const std::string& path, const std::vector<std::string>& names) {
  const std::vector<StoredArray> arrays = find_arrays(comm, path, [&](const Hdf5Reader&) { return names; });
  std::vector<Piece> pieces;
  collective_guard(comm, [&] {
    RowReader reader(path);
    for (const StoredArray& array : arrays) pieces.push_back(read_share(comm, reader, array));
  });
  check_pieces(comm, path, arrays, pieces);
}

}  // namespace bulkley
