#pragma once
// The command line of `bulkley convert`, as text and as what it means. Not collective.

#include <string>
#include <vector>

#include "io/convert/convert.hpp"

namespace bulkley {

struct ConvertOptions {
  std::vector<std::string> inputs;
  std::string format, out, fields, region, frames = "all";
  GlobalIndex every = 1;
};

/// Throws UsageError, as all functions here.
ConvertFormat parse_format(const std::string& text);
/// --fields, --region and --every.
Selection parse_selection(const ConvertOptions& options);

/// One file to read and one to write.
struct ConvertJob {
  std::string input, output;
};

/// Finds the inputs, creates the output folder, and assigns the output files. To be called on one rank.
std::vector<ConvertJob> plan_conversion(const ConvertOptions& options, ConvertFormat format);

/// The list of VTK files that belongs to the jobs' outputs; empty where there is to be none.
std::string series_path(const ConvertOptions& options, const std::vector<ConvertJob>& jobs, ConvertFormat format);

}  // namespace bulkley
