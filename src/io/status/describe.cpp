#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/arrays/array_file.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "io/files/text_file.hpp"
#include "io/frames/frame.hpp"

namespace bulkley {

namespace {

std::vector<std::string> all_arrays(const Hdf5Reader& file) {
  std::vector<std::string> paths;
  for (const char* group : {"/particles", "/grid", "/tiles", "/magnetic_field"})
    if (file.has(group))
      for (const std::string& member : file.members(group)) paths.push_back(fmt::format("{}/{}", group, member));
  return paths;
}

std::string array_lines(const Hdf5Reader& file, const std::vector<std::string>& paths) {
  std::string text;
  for (const std::string& path : paths) {
    const ArrayInfo array = file.array(path);
    const std::string shape = fmt::format("({})", fmt::join(array.shape, ", "));
    text += fmt::format("  {:<32} {:<16} {:<8} {:<6} {}\n", path, shape, name(array.type), file.text(path, "unit"),
                        file.text(path, "meaning"));
  }
  return text;
}

std::string material_list(const std::vector<std::string>& names) {
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

std::string checkpoint_lines(const CheckpointHeader& header) {
  std::string text = fmt::format(
      "checkpoint of step {}, time {} s\n{} particles, written on {} ranks by version {}\nmaterials: {}\n", header.step,
      header.time, header.n_particles, header.n_ranks, header.code_version, material_list(header.material_names));
  for (const auto& [name, value] : header.reals) text += fmt::format("  {} = {}\n", name, value);
  for (const auto& [name, value] : header.integers) text += fmt::format("  {} = {}\n", name, value);
  return text;
}

std::string frame_lines(const FrameInfo& frame) {
  return fmt::format("frame {} of step {}, time {} s\n{} particles\n", frame.index, frame.step, frame.time,
                     frame.n_particles);
}

}  // namespace

std::string describe_file(const Comm& comm, const std::string& file) {
  std::string kind, text;
  std::vector<std::string> paths;
  root_guard(comm, [&] {
    const Hdf5Reader reader(file);
    if (!reader.has_attribute("/", "format"))
      throw RunError(fmt::format("cannot read '{}': it is an HDF5 file, but not one of Bulkley's", file));
    kind = reader.text("/", "format");
    paths = all_arrays(reader);
  });
  kind = broadcast_text(comm, std::move(kind));
  paths = split_lines(broadcast_text(comm, join_lines(paths)));

  const std::string summary =
      kind == frame_format ? frame_lines(read_frame_info(comm, file)) : checkpoint_lines(verify_checkpoint(comm, file));
  if (kind == frame_format) verify_arrays(comm, file, paths);
  root_guard(comm, [&] {
    text = fmt::format("{}\n{}{}all {} checksums are right\n", file, summary, array_lines(Hdf5Reader(file), paths),
                       paths.size());
  });
  return broadcast_text(comm, std::move(text));
}

}  // namespace bulkley
