#include "bulkley/io/array_file.hpp"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "bulkley/io/text_file.hpp"
#include "checksum.hpp"

namespace bulkley {

namespace {

constexpr GlobalIndex portion = GlobalIndex{16} << 20;       // bytes in memory at a time; far below MPI-IO's 2 GiB
constexpr GlobalIndex metadata_room = GlobalIndex{1} << 20;  // bytes; headers of our files take some tens of KiB
constexpr double free_space_factor = 1.1;

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

GlobalIndex size_on_disk(const FileContent& content) {
  GlobalIndex bytes = metadata_room;
  for (const Array& array : content.arrays)
    bytes += n_elements(array.shape) * static_cast<GlobalIndex>(element_size(array.type));
  for (const Attribute& attribute : content.attributes)
    if (const auto* text = std::get_if<std::string>(&attribute.value)) bytes += static_cast<GlobalIndex>(text->size());
  return bytes;
}

/// Reserves the first `bytes` of a file; a file system that cannot reserve is taken at its word that it has room.
void reserve(const std::string& path, GlobalIndex bytes, int open_flags) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | open_flags, 0666);
  if (file < 0) throw RunError(fmt::format("cannot create '{}': {}", path, std::strerror(errno)));
  // fallocate, not posix_fallocate: where the file system cannot reserve, the latter writes to every block.
  const int error = ::fallocate(file, 0, 0, bytes) == 0 ? 0 : errno;
  ::close(file);
  if (error == 0 || error == EOPNOTSUPP || error == ENOSYS) return;
  ::unlink(path.c_str());
  throw RunError(fmt::format("cannot write '{}': no room for {:.1f} MB ({})", path, static_cast<double>(bytes) * 1e-6,
                             std::strerror(error)));
}

/// A clean refusal while nothing has been opened collectively: on a full disk HDF5 fails on some ranks and waits on others.
void check_room(const std::string& temporary, const std::string& path, GlobalIndex bytes) {
  std::string folder = std::filesystem::path(path).parent_path().string();
  if (folder.empty()) folder = ".";
  struct statvfs disk = {};
  if (::statvfs(folder.c_str(), &disk) != 0)
    throw RunError(fmt::format("cannot write '{}': {}", path, std::strerror(errno)));
  const double free = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
  if (free < free_space_factor * static_cast<double>(bytes))
    throw RunError(fmt::format("cannot write '{}': it needs {:.1f} MB and the disk has {:.1f} MB free", path,
                               static_cast<double>(bytes) * 1e-6, free * 1e-6));
  reserve(temporary, bytes, O_CREAT | O_TRUNC);
}

void create_structure(Hdf5Writer& file, const FileContent& content) {
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
    file.create_array(array.path, array.type, array.shape);
    file.set_attribute(array.path, "unit", array.unit);
    file.set_attribute(array.path, "meaning", array.meaning);
    file.set_attribute(array.path, "crc32", GlobalIndex{0});  // takes its place now, its value after the data
  }
}

void write_block(Hdf5Writer& file, const Array& array, RunChecksums& checksums) {
  const GlobalIndex bytes = plane_bytes(array);
  for_each_portion(array.count[0], bytes, [&](GlobalIndex first, GlobalIndex n, std::byte* buffer) {
    array.fill(first, n, buffer);
    checksums.add(buffer, n * bytes);
    Extents start = array.start, count = array.count;
    start[0] += first;
    count[0] = n;
    file.write(array.path, start, count, buffer);
  });
}

void read_back(const Hdf5Reader& file, const Array& array, const RunChecksums& written, GlobalIndex run_length) {
  const ArrayInfo info = file.array(array.path);
  RunChecksums read(run_length);
  const GlobalIndex bytes = plane_bytes(array);
  for_each_portion(array.count[0], bytes, [&](GlobalIndex first, GlobalIndex n, std::byte* buffer) {
    Extents start = array.start, count = array.count;
    start[0] += first;
    count[0] = n;
    file.read(info, start, count, buffer);
    read.add(buffer, n * bytes);
  });
  if (read.values() != written.values())
    throw RunError(
        fmt::format("'{}' does not hold what was written to it: {} reads back differently", file.path(), array.path));
}

}  // namespace

