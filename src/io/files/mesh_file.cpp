#include "io/files/mesh_file.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "bulkley/base/error.hpp"
#include "geometry/mesh_format.hpp"

namespace bulkley {

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t largest_file = std::uintmax_t{4} << 30;  // bytes; it is read as a whole

}  // namespace

TriangleMesh read_mesh_file(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw UsageError("does not exist");
  if (fs::is_directory(path, error)) throw UsageError("is a folder, not a file");
  if (!fs::is_regular_file(path, error)) throw UsageError("is not a file");
  const auto format = mesh_format(path);
  if (!format) throw UsageError("is none of the formats .obj, .stl and .ply");
  const std::uintmax_t size = fs::file_size(path, error);
  std::ifstream stream(path, std::ios::binary);
  if (error || !stream) throw UsageError("cannot be opened");
  if (size == 0) throw UsageError("is empty");
  if (size > largest_file) throw UsageError(fmt::format("is larger than {} GiB", largest_file >> 30));
  std::string bytes(size, '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(size));
  if (static_cast<std::uintmax_t>(stream.gcount()) != size) throw UsageError("cannot be read to its end");
  return parse_mesh(bytes, *format);
}

}  // namespace bulkley
