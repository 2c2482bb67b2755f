#include "bulkley/io/status.hpp"

#include <sys/resource.h>

#include <cmath>

#include <fmt/format.h>

#include "bulkley/io/text_file.hpp"

namespace bulkley {

namespace {

std::string json(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      quoted += {'\\', c};
    else if (code < 0x20)
      quoted += fmt::format("\\u{:04x}", code);
    else
      quoted += c;
  }
  return quoted + "\"";
}

// JSON has no word for NaN or infinity.
std::string json(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

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
    write_text_atomically(
        path_in(folder, "status.json"),
        fmt::format("{{\n  \"state\": \"{}\",\n  \"step\": {},\n  \"time\": {},\n  \"checkpoint\": {},\n"
                    "  \"reason\": {}\n}}\n",
                    name(status.state), status.step, json(status.time), json(status.checkpoint), json(status.reason)));
  });
}

std::size_t peak_resident_bytes() {
  struct rusage usage = {};
  return ::getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<std::size_t>(usage.ru_maxrss) * 1024 : 0;
}

}  // namespace bulkley