void write_array_file(const Comm& comm, const std::string& path, const FileContent& content) {
  const std::string temporary = path + ".tmp";
  root_guard(comm, [&] { check_room(temporary, path, size_on_disk(content)); });

  std::vector<Runs> runs;
  std::vector<RunChecksums> checksums;
  std::string fault;
  {
    Hdf5Writer file(comm, temporary);
    create_structure(file, content);
    // Creating the file gave the room back. It was there a moment ago; if it is not, HDF5 cannot even be closed in order.
    if (comm.is_root()) {
      try {
        reserve(temporary, file.end_of_arrays() + metadata_room, 0);
      } catch (const std::exception& error) {
        abort_all_ranks(error.what(), __FILE__, __LINE__);
      }
    }
    BULKLEY_MPI(MPI_Barrier(comm.get()));

    for (const Array& array : content.arrays) {
      runs.push_back(runs_of(array));
      checksums.emplace_back(runs.back().length);
      try {
        collective_guard(comm, [&] { write_block(file, array, checksums.back()); });
      } catch (const RunError& error) {
        fault = error.what();
        break;  // on every rank
      }
      const std::uint32_t crc = combine_runs(comm, runs.back(), checksums.back().values());
      file.set_attribute(array.path, "crc32", GlobalIndex{crc});
    }
    file.close();
  }
  BULKLEY_MPI(MPI_Barrier(comm.get()));

  try {
    if (!fault.empty()) throw RunError(fault);
    collective_guard(comm, [&] {
      const Hdf5Reader file(temporary);
      for (std::size_t i = 0; i < content.arrays.size(); ++i)
        read_back(file, content.arrays[i], checksums[i], runs[i].length);
    });
    root_guard(comm, [&] {
      sync_file(temporary);
      rename_durably(temporary, path);
    });
  } catch (const RunError&) {
    if (comm.is_root()) ::unlink(temporary.c_str());
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
    refuse(fmt::format("its format version is {}, and this program knows versions up to {}", version, newest_version));
  if (version < 1) refuse(fmt::format("its format version is {}, which never existed", version));
}

Piece read_rows(const Hdf5Reader& file, const ArrayInfo& array, GlobalIndex first, GlobalIndex n,
                const std::function<void(GlobalIndex, GlobalIndex, const std::byte*)>& sink) {
  Piece piece;
  Extents start(array.shape.size(), 0), count = array.shape;
  count[0] = 1;
  const GlobalIndex row_bytes = n_elements(count) * static_cast<GlobalIndex>(element_size(array.type));
  for_each_portion(n, row_bytes, [&](GlobalIndex row, GlobalIndex n_rows, std::byte* buffer) {
    start[0] = first + row;
    count[0] = n_rows;
    file.read(array, start, count, buffer);
    piece.crc = crc_of(buffer, static_cast<std::size_t>(n_rows * row_bytes), piece.crc);
    piece.bytes += n_rows * row_bytes;
    sink(row, n_rows, buffer);
  });
  return piece;
}

std::uint32_t stored_crc(const Hdf5Reader& file, const std::string& array) {
  return static_cast<std::uint32_t>(file.integer(array, "crc32"));
}

void check_pieces(const Comm& comm, const std::string& path, std::span<const std::string> names,
                  std::span<const std::uint32_t> stored, std::span<const Piece> pieces) {
  std::vector<GlobalIndex> mine;
  for (const Piece& piece : pieces) {
    mine.push_back(piece.crc);
    mine.push_back(piece.bytes);
  }
  const int n = static_cast<int>(mine.size());
  std::vector<GlobalIndex> all(comm.is_root() ? mine.size() * static_cast<std::size_t>(comm.size()) : 0);
  BULKLEY_MPI(MPI_Gather(mine.data(), n, MPI_INT64_T, all.data(), n, MPI_INT64_T, 0, comm.get()));
  root_guard(comm, [&] {
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      std::uint32_t crc = 0;
      for (std::size_t at = 2 * i; at < all.size(); at += mine.size())
        crc = static_cast<std::uint32_t>(crc32_combine(crc, static_cast<std::uint32_t>(all[at]), all[at + 1]));
      if (crc != stored[i])
        throw RunError(fmt::format("cannot read '{}': {} is damaged (its checksum is {:08x} and should be {:08x})", path,
                                   names[i], crc, stored[i]));
    }
  });
}

void verify_arrays(const Comm& comm, const std::string& path, const std::vector<std::string>& arrays) {
  std::vector<std::uint32_t> stored;
  std::vector<Piece> pieces;
  collective_guard(comm, [&] {
    const Hdf5Reader file(path);
    for (const std::string& name : arrays) {
      const ArrayInfo array = file.array(name);
      const GlobalIndex rows = array.shape.empty() ? 0 : array.shape[0];
      const GlobalIndex first = rows * comm.rank() / comm.size(), last = rows * (comm.rank() + 1) / comm.size();
      stored.push_back(stored_crc(file, name));
      pieces.push_back(read_rows(file, array, first, last - first, [](GlobalIndex, GlobalIndex, const std::byte*) {}));
    }
  });
  check_pieces(comm, path, arrays, stored, pieces);
}

}  // namespace bulkley
