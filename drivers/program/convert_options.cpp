#include "program/convert_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <set>

#include "config/nearest.hpp"
#include "io/files/text_file.hpp"
#include "rheometer/number_list.hpp"

namespace bulkley {

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> formats{"vtu", "vtkhdf", "csv"};  // in the order of ConvertFormat
const std::string frame_prefix = "frame_";

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(separator, start), text.size());
    parts.push_back(text.substr(start, end - start));
    start = end + 1;
  }
  return parts;
}

/// One end of a range; `open` if nothing is written.
double region_end(const std::string& text, double open) {
  if (text.empty()) return open;
  if (const auto number = rheometer::parse_number(text)) return *number;
  throw UsageError(fmt::format("--region: '{}' is not a number", text));
}

std::optional<long> whole_number(const std::string& text) {
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0) return std::nullopt;
  return value;
}

[[noreturn]] void refuse_frames(const std::string& text) {
  throw UsageError(
      fmt::format("--frames: '{}' must be 'all', 'last', numbers of frames as 0,10,20, or first:end or "
                  "first:end:step (without the frame 'end', as in Python)",
                  text));
}

/// Whether --frames takes the frame of this number.
class FrameChoice {
 public:
  explicit FrameChoice(const std::string& text) : text_(text) {
    if (text == "all" || text == "last") return;
    const std::vector<std::string> range = split(text, ':');
    if (range.size() == 1) {
      for (const std::string& part : split(text, ',')) listed_.push_back(number(part));
      return;
    }
    if (range.size() > 3) refuse_frames(text);
    if (!range[0].empty()) first_ = number(range[0]);
    if (!range[1].empty()) end_ = number(range[1]);
    if (range.size() == 3 && !range[2].empty()) step_ = number(range[2]);
    if (step_ < 1 || end_ <= first_) refuse_frames(text);
  }

  std::vector<std::string> of(const std::string& folder, const std::vector<std::string>& names) const {
    if (text_ == "last") return {names.back()};
    std::vector<std::string> chosen;
    std::set<long> found;
    for (const std::string& name : names) {
      const long n = number_in(name, frame_prefix);
      const bool listed = std::find(listed_.begin(), listed_.end(), n) != listed_.end();
      if (listed_.empty() ? n >= first_ && n < end_ && (n - first_) % step_ == 0 : listed) {
        chosen.push_back(name);
        found.insert(n);
      }
    }
    for (const long n : listed_)
      if (!found.contains(n))
        throw UsageError(fmt::format("--frames: '{}' has no frame {}; it has {} to {}", folder, n,
                                     number_in(names.front(), frame_prefix), number_in(names.back(), frame_prefix)));
    if (chosen.empty())
      throw UsageError(fmt::format("--frames: '{}' takes none of the frames in '{}', which are {} to {}", text_, folder,
                                   number_in(names.front(), frame_prefix), number_in(names.back(), frame_prefix)));
    return chosen;
  }

 private:
  long number(const std::string& part) const {
    const auto value = whole_number(part);
    if (!value) refuse_frames(text_);
    return *value;
  }

  std::string text_;
  std::vector<long> listed_;
  long first_ = 0, end_ = std::numeric_limits<long>::max(), step_ = 1;
};

std::vector<std::string> files_of(const std::string& input, const ConvertOptions& options) {
  std::error_code ignored;
  if (!fs::exists(input, ignored)) throw UsageError(fmt::format("{}: no such file or folder", input));
  const FrameChoice choice(options.frames);
  if (!fs::is_directory(input, ignored)) {
    if (options.frames != "all")
      throw UsageError(fmt::format("--frames is for the folder of a run, and '{}' is a file", input));
    return {input};
  }
  const std::vector<std::string> names = numbered_files(input, frame_prefix, ".h5");
  if (names.empty())
    throw UsageError(
        fmt::format("{}: holds no frames (output.frame_interval); a checkpoint is converted by its own name", input));
  std::vector<std::string> files;
  for (const std::string& name : choice.of(input, names)) files.push_back(path_in(input, name));
  return files;
}

