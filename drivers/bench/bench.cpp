// `bulkley bench`: the real step on a fixed scene, phase by phase, compared with a naive serial kernel timed in the same
// run.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "bench/io.hpp"
#include "bench/report.hpp"
#include "bench/suite.hpp"
#include "program/commands.hpp"
#include "scene/time_step_keys.hpp"
#include "scene/transfer_keys.hpp"

namespace bulkley {

namespace {

struct Arguments {
  BenchCase what;
  BenchEffort effort;
  bool suite = false;
  SuiteSettings suite_settings;
  IoBench io;
  std::string json;
};

// An option that takes the name of one value of an enumeration.
template <class E>
void add_choice(CLI::App& app, const std::string& option, E& value) {
  std::vector<std::string> known;
  for (const auto& [name, each] : names(config::Of<E>{})) known.push_back(name);
  app.add_option_function<std::string>(option,
                                       [&value](const std::string& given) {
                                         for (const auto& [name, each] : names(config::Of<E>{}))
                                           if (name == given) value = each;
                                       })
      ->check(CLI::IsMember(known))
      ->default_str(name_of(value));
}

void time_case(const Comm& comm, const Arguments& a) {
  const Json result = describe(a.what, run_bench(comm, a.what, a.effort));
  root_guard(comm, [&] {
    fmt::print("{}\n", json_text(result));
    if (!a.json.empty()) write_json(a.json, result);
  });
}

void time_io(const Comm& comm, const Arguments& a) {
  IoBench what = a.io;
  what.n_particles = a.what.n_particles;
  const Json result = bench_io(comm, what);
  root_guard(comm, [&] {
    fmt::print("{}\n", json_text(result));
    if (!a.json.empty()) write_json(a.json, result);
  });
}

void time_suite(const Comm& comm, const Arguments& a) {
  const Json result = run_suite(comm, a.suite_settings);
  root_guard(comm, [&] {
    if (!a.json.empty()) write_json(a.json, result);
  });
}

}  // namespace

Command add_bench(CLI::App& app) {
  auto a = std::make_shared<Arguments>();
  app.add_option("--json", a->json, "also write the result to this file")->type_name("FILE");

  CLI::App* one_case = app.add_option_group("one case");
  one_case->add_option("--particles", a->what.n_particles, "about how many, 8 per cell")
      ->check(CLI::Range(smallest_ball, GlobalIndex{2'000'000'000}))
      ->capture_default_str();
  one_case->add_option("--material", a->what.material, "one of " + bench_materials())->capture_default_str();
  one_case->add_option("--steps", a->effort.n_steps, fmt::format("steps to time, in blocks of {}", block_steps))
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  add_choice(*one_case, "--scheme", a->what.transfer.scheme);
  add_choice(*one_case, "--order", a->what.transfer.order);
  add_choice(*one_case, "--gradient", a->what.transfer.gradient);
  add_choice(*one_case, "--dilation", a->what.transfer.dilation);
  add_choice(*one_case, "--integrator", a->what.integrator);
  one_case->add_flag("!--no-naive", a->effort.naive, "without the naive kernel");
  one_case->add_flag("!--no-one-rank", a->effort.one_rank, "on several ranks: without the same scene on one rank");

  CLI::App* whole_suite = app.add_option_group("suite");
  CLI::Option* suite =
      whole_suite->add_flag("--suite", a->suite, "measure all bounds of docs/performance.md, in several minutes");
  whole_suite->add_flag("--small", a->suite_settings.small, "the suite with a tenth of the particles")->needs(suite);
  whole_suite->add_option("--only", a->suite_settings.parts, "parts of the suite")
      ->check(CLI::IsMember(suite_parts()))
      ->needs(suite);
  for (CLI::Option* option : one_case->get_options()) suite->excludes(option);

  CLI::Option* io = app.add_option("--io", a->io.folder,
                                   "instead, time checkpoints and frames of --particles particles in this "
                                   "folder, compared with a plain file");
  io->type_name("DIR")->excludes(suite);

  return [a](const Comm& comm) {
    if (!a->io.folder.empty())
      time_io(comm, *a);
    else
      a->suite ? time_suite(comm, *a) : time_case(comm, *a);
    return ExitCode::finished;
  };
}

}  // namespace bulkley
