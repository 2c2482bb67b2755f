// `bulkley rheometer`: one material point of the solver in a rheometer, and the fit of a measured flow curve.

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "config/nearest.hpp"
#include "io/files/text_file.hpp"
#include "material/preset.hpp"
#include "program/commands.hpp"
#include "program/rheometer_options.hpp"
#include "program/rheometer_plot.hpp"
#include "rheometer/creep.hpp"
#include "rheometer/fit_report.hpp"
#include "rheometer/magnetic.hpp"
#include "rheometer/oscillation.hpp"
#include "rheometer/steady.hpp"
#include "rheometer/transient.hpp"

namespace bulkley {

namespace {

using namespace rheometer;

std::vector<double> list(const std::string& given, const std::string& otherwise, const std::string& option,
                         bool zero_allowed = false) {
  return parse_number_list(given.empty() ? otherwise : given, option, zero_allowed);
}

std::array<double, 3> three(const std::string& given, const std::string& otherwise, const std::string& option,
                            bool zero_allowed) {
  const std::vector<double> values = list(given, otherwise, option, zero_allowed);
  if (values.size() != 3)
    throw UsageError(fmt::format("{} '{}': thixotropy needs three numbers, one an interval", option, given));
  return {values[0], values[1], values[2]};
}

template <class T>
void take(const std::optional<T>& given, T& target) {
  if (given) target = *given;
}

Measurement run_steady(const Material& material, Flow flow, const RheometerOptions& o) {
  SteadySettings s{.flow = flow, .rates = list(o.rates, "0.01:100:20", "--rates"), .pressure = o.pressure};
  take(o.strain_per_step, s.strain_per_step);
  take(o.largest_strain, s.largest_strain);
  take(o.tolerance, s.tolerance);
  if (o.largest_strain) s.smallest_strain = std::min(s.smallest_strain, *o.largest_strain);
  return measure_steady(material, s);
}

Measurement run_start_up(const Material& material, Flow flow, const RheometerOptions& o) {
  StartUpSettings s{.flow = flow, .rates = list(o.rates, "1", "--rates"), .pressure = o.pressure};
  take(o.strain, s.strain);
  take(o.strain_per_step, s.strain_per_step);
  take(o.points, s.n_points);
  return measure_start_up(material, s);
}

Measurement run_relaxation(const Material& material, const RheometerOptions& o) {
  RelaxationSettings s{.pressure = o.pressure};
  take(o.strain, s.strain);
  take(o.duration, s.duration);
  take(o.points, s.n_points);
  return measure_relaxation(material, s);
}

Measurement run_creep(const Material& material, const RheometerOptions& o) {
  if (o.stresses.empty()) throw UsageError("--mode creep needs --stresses, for example --stresses 10,20,40 (Pa)");
  CreepSettings s{.stresses = list(o.stresses, "", "--stresses"), .pressure = o.pressure};
  take(o.duration, s.duration);
  take(o.largest_strain, s.largest_strain);
  take(o.strain_per_step, s.strain_per_step);
  take(o.points, s.n_points);
  return measure_creep(material, s);
}

Measurement run_oscillation(const Material& material, const RheometerOptions& o) {
  OscillationSettings s{.amplitudes = list(o.amplitudes, "0.01", "--amplitudes"),
                        .frequencies = list(o.frequencies, "0.1:100:10", "--frequencies"),
                        .pressure = o.pressure};
  take(o.strain_per_step, s.strain_per_step);
  take(o.tolerance, s.tolerance);
  return measure_oscillation(material, s);
}

Measurement run_thixotropy(const Material& material, const RheometerOptions& o) {
  ThixotropySettings s{.rates = three(o.rates, "0.1,10,0.1", "--rates", true),
                       .durations = three(o.durations, "10,10,10", "--durations", false),
                       .pressure = o.pressure};
  take(o.strain_per_step, s.strain_per_step);
  take(o.points, s.n_points);
  return measure_thixotropy(material, s);
}

Measurement run_magnetic(const NamedMaterial& named, const RheometerOptions& o) {
  MagneticSettings s{.fields = list(o.fields, "1000:500000:28", "--fields", true)};
  const std::vector<double> rates = list(o.rates, "0.01", "--rates");
  if (rates.size() != 1) throw UsageError(fmt::format("--rates '{}': --mode magnetic takes one rate", o.rates));
  s.rate = rates.front();
  take(o.strain_per_step, s.strain_per_step);
  if (o.pressure > 0.0) throw UsageError("--pressure: not with --mode magnetic");
  return measure_magnetic(named, s);
}

// The table with the field as one more column.
Measurement with_field(Measurement measurement, double field) {
  measurement.table.columns.emplace_back("magnetic_field_strength");
  for (std::vector<double>& row : measurement.table.rows) row.push_back(field);
  return measurement;
}

// A solid has no steady extension; it gets the curve.
bool wants_curve(const Material& material, const RheometerOptions& o) {
  return (o.mode == "extension" || o.mode == "planar") && (o.strain || !flows(material));
}

void check_curve_options(const RheometerOptions& o) {
  if (o.largest_strain || o.tolerance)
    throw UsageError("--largest-strain and --tolerance: not with a curve of stress over strain, which ends at --strain");
}

// Without a magnetic field, or with a material as it is in one.
Measurement measure_unmagnetised(const Material& material, const RheometerOptions& o) {
  const Flow flow = o.mode == "extension" ? Flow::uniaxial_extension
                    : o.mode == "planar"  ? Flow::planar_extension
                                          : Flow::simple_shear;
  if (wants_curve(material, o)) {
    check_curve_options(o);
    return run_start_up(material, flow, o);
  }
  if (o.mode == "startup") return run_start_up(material, flow, o);
  if (o.mode == "relaxation") return run_relaxation(material, o);
  if (o.mode == "creep") return run_creep(material, o);
  if (o.mode == "oscillation") return run_oscillation(material, o);
  if (o.mode == "thixotropy") return run_thixotropy(material, o);
  if (o.points) throw UsageError("--points: only with a curve of stress over strain; give --strain");
  return run_steady(material, flow, o);
}

Measurement measure(const NamedMaterial& named, const RheometerOptions& o) {
  if (o.mode == "magnetic") return run_magnetic(named, o);
  if (!o.field) return measure_unmagnetised(named.material, o);
  if (!named.magnetisation) throw UsageError(fmt::format("--field: material '{}' is not magnetic", named.name));
  return with_field(measure_unmagnetised(at_field(named.material, *o.field), o), *o.field);
}

NamedMaterial from_scene(const Scene& scene, const RheometerOptions& o) {
  std::vector<std::string> names;
  for (const NamedMaterial& each : scene.materials) {
    if (each.name == o.material || (o.material.empty() && scene.materials.size() == 1)) return each;
    names.push_back(each.name);
  }
  if (o.material.empty())
    throw UsageError(fmt::format("{}: holds several materials; choose one with --material: {}", o.scene,
                                 config::quoted_list(names, '\'')));
  throw UsageError(fmt::format("--material '{}': not in {}{}", o.material, o.scene, config::suggestion(o.material, names)));
}

// Collective.
NamedMaterial chosen_material(const Comm& comm, const RheometerOptions& o) {
  if (o.scene.empty() == o.preset.empty())
    throw UsageError("rheometer: give a scene file and --material, or --preset, or --fit; see 'bulkley rheometer --help'");
  if (!o.scene.empty()) return from_scene(SceneArguments{o.scene, o.overrides}.load(comm), o);
  if (!o.material.empty()) throw UsageError("--material: not with --preset, which is a material");
  if (!o.overrides.empty()) throw UsageError("--set: only with a scene file");
  const auto preset = find_preset(o.preset);
  if (!preset) throw UsageError(fmt::format("--preset '{}': no such preset; known: {}", o.preset, preset_names()));
  return {o.preset, preset->material, caveat(*preset), preset->magnetisation};
}

// Early, so that a measurement is not lost.
void make_folder_of(const std::string& file) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) throw UsageError(fmt::format("{}: its folder cannot be made: {}", file, error.message()));
  if (std::filesystem::is_directory(file, error)) throw UsageError(fmt::format("{}: is a folder", file));
}

