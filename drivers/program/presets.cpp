#include <fmt/format.h>

#include "material/preset.hpp"
#include "program/commands.hpp"

namespace bulkley {

Command add_presets(CLI::App& app) {
  struct Arguments {
    bool markdown = false;
  };
  auto a = std::make_shared<Arguments>();
  app.add_flag("--markdown", a->markdown, "print the page docs/materials/presets.md, with all numbers");
  return [a](const Comm& comm) {
    if (!comm.is_root()) return ExitCode::finished;
    if (a->markdown) {
      fmt::print("{}", preset_reference());
      return ExitCode::finished;
    }
    for (const Preset& preset : presets())
      fmt::print("{:<20}{:<18}{:<11}{}\n", preset.name, law_name(preset.material), name(preset.confidence), preset.source);
    return ExitCode::finished;
  };
}

}  // namespace bulkley
