#include <fmt/format.h>

#include "io/checkpoint/checkpoint.hpp"
#include "program/commands.hpp"

namespace bulkley {

Command add_info(CLI::App& app) {
  auto file = std::make_shared<std::string>();
  app.add_option("file", *file, "checkpoint or frame, or a run's folder for its newest checkpoint")
      ->required()
      ->type_name("FILE.h5");
  return [file](const Comm& comm) {
    const std::string text = describe_file(comm, resolve_checkpoint(comm, *file));
    if (comm.is_root()) fmt::print("{}", text);
    return ExitCode::finished;
  };
}

}  // namespace bulkley