void make_folders(const RheometerOptions& o) {
  for (const std::string* file : {&o.out, &o.plot})
    if (!file->empty()) make_folder_of(*file);
}

// How far the stresses lie from theory at most; empty if there is no theory.
std::string analytic_difference(const Table& table) {
  if (!table.has("analytic_stress")) return {};
  const std::vector<double> measured = table.column(table.has("shear_stress") ? "shear_stress" : "tensile_stress");
  const std::vector<double> truth = table.column("analytic_stress");
  double largest = 0.0, difference = 0.0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    largest = std::max(largest, std::fabs(truth[k]));
    difference = std::max(difference, std::fabs(measured[k] - truth[k]));
  }
  return fmt::format("; largest difference from the analytic stress {:.2g} of its largest value", difference / largest);
}

void deliver(const RheometerOptions& o, const NamedMaterial& named, const Measurement& measurement) {
  const std::string csv = csv_text(measurement.table);
  if (!named.caveat.empty()) fmt::print(stderr, "rheometer: {}\n", named.caveat);
  for (const std::string& remark : measurement.remarks) fmt::print(stderr, "rheometer: {}\n", remark);
  if (o.out.empty()) {
    fmt::print("{}", csv);
    std::fflush(stdout);
  } else {
    write_text_atomically(o.out, csv);
    fmt::print("{}: {} rows{}\n", o.out, measurement.table.rows.size(), analytic_difference(measurement.table));
  }
  if (o.plot.empty()) return;
  const std::string in_field = o.field ? fmt::format(", H = {:g} A/m", *o.field) : "";
  draw({o.mode, fmt::format("{} ({}){}", named.name, law_name(named.material), in_field), csv, o.plot});
  if (!o.out.empty()) fmt::print("{}\n", o.plot);
}

