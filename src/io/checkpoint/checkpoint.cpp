#include "io/checkpoint/checkpoint.hpp"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/arrays/array_file.hpp"
#include "io/arrays/box_array.hpp"
#include "io/arrays/checksum.hpp"
#include "io/arrays/particle_array.hpp"
#include "io/checkpoint/header.hpp"
#include "io/checkpoint/particle_check.hpp"
#include "io/files/text_file.hpp"
#include "io/frames/xdmf.hpp"

namespace bulkley {

namespace {

const std::string prefix = "checkpoint_";
const std::string fingerprint_group = "/state/fingerprints";

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
  for (const auto& [name, value] : header.fingerprints)
    attributes.push_back({fingerprint_group, name,
                          std::vector{static_cast<GlobalIndex>(value.first), static_cast<GlobalIndex>(value.second)}});
  return attributes;
}

/// Header after checks of everything but the data.
CheckpointHeader checked_header(const Hdf5Reader& file) {
  const auto refuse = [&](const std::string& fault) {
    throw RunError(fmt::format("cannot read '{}': {}", file.path(), fault));
  };
  check_format(file, checkpoint_format, checkpoint_version);
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
  if (file.has(fingerprint_group))
    for (const std::string& name : file.attribute_names(fingerprint_group)) {
      const std::vector<GlobalIndex> sums = file.integers(fingerprint_group, name);
      if (sums.size() != 2) refuse(fmt::format("the fingerprint of {} is damaged (its size)", name));
      header.fingerprints[name] = {static_cast<std::uint64_t>(sums[0]), static_cast<std::uint64_t>(sums[1])};
    }
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

/// For a checkpoint whose writer was killed before it could; a damaged one stays without.
void complete_sidecar(const std::string& file) {
  GlobalIndex n_particles = 0;
  try {
    n_particles = checked_header(Hdf5Reader(file)).n_particles;
  } catch (const RunError&) {
    return;
  }
  write_sidecar(file, n_particles);
}

void remove_checkpoint(const std::string& folder, const std::string& name) {
  remove_file(path_in(folder, sidecar_of(name)));
  remove_file(path_in(folder, name));
}

void remove_old(const std::string& folder, GlobalIndex step, int keep) {
  remove_leftovers(folder);
  std::vector<std::string> names = numbered_files(folder, prefix, ".h5");
  // Later steps are another run's; they are not to push out this run's.
  std::erase_if(names, [&](const std::string& name) { return number_in(name, prefix) > step; });
  const auto n_kept = static_cast<std::size_t>(std::max(keep, 1));
  for (std::size_t i = 0; i + n_kept < names.size(); ++i) remove_checkpoint(folder, names[i]);
}

std::vector<std::string> other_arrays(const Hdf5Reader& file) {
  std::vector<std::string> paths{"/particles/connectivity"};
  for (const std::string& group : file.members("/"))
    if (group != "particles" && group != "state")
      for (const std::string& member : file.members("/" + group)) paths.push_back(fmt::format("/{}/{}", group, member));
  return paths;
}

using FieldsOf = std::function<std::vector<FieldInfo>(const Hdf5Reader&)>;
using RowSink = std::function<void(const FieldInfo&, GlobalIndex row, GlobalIndex n, const std::byte* rows)>;

/// What belongs to the particles: field and array. Ids come first, because the fingerprints of the others need them.
struct StoredField {
  FieldInfo field;
  StoredArray array;
};

/// The arrays of the fields, and those that are no fields of particles. Collective.
std::pair<std::vector<StoredField>, std::vector<StoredArray>> find_fields(const Comm& comm, const std::string& file,
                                                                          const FieldsOf& fields_of) {
  std::vector<StoredArray> arrays = find_arrays(comm, file, [&](const Hdf5Reader& reader) {
    std::vector<std::string> paths = other_arrays(reader);
    for (const FieldInfo& field : fields_of(reader)) paths.push_back(array_path(field));
    return paths;
  });
  std::vector<StoredField> fields;
  for (const FieldInfo& field : field_table) {
    const auto is_its = [path = array_path(field)](const StoredArray& array) { return array.info.path == path; };
    const auto found = std::find_if(arrays.begin(), arrays.end(), is_its);
    if (found == arrays.end()) continue;
    fields.insert(field.field == Field::id ? fields.begin() : fields.end(), {field, *found});
    arrays.erase(found);
  }
  return {std::move(fields), std::move(arrays)};
}

/// Compares the fingerprints of what was read with those of a header. Throws RunError. Collective.
void expect_fingerprints(const Comm& comm, const std::string& what, const CheckpointHeader& header,
                         const std::map<std::string, Fingerprint>& found, const std::vector<GlobalIndex>& ids) {
  const auto agrees = [&](const std::string& name) {
    const auto written = header.fingerprints.find(name);
    return written == header.fingerprints.end() || written->second == found.at(name);
  };
  // Ids first: all others depend on them. Their likeliest fault has a clearer sentence; a file of an earlier version has no
  // fingerprints.
  const std::string id = info(Field::id).name;
  if (!agrees(id) || !header.fingerprints.contains(id)) expect_unique(comm, what, ids);
  std::string wrong = agrees(id) ? "" : id;
  for (auto field = found.begin(); wrong.empty() && field != found.end(); ++field)
    if (!agrees(field->first)) wrong = field->first;
  if (!wrong.empty())
    throw RunError(fmt::format("{}: {} is not what was written (the fingerprint of the values and their ids does not match)",
                               what, wrong));
}

/// Reads rows [first, first + count) of fields into `sink`, where `row` counts from `first`, and verifies checksums, values and
/// fingerprints; gives the latter. `fields_of` is called on the root. The ranks' parts make up the whole file. Collective.
std::map<std::string, Fingerprint> read_fields(const Comm& comm, const std::string& file, const CheckpointHeader& header,
                                               GlobalIndex first, GlobalIndex count, const FieldsOf& fields_of,
                                               const RowSink& sink) {
  const auto [fields, others] = find_fields(comm, file, fields_of);
  std::vector<StoredArray> arrays;
  std::vector<Piece> pieces;
  std::vector<GlobalIndex> ids;
  std::vector<Fingerprint> sums(fields.size());
  const std::string what = fmt::format("cannot read '{}'", file);
  ParticleCheck check(what, header.material_names.size());
  collective_guard(comm, [&] {
    RowReader reader(file);
    ids.resize(static_cast<std::size_t>(count));
    for (const auto& [field, array] : fields) {
      arrays.push_back(array);
      pieces.push_back(
          reader.read(array, first, count, [&, &field = field](GlobalIndex row, GlobalIndex n, const std::byte* rows) {
            check.look_at(field, first + row, n, rows);
            if (field.field == Field::id)
              std::memcpy(ids.data() + row, rows, static_cast<std::size_t>(n) * sizeof(GlobalIndex));
            add_rows(field, n, ids.data() + row, rows, sums[arrays.size() - 1]);
            sink(field, row, n, rows);
          }));
    }
    for (const StoredArray& array : others) {
      arrays.push_back(array);
      pieces.push_back(read_share(comm, reader, array));
    }
  });
  check_pieces(comm, file, arrays, pieces);
  collective_guard(comm, [&] { check.throw_if_seen(); });
  sum_global(comm, sums);
  std::map<std::string, Fingerprint> found;
  for (std::size_t i = 0; i < fields.size(); ++i) found[fields[i].field.name] = sums[i];
  expect_fingerprints(comm, what, header, found, ids);
  return found;
}

/// The fingerprints of all ranks' particles. Collective.
std::map<std::string, Fingerprint> fingerprints_of(const Comm& comm, const ParticleSet& particles) {
  const std::vector<FieldInfo> fields = written_fields(particles);
  std::vector<Fingerprint> sums;
  for (const FieldInfo& field : fields) sums.push_back(fingerprint_of(particles, field));
  sum_global(comm, sums);
  std::map<std::string, Fingerprint> all;
  for (std::size_t i = 0; i < fields.size(); ++i) all[fields[i].name] = sums[i];
  return all;
}

}  // namespace

std::string checkpoint_path(const std::string& folder, GlobalIndex step) { return path_in(folder, file_name(step, ".h5")); }

GlobalIndex checkpoint_bytes(const OptionalFields& fields, GlobalIndex n_particles) {
  const ParticleRange all{0, n_particles, n_particles};
  GlobalIndex bytes = stored_bytes(connectivity_array(all));
  for (const FieldInfo& field : written_fields(ParticleSet(fields)))
    bytes += stored_bytes(particle_array(field.name, stored_type(field.type), field.n_components, all));
  return bytes;
}

void write_checkpoint(const Comm& comm, const std::string& folder, const CheckpointHeader& given,
                      const ParticleSet& particles, std::span<const std::string> material_names, int keep,
                      std::span<const BoxFields> boxes) {
  const ParticleRange range = particle_range(comm, particles);
  CheckpointHeader header = given;
  header.n_particles = range.total;
  header.n_ranks = comm.size();
  header.material_names.assign(material_names.begin(), material_names.end());
  header.fingerprints = fingerprints_of(comm, particles);
  header = unpack_header(broadcast_text(comm, pack_header(header)));

  const std::string file = checkpoint_path(folder, header.step);
  ParticleCheck check(fmt::format("cannot write '{}'", file), material_names.size());
  FileContent content{checkpoint_format, checkpoint_version, header_attributes(header), {}, 0};
  for (const FieldInfo& field : written_fields(particles)) {
    Array array = particle_array(field.name, stored_type(field.type), field.n_components, range);
    array.unit = field.unit;
    array.meaning = field.meaning;
    array.fill = [&particles, &check, &range, field](GlobalIndex first, GlobalIndex n, std::byte* out) {
      field_to_rows(particles, field, first, n, out);
      check.look_at(field, range.first + first, n, out);
      check.throw_if_seen();  // a file that no restart would take must not push out one that it would
    };
    content.arrays.push_back(std::move(array));
  }
  content.arrays.push_back(connectivity_array(range));
  for (const BoxFields& box : boxes) add_box(content, box, ArrayType::float64);

  write_array_file(comm, file, content);
  root_guard(comm, [&] {
    write_sidecar(file, range.total);
    remove_old(folder, header.step, keep);
  });
}

CheckpointHeader read_header(const Comm& comm, const std::string& file) {
  std::string bytes;
  root_guard(comm, [&] { bytes = pack_header(checked_header(Hdf5Reader(file))); });
  return unpack_header(broadcast_text(comm, std::move(bytes)));
}

CheckpointHeader verify_checkpoint(const Comm& comm, const std::string& file) {
  CheckpointHeader header = read_header(comm, file);
  const EvenShare share = even_share(comm, header.n_particles);
  header.fingerprints = read_fields(
      comm, file, header, share.first, share.count(), [](const Hdf5Reader& reader) { return written_fields(reader); },
      [](const FieldInfo&, GlobalIndex, GlobalIndex, const std::byte*) {});
  return header;
}

bool read_checkpoint(const Comm& comm, const std::string& file, GlobalIndex first, GlobalIndex count,
                     ParticleSet& particles) {
  const CheckpointHeader header = read_header(comm, file);
  const bool mine_fits = first == exclusive_sum(comm, count) && count >= 0;
  if (min_global(comm, GlobalIndex{mine_fits}) == 0 || sum_global(comm, count) != header.n_particles)
    throw RunError(fmt::format("the shares of the ranks do not make up the {} particles of '{}'", header.n_particles, file));

  collective_guard(comm, [&] {
    const LocalIndex size = ParticleSet::checked_size(count);
    particles.resize(0);
    particles.resize(size);
  });
  const auto needed_fields = [&](const Hdf5Reader& reader) {
    std::vector<FieldInfo> fields = written_fields(particles);
    std::erase_if(fields, [&](const FieldInfo& field) {
      // The one is computed anew, the other begins with the pressure.
      return (field.field == Field::kirchhoff_stress || field.field == Field::layer_pressure) && !reader.has(array_path(field));
    });
    for (const FieldInfo& field : fields)
      if (!reader.has(array_path(field)))
        throw RunError(fmt::format(
            "'{}' does not hold '{}', which the law of a material or output.fields in the scene needs", file, field.name));
    return fields;
  };
  const auto found = read_fields(comm, file, header, first, count, needed_fields,
                                 [&](const FieldInfo& field, GlobalIndex row, GlobalIndex n, const std::byte* rows) {
                                   rows_to_field(rows, field, row, n, particles);
                                 });
  return !particles.has(Field::kirchhoff_stress) || found.contains(info(Field::kirchhoff_stress).name);
}

bool read_box(const Comm& comm, const std::string& file, BoxFields& box) {
  bool read = false;
  collective_guard(comm, [&] { read = read_box(Hdf5Reader(file), box); });
  return read;
}

std::optional<std::string> find_latest_checkpoint(const Comm& comm, const std::string& folder,
                                                  std::vector<std::string>& warnings) {
  return read_latest_checkpoint(comm, folder, warnings, [&](const std::string& file) { verify_checkpoint(comm, file); });
}

std::optional<std::string> read_latest_checkpoint(const Comm& comm, const std::string& folder,
                                                  std::vector<std::string>& warnings,
                                                  const std::function<void(const std::string&)>& read) {
  std::string listing;
  root_guard(comm, [&] { listing = join_lines(numbered_files(folder, prefix, ".h5")); });
  std::vector<std::string> names = split_lines(broadcast_text(comm, std::move(listing)));
  for (auto name = names.rbegin(); name != names.rend(); ++name) {
    const std::string file = path_in(folder, *name);
    try {
      read(file);
      return file;
    } catch (const RunError& error) {  // on every rank
      warnings.push_back(fmt::format("checkpoint skipped: {}", error.what()));
    }
  }
  return std::nullopt;
}

int remove_checkpoints_after(const Comm& comm, const std::string& folder, GlobalIndex step, int keep) {
  int n_removed = 0;
  root_guard(comm, [&] {
    for (const std::string& name : numbered_files(folder, prefix, ".h5")) {
      if (number_in(name, prefix) > step) {
        remove_checkpoint(folder, name);
        ++n_removed;
      } else if (!std::filesystem::exists(path_in(folder, sidecar_of(name)))) {
        complete_sidecar(path_in(folder, name));
      }
    }
    remove_old(folder, step, keep);
  });
  BULKLEY_MPI(MPI_Bcast(&n_removed, 1, MPI_INT, 0, comm.get()));
  return n_removed;
}

}  // namespace bulkley
