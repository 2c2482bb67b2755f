#include "io/convert/convert.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "io/files/text_file.hpp"
#include "program/commands.hpp"
#include "program/convert_options.hpp"

namespace bulkley {

namespace {

std::vector<ConvertJob> shared_plan(const Comm& comm, const ConvertOptions& options, ConvertFormat format) {
  std::string text;
  root_guard(comm, [&] {
    std::vector<std::string> lines;
    for (const ConvertJob& job : plan_conversion(options, format)) {
      lines.push_back(job.input);
      lines.push_back(job.output);
    }
    text = join_lines(lines);
  });
  const std::vector<std::string> lines = split_lines(broadcast_text(comm, std::move(text)));
  std::vector<ConvertJob> jobs;
  for (std::size_t i = 0; i + 1 < lines.size(); i += 2) jobs.push_back({lines[i], lines[i + 1]});
  return jobs;
}

ExitCode convert(const Comm& comm, const ConvertOptions& options) {
  const ConvertFormat format = parse_format(options.format);
  const Selection selection = parse_selection(options);
  const std::vector<ConvertJob> jobs = shared_plan(comm, options, format);
  std::vector<SeriesEntry> series;
  for (const ConvertJob& job : jobs) {
    const Conversion done = convert_file(comm, job.input, job.output, format, selection);
    series.push_back({std::filesystem::path(job.output).filename().string(), done.time});
    if (comm.is_root())
      fmt::print("{}: {} of {} particles, time {} s\n", job.output, done.n_written, done.n_particles, done.time);
  }
  const std::string list = series_path(options, jobs, format);
  if (list.empty()) return ExitCode::finished;
  std::stable_sort(series.begin(), series.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  root_guard(comm, [&] { write_text_atomically(list, pvd_document(series)); });
  if (comm.is_root()) fmt::print("{}: for ParaView, all of them with their times\n", list);
  return ExitCode::finished;
}

}  // namespace

Command add_convert(CLI::App& app) {
  auto options = std::make_shared<ConvertOptions>();
  app.add_option("input", options->inputs, "frames, checkpoints, or folders of runs for their frames")
      ->required()
      ->type_name("INPUT");
  app.add_option("--to", options->format, "vtu, vtkhdf or csv")->required()->type_name("FORMAT");
  app.add_option("--out", options->out, "file for one input, or a folder")->required()->type_name("FILE_OR_DIR");
  app.add_option("--fields", options->fields, "fields in addition to the position (default: all)")
      ->type_name("NAME,NAME...");
  app.add_option("--region", options->region, "x0:x1,y0:y1,z0:z1 in m; omitted ends are open")->type_name("BOX");
  app.add_option("--every", options->every, "about one particle in N, the same at all times, by a hash of its id")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  app.add_option("--frames", options->frames, "all, last, 0,10,20 or first:end[:step], of a folder (default: all)")
      ->type_name("FRAMES");
  return [options](const Comm& comm) { return convert(comm, *options); };
}

}  // namespace bulkley
