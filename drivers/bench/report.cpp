#include "bench/report.hpp"

#include <filesystem>
#include <system_error>

#include "io/files/text_file.hpp"

namespace bulkley {

JsonObject describe(const BenchCase& what, const BenchResult& r) {
  JsonObject phases;
  for (const auto& [name, ns] : r.phases) phases.add(name, ns);
  JsonObject object;
  object.add("particles", r.n_particles)
      .add("ranks", r.n_ranks)
      .add("material", what.material)
      .add("scheme", name_of(what.transfer.scheme))
      .add("order", name_of(what.transfer.order))
      .add("gradient", name_of(what.transfer.gradient))
      .add("mach_number", r.mach_number)
      .add("yielded_fraction", r.yielded_fraction)
      .add("ns_per_particle_step", r.ns)
      .add("phases_ns_per_particle_step", phases)
      .add("sorts_per_step", r.sorts_per_step)
      .add("nodes_per_particle", r.nodes_per_particle)
      .add("naive_neo_hookean_ns_per_particle_step", r.naive_ns)
      .add("ratio_to_naive", r.ratio_to_naive)
      .add("one_rank_ns_per_particle_step", r.one_rank_ns)
      .add("throughput_ratio", r.throughput_ratio)
      .add("bytes_per_particle", r.bytes_per_particle)
      .add("forecast_bytes_per_particle", r.forecast_bytes_per_particle)
      .add("exchange_bytes_per_step", r.exchange_bytes_per_step)
      .add("exchange_messages_per_step", r.exchange_messages_per_step);
  return object;
}

void write_json(const std::string& path, const JsonObject& object) {
  if (const auto folder = std::filesystem::path(path).parent_path(); !folder.empty()) {
    std::error_code ignored;  // writing then fails with a message
    std::filesystem::create_directories(folder, ignored);
  }
  write_text_atomically(path, object.text() + "\n");
}

}  // namespace bulkley
