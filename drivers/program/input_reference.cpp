#include <fmt/format.h>

#include "program/commands.hpp"

namespace bulkley {

Command add_input_reference(CLI::App&) {
  return [](const Comm& comm) {
    if (comm.is_root()) fmt::print("{}", input_reference());
    return ExitCode::finished;
  };
}

}  // namespace bulkley
