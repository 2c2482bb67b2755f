#include "io/files/text_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const char* what, const std::string& path, int error) {
  throw RunError(fmt::format("cannot {} '{}': {}", what, path, std::strerror(error)));
}

std::string folder_of(const std::string& path) {
  const std::string parent = fs::path(path).parent_path().string();
  return parent.empty() ? "." : parent;
}

bool is_numbered(const std::string& name, const std::string& prefix, const std::string& suffix) {
  if (name.size() <= prefix.size() + suffix.size() || !name.starts_with(prefix) || !name.ends_with(suffix)) return false;
  const auto digits_end = name.end() - static_cast<std::ptrdiff_t>(suffix.size());
  // 18 digits always fit the number's type.
  return name.size() - prefix.size() - suffix.size() <= 18 &&
         std::all_of(name.begin() + static_cast<std::ptrdiff_t>(prefix.size()), digits_end,
                     [](unsigned char c) { return c >= '0' && c <= '9'; });
}

/// Error number of writing all of `text`, 0 if it is written.
int write_all(int file, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(file, text.data() + done, text.size() - done);
    if (n > 0)
      done += static_cast<std::size_t>(n);
    else if (n == 0)
      return EIO;  // nothing and no reason: trying again would never end
    else if (errno != EINTR)
      return errno;
  }
  return 0;
}

/// Writes `text` under a temporary name beside `path`, which is returned.
std::string write_beside(const std::string& path, const std::string& text, const std::string& writer, bool flushed) {
  const std::string temporary = path + writer + ".tmp";
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) fail("create", temporary, errno);
  int error = write_all(file, text);
  if (error == 0 && flushed && ::fsync(file) != 0) error = errno;
  if (::close(file) != 0 && error == 0) error = errno;
  if (error != 0) {
    ::unlink(temporary.c_str());
    fail("write", temporary, error);
  }
  return temporary;
}

void rename_or_remove(const std::string& from, const std::string& to) {
  if (::rename(from.c_str(), to.c_str()) == 0) return;
  const int error = errno;
  ::unlink(from.c_str());
  fail("rename to", to, error);
}

}  // namespace

std::string path_in(const std::string& folder, const std::string& name) { return (fs::path(folder) / name).string(); }

void write_text_atomically(const std::string& path, const std::string& text, const std::string& writer) {
  rename_durably(write_beside(path, text, writer, true), path);
}

void write_text_before_end(const std::string& path, const std::string& text, const std::string& writer) {
  rename_or_remove(write_beside(path, text, writer, false), path);
  sync_file(path);
  sync_folder(folder_of(path));
}

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail("open", path, errno);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) fail("read", path, errno);
  return text;
}

void sync_file(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) fail("open", path, errno);
  const int error = ::fsync(file) == 0 ? 0 : errno;
  ::close(file);
  if (error != 0) fail("flush", path, error);
}

void sync_folder(const std::string& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) fail("open", folder, errno);
  const int error = ::fsync(file) == 0 ? 0 : errno;
  ::close(file);
  if (error != 0 && error != EINVAL && error != ENOTSUP) fail("flush", folder, error);
}

void rename_durably(const std::string& from, const std::string& to) {
  rename_or_remove(from, to);
  sync_folder(folder_of(to));
}

void remove_file(const std::string& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) fail("remove", path, errno);
}

void remove_leftovers(const std::string& folder) {
  for (const char* name : {"history.csv", "status.json", "scene.toml", "frames.xdmf", "grid.xdmf", "tiles.xdmf",
                           "colliders.xdmf", "colliders.h5"})
    remove_file(path_in(folder, std::string(name) + ".tmp"));
  for (const char* prefix : {"checkpoint_", "frame_"})
    for (const char* suffix : {".h5.tmp", ".h5.packed.tmp", ".xdmf.tmp"})
      for (const std::string& name : numbered_files(folder, prefix, suffix)) remove_file(path_in(folder, name));
}

GrowingFile::~GrowingFile() {
  if (file_ >= 0) ::close(file_);
}

void GrowingFile::open(const std::string& path) {
  path_ = path;
  file_ = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (file_ < 0) fail("open", path_, errno);
}

void GrowingFile::append(const std::string& text) {
  if (const int error = write_all(file_, text); error != 0) fail("write", path_, error);
}

void GrowingFile::sync() {
  if (::fsync(file_) != 0) fail("flush", path_, errno);
}

std::vector<std::string> numbered_files(const std::string& folder, const std::string& prefix, const std::string& suffix) {
  std::vector<std::string> names;
  std::error_code error;
  if (!fs::exists(folder, error)) return names;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (is_numbered(name, prefix, suffix)) names.push_back(name);
  }
  if (error) fail("read the folder", folder, error.value());
  std::sort(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
    const long number_a = number_in(a, prefix), number_b = number_in(b, prefix);
    return number_a != number_b ? number_a < number_b : a < b;
  });
  return names;
}

std::string join_lines(const std::vector<std::string>& lines) { return fmt::format("{}", fmt::join(lines, "\n")); }

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    lines.push_back(text.substr(start, end - start));
    start = end + 1;
  }
  return lines;
}

long number_in(const std::string& name, const std::string& prefix) { return std::stol(name.substr(prefix.size())); }

}  // namespace bulkley