std::string extension_of(ConvertFormat format) { return "." + formats[static_cast<std::size_t>(format)]; }

/// ".hdf" is the extension by which ParaView 5.11 recognises VTK's HDF5 files.
bool names_file(const std::string& out, ConvertFormat format) {
  const std::string extension = fs::path(out).extension().string();
  return extension == extension_of(format) || (format == ConvertFormat::vtkhdf && extension == ".hdf");
}

void check_extension(const ConvertOptions& options, ConvertFormat format) {
  const std::string extension = fs::path(options.out).extension().string();
  for (const std::string& other : formats)
    if (extension == "." + other && !names_file(options.out, format))
      throw UsageError(fmt::format("--out: '{}' does not end in {}, as --to {} makes files", options.out,
                                   extension_of(format), options.format));
}

void make_folder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder, error))
    throw RunError(fmt::format("cannot make the folder '{}': {}", folder, error ? error.message() : "it is a file"));
}

}  // namespace

ConvertFormat parse_format(const std::string& text) {
  const auto found = std::find(formats.begin(), formats.end(), text);
  if (found == formats.end())
    throw UsageError(fmt::format("--to: there is no format '{}'{}", text, config::suggestion(text, formats)));
  return static_cast<ConvertFormat>(found - formats.begin());
}

Selection parse_selection(const ConvertOptions& options) {
  Selection selection;
  selection.every = options.every;
  if (!options.fields.empty()) {
    selection.fields = split(options.fields, ',');
    if (std::find(selection.fields.begin(), selection.fields.end(), "") != selection.fields.end())
      throw UsageError(fmt::format("--fields: '{}' must be names with commas between them", options.fields));
  }
  if (options.region.empty()) return selection;
  const std::vector<std::string> axes = split(options.region, ',');
  if (axes.size() != 3)
    throw UsageError(fmt::format(
        "--region: '{}' must be x0:x1,y0:y1,z0:z1 in metres; an end that is left out is open, as in 0.1:,:,:0.05",
        options.region));
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<std::string> ends = split(axes[static_cast<std::size_t>(axis)], ':');
    if (ends.size() != 2)
      throw UsageError(fmt::format("--region: '{}' must be lower:upper in metres", axes[static_cast<std::size_t>(axis)]));
    double& lower = selection.region.lower[axis];
    double& upper = selection.region.upper[axis];
    lower = region_end(ends[0], lower);
    upper = region_end(ends[1], upper);
    if (!(lower < upper)) throw UsageError(fmt::format("--region: {} must be below {}", lower, upper));
  }
  return selection;
}

std::vector<ConvertJob> plan_conversion(const ConvertOptions& options, ConvertFormat format) {
  std::vector<std::string> files;
  for (const std::string& input : options.inputs)
    for (const std::string& file : files_of(input, options)) files.push_back(file);
  check_extension(options, format);
  if (names_file(options.out, format)) {
    if (files.size() > 1)
      throw UsageError(
          fmt::format("--out: '{}' is one file, and {} are to be converted: name a folder", options.out, files.size()));
    if (const std::string folder = fs::path(options.out).parent_path().string(); !folder.empty()) make_folder(folder);
    return {{files.front(), options.out}};
  }
  std::vector<ConvertJob> jobs;
  std::set<std::string> outputs;
  for (const std::string& file : files) {
    jobs.push_back({file, path_in(options.out, fs::path(file).stem().string() + extension_of(format))});
    if (!outputs.insert(jobs.back().output).second)
      throw UsageError(fmt::format("two of the inputs would become '{}': convert them one by one", jobs.back().output));
  }
  make_folder(options.out);
  return jobs;
}

std::string series_path(const ConvertOptions& options, const std::vector<ConvertJob>& jobs, ConvertFormat format) {
  if (format != ConvertFormat::vtu || names_file(options.out, format)) return "";
  return jobs.empty() ? "" : path_in(options.out, "frames.pvd");
}

}  // namespace bulkley
