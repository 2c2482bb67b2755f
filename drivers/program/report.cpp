#include <fmt/format.h>

#include "io/files/text_file.hpp"
#include "program/commands.hpp"
#include "program/report_page.hpp"

namespace bulkley {

Command add_report(CLI::App& app) {
  struct Arguments {
    std::string folder, file;
  };
  auto a = std::make_shared<Arguments>();
  app.add_option("folder", a->folder, "output folder of a run")->required()->type_name("DIR");
  app.add_option("--out", a->file, "page to write (default: DIR/report.html)")->type_name("FILE.html");
  return [a](const Comm& comm) {
    root_guard(comm, [&] {
      const std::string file = a->file.empty() ? path_in(a->folder, "report.html") : a->file;
      const std::string page = report_page(a->folder);
      try {
        write_text_atomically(file, page);
      } catch (const RunError& error) {
        throw UsageError(fmt::format("{}; --out names another place for the page", error.what()));
      }
      fmt::print("{}\n", file);
    });
    return ExitCode::finished;
  };
}

}  // namespace bulkley
