#pragma once
// Pictures of what a rheometer measured, drawn by the Python package.

#include <string>

namespace bulkley {

struct PlotRequest {
  std::string kind;   ///< a mode of the rheometer, or "fit"
  std::string title;  ///< of the picture
  std::string csv;    ///< the table, as text
  std::string file;   ///< the PNG to write
};

/// Writes the picture. Throws RunError, one sentence, if there is no Python with matplotlib (see run_python_tool), if drawing
/// fails or if the file cannot be written. Not collective.
void draw(const PlotRequest& request);

}  // namespace bulkley
