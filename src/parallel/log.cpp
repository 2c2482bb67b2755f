#include "parallel/log.hpp"

#include <fmt/format.h>

#include <cstdio>

namespace bulkley {

void log_line(const Comm& comm, std::string_view text) {
  if (!comm.is_root()) return;
  fmt::print("{}\n", text);
  std::fflush(stdout);
}

}  // namespace bulkley
