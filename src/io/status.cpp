#include "bulkley/io/status.hpp"

#include <sys/resource.h>

#include <fmt/format.h>

#include <fstream>

#include "bulkley/io/json.hpp"
#include "bulkley/io/text_file.hpp"

namespace bulkley {

namespace {

// Value of a line "key:   123 kB" of /proc/self/status, bytes; 0 where there is no such file or line.
std::size_t process_bytes(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    std::size_t kibibytes = 0;
    if (word == key + ":" && file >> kibibytes) return kibibytes * 1024;
  }
  return 0;
}

}  // namespace

const char* name(RunState state) {
  switch (state) {
    case RunState::running:
      return "running";
    case RunState::stopped:
      return "stopped";
    case RunState::failed:
      return "failed";
    case RunState::finished:
      return "finished";
  }
  return "";
}

void write_status(const Comm& comm, const std::string& folder, const Status& status) {
  root_guard(comm, [&] {
    write_text_atomically(path_in(folder, "status.json"),
                          fmt::format("{{\n  \"state\": \"{}\",\n  \"step\": {},\n  \"time\": {},\n  \"checkpoint\": {},\n"
                                      "  \"reason\": {}\n}}\n",
                                      name(status.state), status.step, json_text(status.time), json_text(status.checkpoint),
                                      json_text(status.reason)));
  });
}

std::size_t peak_resident_bytes() {
  // getrusage starts from what the parent occupied when it started this program, so it comes second.
  if (const std::size_t peak = process_bytes("VmHWM"); peak > 0) return peak;
  struct rusage usage = {};
  return ::getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<std::size_t>(usage.ru_maxrss) * 1024 : 0;
}

}  // namespace bulkley
