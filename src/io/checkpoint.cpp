#include "bulkley/io/checkpoint.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bulkley/io/array_file.hpp"
#include "bulkley/io/text_file.hpp"
#include "bulkley/io/xdmf.hpp"
#include "checksum.hpp"
#include "header.hpp"
#include "particle_array.hpp"

namespace bulkley {

namespace {

const std::string format_name = "bulkley checkpoint";
const std::string prefix = "checkpoint_";

std::string file_name(GlobalIndex step, const char* suffix) { return fmt::format("{}{:09}{}", prefix, step, suffix); }

std::string array_path(const FieldInfo& field) { return std::string("/particles/") + field.name; }

/// The fields of a checkpoint of particles for which `has(field)`.
template <class Has>
std::vector<FieldInfo> written_fields(const Has& has) {
  std::vector<FieldInfo> fields;
  for (const FieldInfo& f : field_table)
    if (f.written && (!f.optional || has(f))) fields.push_back(f);
  return fields;
}
std::vector<FieldInfo> written_fields(const ParticleSet& particles) {
  return written_fields([&](const FieldInfo& field) { return particles.has(field.field); });
}
std::vector<FieldInfo> written_fields(const Hdf5Reader& file) {
  return written_fields([&](const FieldInfo& field) { return file.has(array_path(field)); });
}

std::uint32_t header_crc(const CheckpointHeader& header) {
  const std::string bytes = pack_header(header);
  return crc_of(reinterpret_cast<const std::byte*>(bytes.data()), bytes.size());
}

std::vector<Attribute> header_attributes(const CheckpointHeader& header) {
  std::vector<Attribute> attributes = {
      {"/", "step", header.step},
      {"/", "time", header.time},
      {"/", "n_particles", header.n_particles},
      {"/", "n_ranks", GlobalIndex{header.n_ranks}},
      {"/", "code_version", header.code_version},
      {"/", "materials", join_lines(header.material_names)},
      {"/", "scene", header.scene_text},
      {"/", "header_crc32", GlobalIndex{header_crc(header)}},
      {"/state", "about", std::string("state of the run's controllers; integers and reals by name")},
  };
  for (const auto& [name, value] : header.reals) attributes.push_back({"/state/reals", name, value});
  for (const auto& [name, value] : header.integers) attributes.push_back({"/state/integers", name, value});
  return attributes;
}

/// Header after checks of everything but the data.
CheckpointHeader checked_header(const Hdf5Reader& file) {
  const auto refuse = [&](const std::string& fault) {
    throw RunError(fmt::format("cannot read '{}': {}", file.path(), fault));
  };
  check_format(file, format_name, checkpoint_version);
  CheckpointHeader header;
  header.step = file.integer("/", "step");
  header.time = file.real("/", "time");
  header.n_particles = file.integer("/", "n_particles");
  header.n_ranks = static_cast<int>(file.integer("/", "n_ranks"));
  header.code_version = file.text("/", "code_version");
  header.material_names = split_lines(file.text("/", "materials"));
  header.scene_text = file.text("/", "scene");
  if (file.has("/state/reals"))
    for (const std::string& name : file.attribute_names("/state/reals"))
      header.reals[name] = file.real("/state/reals", name);
  if (file.has("/state/integers"))
    for (const std::string& name : file.attribute_names("/state/integers"))
      header.integers[name] = file.integer("/state/integers", name);
  if (GlobalIndex{header_crc(header)} != file.integer("/", "header_crc32"))
    refuse("its header is damaged (the checksum does not match)");

  for (const FieldInfo& field : written_fields(file)) {
    const ArrayInfo array = file.array(array_path(field));
    Extents shape = row_shape(field.n_components);
    shape.insert(shape.begin(), header.n_particles);
    if (array.type != stored_type(field.type) || array.shape != shape)
      refuse(fmt::format("{} is {} ({}) and should be {} ({})", array.path, name(array.type), fmt::join(array.shape, ", "),
                         name(stored_type(field.type)), fmt::join(shape, ", ")));
  }
  return header;
}

/// Sidecar last, so that it never names a file that is not there.
void write_sidecar(const std::string& folder, GlobalIndex step, GlobalIndex n_particles) {
  const std::string sidecar = path_in(folder, file_name(step, ".xdmf"));
  if (n_particles == 0)
    remove_file(sidecar);  // nothing to see, and ParaView refuses an empty set
  else
    write_text_atomically(sidecar, xdmf_series(std::vector{xdmf_particles(Hdf5Reader(checkpoint_path(folder, step)))}));
}

void remove_checkpoint(const std::string& folder, const std::string& name) {
  remove_file(path_in(folder, std::filesystem::path(name).replace_extension(".xdmf").string()));
  remove_file(path_in(folder, name));
}

void remove_old(const std::string& folder, GlobalIndex step, int keep) {
  for (const std::string& name : numbered_files(folder, prefix, ".h5.tmp")) remove_file(path_in(folder, name));
  std::vector<std::string> names = numbered_files(folder, prefix, ".h5");
  // Later steps are another run's; they are not to push out this run's.
  std::erase_if(names, [&](const std::string& name) { return number_in(name, prefix) > step; });
  for (std::size_t i = 0; i + static_cast<std::size_t>(keep) < names.size(); ++i) remove_checkpoint(folder, names[i]);
}

}  // namespace

std::string checkpoint_path(const std::string& folder, GlobalIndex step) { return path_in(folder, file_name(step, ".h5")); }

void write_checkpoint(const Comm& comm, const std::string& folder, const CheckpointHeader& given,
                      const ParticleSet& particles, std::span<const std::string> material_names, int keep) {
  const ParticleRange range = particle_range(comm, particles);
  CheckpointHeader header = given;
  header.n_particles = range.total;
  header.n_ranks = comm.size();
  header.material_names.assign(material_names.begin(), material_names.end());
  header = unpack_header(broadcast_text(comm, pack_header(header)));

  FileContent content{format_name, checkpoint_version, header_attributes(header), {}};
  for (const FieldInfo& field : written_fields(particles)) {
    Array array = particle_array(field.name, stored_type(field.type), field.n_components, range);
    array.unit = field.unit;
    array.meaning = field.meaning;
    array.fill = [&particles, field](GlobalIndex first, GlobalIndex n, std::byte* out) {
      field_to_rows(particles, field, first, n, out);
    };
    content.arrays.push_back(std::move(array));
  }
  content.arrays.push_back(connectivity_array(range));

  write_array_file(comm, checkpoint_path(folder, header.step), content);
  root_guard(comm, [&] {
    write_sidecar(folder, header.step, range.total);
    remove_old(folder, header.step, std::max(keep, 1));
  });
}

CheckpointHeader read_header(const Comm& comm, const std::string& file) {
  std::string bytes;
  root_guard(comm, [&] { bytes = pack_header(checked_header(Hdf5Reader(file))); });
  return unpack_header(broadcast_text(comm, std::move(bytes)));
}

CheckpointHeader verify_checkpoint(const Comm& comm, const std::string& file) {
  CheckpointHeader header = read_header(comm, file);
  std::string paths;
  root_guard(comm, [&] {
    const Hdf5Reader reader(file);
    paths = "/particles/connectivity";
    for (const FieldInfo& field : written_fields(reader)) paths += "\n" + array_path(field);
  });
  verify_arrays(comm, file, split_lines(broadcast_text(comm, std::move(paths))));
  return header;
}

void read_checkpoint(const Comm& comm, const std::string& file, GlobalIndex first, GlobalIndex count,
                     ParticleSet& particles) {
  const CheckpointHeader header = read_header(comm, file);
  const bool mine_fits = first == exclusive_sum(comm, count) && count >= 0;
  if (min_global(comm, GlobalIndex{mine_fits}) == 0 || sum_global(comm, count) != header.n_particles)
    throw RunError(fmt::format("the shares of the ranks do not make up the {} particles of '{}'", header.n_particles, file));

  std::vector<std::string> names;
  std::vector<std::uint32_t> stored;
  std::vector<Piece> pieces;
  collective_guard(comm, [&] {
    const LocalIndex size = ParticleSet::checked_size(count);
    const Hdf5Reader reader(file);
    particles.resize(0);
    particles.resize(size);
    for (const FieldInfo& field : written_fields(particles)) {
      if (!reader.has(array_path(field)))
        throw RunError(
            fmt::format("'{}' does not hold '{}', which the law of a material in the scene needs", file, field.name));
      names.push_back(array_path(field));
      stored.push_back(stored_crc(reader, names.back()));
      pieces.push_back(read_rows(
          reader, reader.array(names.back()), first, count,
          [&](GlobalIndex row, GlobalIndex n, const std::byte* rows) { rows_to_field(rows, field, row, n, particles); }));
    }
  });
  check_pieces(comm, file, names, stored, pieces);
}

std::optional<std::string> find_latest_checkpoint(const Comm& comm, const std::string& folder,
                                                  std::vector<std::string>& warnings) {
  std::string listing;
  root_guard(comm, [&] { listing = join_lines(numbered_files(folder, prefix, ".h5")); });
  std::vector<std::string> names = split_lines(broadcast_text(comm, std::move(listing)));
  for (auto name = names.rbegin(); name != names.rend(); ++name) {
    const std::string file = path_in(folder, *name);
    try {
      verify_checkpoint(comm, file);
      return file;
    } catch (const RunError& error) {  // alike on every rank
      warnings.push_back(fmt::format("checkpoint passed over: {}", error.what()));
    }
  }
  return std::nullopt;
}

int remove_checkpoints_after(const Comm& comm, const std::string& folder, GlobalIndex step) {
  int n_removed = 0;
  root_guard(comm, [&] {
    for (const std::string& name : numbered_files(folder, prefix, ".h5")) {
      if (number_in(name, prefix) <= step) continue;
      remove_checkpoint(folder, name);
      ++n_removed;
    }
  });
  BULKLEY_MPI(MPI_Bcast(&n_removed, 1, MPI_INT, 0, comm.get()));
  return n_removed;
}

}  // namespace bulkley
