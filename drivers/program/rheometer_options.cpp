#include "program/rheometer_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "bulkley/base/error.hpp"
#include "config/nearest.hpp"
#include "material/preset.hpp"

namespace bulkley {

namespace {

using rheometer::parse_number;

// The modes that use an option. "fit" is not a mode but takes part here.
const std::map<std::string, std::vector<std::string>>& users() {
  static const std::map<std::string, std::vector<std::string>> table = {
      {"--rates", {"shear", "extension", "planar", "startup", "thixotropy", "magnetic"}},
      {"--strain", {"extension", "planar", "startup", "relaxation"}},
      {"--stresses", {"creep"}},
      {"--duration", {"relaxation", "creep"}},
      {"--durations", {"thixotropy"}},
      {"--amplitudes", {"oscillation"}},
      {"--frequencies", {"oscillation"}},
      {"--strain-per-step", {"shear", "extension", "planar", "startup", "creep", "oscillation", "thixotropy", "magnetic"}},
      {"--field", {"shear", "extension", "planar", "startup", "relaxation", "creep", "oscillation", "thixotropy"}},
      {"--fields", {"magnetic"}},
      {"--largest-strain", {"shear", "extension", "planar", "creep"}},
      {"--tolerance", {"shear", "extension", "planar", "oscillation"}},
      {"--points", {"extension", "planar", "startup", "relaxation", "creep", "thixotropy"}},
      {"--weights", {"fit"}},
      {"--fix", {"fit"}},
      {"--range", {"fit"}},
      {"--name", {"fit"}},
      {"--density", {"fit"}},
      {"--speed", {"fit"}},
  };
  return table;
}

const std::vector<std::string> modes = {"shear", "extension",   "planar",     "startup", "relaxation",
                                        "creep", "oscillation", "thixotropy", "magnetic"};

template <class Number>
void set_number(const std::string& option, const std::string& text, bool zero_allowed, Number& target) {
  const auto value = parse_number(text);
  if (!value || *value < 0.0 || (*value == 0.0 && !zero_allowed))
    throw UsageError(fmt::format("{} '{}': not a number {} 0", option, text, zero_allowed ? "of at least" : "above"));
  target = *value;
}

// An option that takes a number above 0, or of at least 0.
template <class Number>
CLI::Option* add_number(CLI::App& app, const std::string& option, Number& target, const std::string& text,
                        bool zero_allowed = false) {
  return app
      .add_option_function<std::string>(
          option, [=, &target](const std::string& given) { set_number(option, given, zero_allowed, target); }, text)
      ->type_name("NUMBER");
}

void declare_measurement(CLI::App& app, RheometerOptions& o) {
  app.add_option("scene", o.scene, "scene file that holds the material")->type_name("SCENE.toml");
  app.add_option("--material", o.material, "name of the material in the scene; not needed if there is only one");
  app.add_option("--preset", o.preset, "a material without a scene: " + preset_names());
  app.add_option("--set", o.overrides, "override a key of the scene: key.path=value; may be given several times")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--mode", o.mode, "what to measure")
      ->type_name(fmt::format("{}", fmt::join(modes, "|")))
      ->capture_default_str();
  const char* list = "LIST";
  app.add_option("--rates", o.rates, "1/s, as 0.01:100:20 (logarithmic) or 1,2,5; thixotropy: three")->type_name(list);
  app.add_option("--stresses", o.stresses, "creep: stresses to hold, Pa")->type_name(list);
  app.add_option("--amplitudes", o.amplitudes, "oscillation: amplitudes of the strain")->type_name(list);
  app.add_option("--frequencies", o.frequencies, "oscillation: angular frequencies, rad/s")->type_name(list);
  add_number(app, "--strain", o.strain, "startup: last strain; relaxation: its step; extension, planar: a curve up to it");
  add_number(app, "--duration", o.duration, "relaxation, creep: time, s");
  app.add_option("--durations", o.durations, "thixotropy: the three intervals, s")->type_name(list);
  add_number(app, "--pressure", o.pressure, "compress the specimen to this pressure first, Pa", true);
  add_number(app, "--field", o.field, "strength H of the magnetic field inside the specimen, A/m", true);
  app.add_option("--fields", o.fields, "magnetic: field strengths, A/m")->type_name(list);
  add_number(app, "--strain-per-step", o.strain_per_step,
             "largest strain of one step of the kernel (2e-4; oscillation 5e-4)");
  add_number(app, "--largest-strain", o.largest_strain, "where to stop waiting for a steady state (100), or creep (20)");
  add_number(app, "--tolerance", o.tolerance, "relative change that counts as steady (default 1e-5)");
  app.add_option("--points", o.points, "rows of a curve over time (default 200)")->check(CLI::Range(2, 100'000));
  app.add_option("--out", o.out, "write the CSV here (default: to stdout)")->type_name("FILE.csv");
  app.add_option("--plot", o.plot, "also plot it; needs python3 with matplotlib")->type_name("FILE.png");
}

void declare_fit(CLI::App& app, RheometerOptions& o) {
  CLI::App& fit = *app.add_option_group("fit", "Herschel-Bulkley parameters from a measured flow curve");
  fit.add_option("--fit", o.fit, "columns shear_rate (1/s), stress (Pa) and optionally error (Pa)")->type_name("FILE.csv");
  fit.add_option("--weights", o.weights, "relative, uniform, or error (the file's column)")->capture_default_str();
  fit.add_option("--fix", o.fixed, "give yield_stress, consistency or flow_index instead of fitting it")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  fit.add_option("--range", o.range, "fit these shear rates only, 1/s")->type_name("LOWER:UPPER");
  fit.add_option("--name", o.name, "of the material in the printed scene (default: the file's)");
  add_number(fit, "--density", o.density, "for the printed scene, kg/m^3 (default 1000)");
  add_number(fit, "--speed", o.speed, "largest speed in the scene, m/s (default 1)");
}

}  // namespace

void declare_rheometer_options(CLI::App& app, RheometerOptions& options) {
  declare_measurement(app, options);
  declare_fit(app, options);
  app.footer("Modes, columns and formulas: docs/rheometer.md.");
}

void check_rheometer_options(const CLI::App& app, const RheometerOptions& o) {
  if (std::find(modes.begin(), modes.end(), o.mode) == modes.end())
    throw UsageError(fmt::format("--mode '{}': no such mode{}", o.mode, config::suggestion(o.mode, modes)));
  const bool fits = !o.fit.empty();
  for (const auto& [option, who] : users()) {
    if (app.count(option) == 0) continue;
    const std::string mode = fits ? "fit" : o.mode;
    if (std::find(who.begin(), who.end(), mode) != who.end()) continue;
    if (who.front() == "fit") throw UsageError(fmt::format("{}: only with --fit", option));
    if (fits) throw UsageError(fmt::format("{}: not with --fit", option));
    throw UsageError(fmt::format("{}: only with --mode {}", option, fmt::join(who, ", ")));
  }
  if (!fits) return;
  for (const char* option : {"--mode", "--material", "--preset", "--set", "--pressure", "--field", "scene"})
    if (app.count(option) > 0) throw UsageError(fmt::format("{}: not with --fit", option));
}

rheometer::FitSettings fit_settings(const RheometerOptions& o) {
  rheometer::FitSettings settings;
  const std::map<std::string, rheometer::Weights> weights = {{"relative", rheometer::Weights::relative},
                                                             {"uniform", rheometer::Weights::uniform},
                                                             {"error", rheometer::Weights::error}};
  const auto weight = weights.find(o.weights);
  if (weight == weights.end())
    throw UsageError(fmt::format("--weights '{}': must be relative, uniform or error", o.weights));
  settings.weights = weight->second;
  if (!o.range.empty()) settings.rates = rheometer::parse_range(o.range, "--range");
  for (const std::string& each : o.fixed) {
    const std::string name = each.substr(0, each.find('='));
    const auto value = parse_number(each.substr(std::min(each.size(), name.size() + 1)));
    if (!value || *value < 0.0)
      throw UsageError(fmt::format("--fix '{}': not NAME=VALUE with a number of at least 0", each));
    if (name == "yield_stress") {
      settings.yield_stress = value;
    } else if (name == "consistency") {
      settings.consistency = value;
    } else if (name == "flow_index") {
      if (*value < rheometer::smallest_flow_index || *value > rheometer::largest_flow_index)
        throw UsageError(fmt::format("--fix '{}': flow_index must be between {:g} and {:g}", each,
                                     rheometer::smallest_flow_index, rheometer::largest_flow_index));
      settings.flow_index = value;
    } else {
      throw UsageError(fmt::format("--fix '{}': no such parameter{}", each,
                                   config::suggestion(name, {"yield_stress", "consistency", "flow_index"})));
    }
  }
  return settings;
}

}  // namespace bulkley
