#include "io/checkpoint/compare.hpp"

#include <fmt/format.h>

#include "program/commands.hpp"

namespace bulkley {

namespace {

struct CompareArguments {
  std::string a, b;
  double tolerance = -1.0;
  bool full = false;
};

}  // namespace

Command add_compare(CLI::App& app) {
  auto arguments = std::make_shared<CompareArguments>();
  app.add_option("a", arguments->a, "checkpoint, or a run's folder for its newest one")->required()->type_name("A.h5");
  app.add_option("b", arguments->b, "checkpoint, or a run's folder for its newest one")->required()->type_name("B.h5");
  app.add_option("--tolerance", arguments->tolerance,
                 "largest difference that counts as equal, relative to the field's largest value (default: equal bits)")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--full", arguments->full, "compare every value, even if the fingerprints in the files agree");
  app.footer("Exit code 0: identical (or within the tolerance); 1: different.");
  return [arguments](const Comm& comm) {
    const std::string a = resolve_checkpoint(comm, arguments->a), b = resolve_checkpoint(comm, arguments->b);
    const Comparison comparison = compare_checkpoints(comm, a, b, {.full = arguments->full});
    GlobalIndex equal = comparison.identical ? 1 : 0;
    if (comm.is_root()) {
      fmt::print("{}", comparison_text(comparison));
      if (!comparison.identical && arguments->tolerance >= 0.0 && within(comparison, arguments->tolerance)) {
        fmt::print("within the tolerance of {:g}\n", arguments->tolerance);
        equal = 1;
      }
    }
    equal = max_global(comm, equal);
    return equal ? ExitCode::finished : ExitCode::differs;
  };
}

}  // namespace bulkley
