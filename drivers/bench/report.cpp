#include "bench/report.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "io/files/text_file.hpp"
#include "scene/time_step_keys.hpp"

namespace bulkley {

Json describe(const BenchCase& what, const BenchResult& r) {
  Json phases = Json::object();
  for (const auto& [name, ns] : r.phases) phases[name] = rounded(ns);
  return {{"particles", r.n_particles},
          {"ranks", r.n_ranks},
          {"material", what.material},
          {"scheme", name_of(what.transfer.scheme)},
          {"order", name_of(what.transfer.order)},
          {"gradient", name_of(what.transfer.gradient)},
          {"dilation", name_of(what.transfer.dilation)},
          {"integrator", name_of(what.integrator)},
          {"mach_number", rounded(r.mach_number)},
          {"yielded_fraction", rounded(r.yielded_fraction)},
          {"ns_per_particle_step", rounded(r.ns)},
          {"phases_ns_per_particle_step", phases},
          {"sorts_per_step", rounded(r.sorts_per_step)},
          {"nodes_per_particle", rounded(r.nodes_per_particle)},
          {"naive_neo_hookean_ns_per_particle_step", rounded(r.naive_ns)},
          {"ratio_to_naive", rounded(r.ratio_to_naive)},
          {"explicit_ns_per_particle_step", rounded(r.explicit_ns)},
          {"ratio_to_explicit", rounded(r.ratio_to_explicit)},
          {"iterations_per_step", rounded(r.iterations_per_step)},
          {"rounds_per_step", rounded(r.rounds_per_step)},
          {"exchange_bytes_per_iteration", rounded(r.exchange_bytes_per_iteration)},
          {"one_rank_ns_per_particle_step", rounded(r.one_rank_ns)},
          {"throughput_ratio", rounded(r.throughput_ratio)},
          {"bytes_per_particle", rounded(r.bytes_per_particle)},
          {"forecast_bytes_per_particle", rounded(r.forecast_bytes_per_particle)},
          {"exchange_bytes_per_step", rounded(r.exchange_bytes_per_step)},
          {"exchange_messages_per_step", r.exchange_messages_per_step}};
}

void write_json(const std::string& path, const Json& object) {
  if (const auto folder = std::filesystem::path(path).parent_path(); !folder.empty()) {
    std::error_code ignored;  // writing then fails with a message
    std::filesystem::create_directories(folder, ignored);
  }
  write_text_atomically(path, json_text(object) + "\n");
}

}  // namespace bulkley
