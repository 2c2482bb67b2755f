#include "io/convert/convert.hpp"

#include <memory>

#include <fmt/format.h>

#include "io/arrays/array_file.hpp"
#include "io/convert/selected_rows.hpp"

namespace bulkley {

Conversion convert_file(const Comm& comm, const std::string& input, const std::string& output, ConvertFormat format,
                        const Selection& selection) {
  std::unique_ptr<const Hdf5Reader> file;
  Snapshot snapshot;
  collective_guard(comm, [&] {
    file = std::make_unique<const Hdf5Reader>(input);
    snapshot = read_moment(*file, selection);
  });
  verify_arrays(comm, input, arrays_read(snapshot, selection));

  std::unique_ptr<const SelectedRows> rows;
  collective_guard(comm, [&] {
    const EvenShare share = even_share(comm, snapshot.n_particles);
    rows = std::make_unique<const SelectedRows>(*file, snapshot, selection, share.first, share.end);
  });
  const GlobalIndex first = exclusive_sum(comm, rows->count()), total = sum_global(comm, rows->count());
  const Share share{snapshot, *rows, first, total};
  switch (format) {
    case ConvertFormat::vtu:
      write_vtu(comm, output, share);
      break;
    case ConvertFormat::vtkhdf:
      write_vtkhdf(comm, output, share);
      break;
    case ConvertFormat::csv:
      write_csv(comm, output, share);
      break;
  }
  return {snapshot.time, snapshot.n_particles, total};
}

std::string pvd_document(std::span<const SeriesEntry> entries) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <Collection>\n";
  for (const SeriesEntry& entry : entries)
    text += fmt::format("    <DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", entry.time, entry.file);
  return text + "  </Collection>\n</VTKFile>\n";
}

}  // namespace bulkley
