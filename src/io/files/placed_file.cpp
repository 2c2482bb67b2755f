#include "io/files/placed_file.hpp"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "io/files/text_file.hpp"

namespace bulkley {

namespace {

constexpr double free_space_factor = 1.1;

}  // namespace

PlacedReader::PlacedReader(const std::string& path) : path_(path), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (file_ < 0) throw RunError(fmt::format("cannot read '{}': {}", path_, std::strerror(errno)));
}

PlacedReader::~PlacedReader() { ::close(file_); }

void PlacedReader::read(void* data, GlobalIndex bytes, GlobalIndex place) const {
  for (GlobalIndex done = 0; done < bytes;) {
    const ssize_t n =
        ::pread(file_, static_cast<std::byte*>(data) + done, static_cast<std::size_t>(bytes - done), place + done);
    if (n > 0)
      done += n;
    else if (n == 0)
      throw RunError(fmt::format("cannot read '{}': it is damaged (it ends at {} bytes)", path_, place + done));
    else if (errno != EINTR)
      throw RunError(fmt::format("cannot read '{}': {}", path_, std::strerror(errno)));
  }
}

PlacedFile::PlacedFile(const std::string& path) : path_(path), file_(::open(path.c_str(), O_WRONLY | O_CLOEXEC)) {
  if (file_ < 0) fail(errno);
}

PlacedFile::~PlacedFile() { ::close(file_); }

void PlacedFile::write(const void* data, GlobalIndex bytes, GlobalIndex place) const {
  for (GlobalIndex done = 0; done < bytes;) {
    const ssize_t n =
        ::pwrite(file_, static_cast<const std::byte*>(data) + done, static_cast<std::size_t>(bytes - done), place + done);
    if (n > 0)
      done += n;
    else if (n == 0)
      fail(EIO);  // nothing and no reason: trying again would never end
    else if (errno != EINTR)
      fail(errno);
  }
}

void PlacedFile::sync() const {
  if (::fsync(file_) != 0) fail(errno);
}

void PlacedFile::fail(int error) const { throw RunError(fmt::format("cannot write '{}': {}", path_, std::strerror(error))); }

namespace {

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

}  // namespace

void reserve(const std::string& path, GlobalIndex bytes) { reserve(path, bytes, 0); }

void make_room(const std::string& temporary, const std::string& path, GlobalIndex bytes) {
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

void write_in_places(const Comm& comm, const std::string& path, GlobalIndex bytes,
                     const std::function<void(const PlacedFile&)>& work) {
  const std::string temporary = path + ".tmp";
  try {
    root_guard(comm, [&] { make_room(temporary, path, bytes); });
    collective_guard(comm, [&] {
      const PlacedFile file(temporary);
      work(file);
      file.sync();
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

}  // namespace bulkley