void fit_file(const RheometerOptions& o, const std::string& text) {
  const FitSettings settings = fit_settings(o);
  Suggestions suggestions{o.name.empty() ? material_name(o.fit) : o.name, o.density, o.speed};
  if (material_name(suggestions.name) != suggestions.name)
    throw UsageError(fmt::format("--name '{}': letters, digits, '_' and '-' only", o.name));
  const MeasuredCurve curve = parse_measured_curve(text, o.fit);
  const Fit fit = [&] {
    try {
      return fit_herschel_bulkley(curve, settings);
    } catch (const UsageError& error) {
      throw UsageError(fmt::format("{}: {}", o.fit, error.what()));
    }
  }();
  fmt::print("{}\n{}", fit_text(fit, settings), scene_snippet(fit, suggestions));
  std::fflush(stdout);
  const std::string csv = csv_text(fit_table(fit));
  if (!o.out.empty()) write_text_atomically(o.out, csv);
  if (!o.plot.empty())
    draw({"fit",
          fmt::format("{}\nyield_stress = {:.4g} Pa, consistency = {:.4g} Pa s^n, flow_index = {:.4g}", suggestions.name,
                      fit.yield_stress.value, fit.consistency.value, fit.flow_index.value),
          csv, o.plot});
}

}  // namespace

Command add_rheometer(CLI::App& app) {
  auto o = std::make_shared<RheometerOptions>();
  declare_rheometer_options(app, *o);
  return [o, &app](const Comm& comm) {
    check_rheometer_options(app, *o);
    if (!o->fit.empty()) {
      const std::string text = read_on_root(comm, o->fit);
      root_guard(comm, [&] {
        make_folders(*o);
        fit_file(*o, text);
      });
      return ExitCode::finished;
    }
    const NamedMaterial named = chosen_material(comm, *o);
    root_guard(comm, [&] {
      make_folders(*o);
      deliver(*o, named, measure(named, *o));
    });
    return ExitCode::finished;
  };
}

}  // namespace bulkley
