#pragma once
// Pictures of what a rheometer measured, drawn by plot_rheometer.py.

#include <string>

namespace bulkley {

struct PlotRequest {
  std::string kind;   ///< a mode of the rheometer, or "fit"
  std::string title;  ///< of the picture
  std::string csv;    ///< the table, as text
  std::string file;   ///< the PNG to write
};

/// Draws with the first Python that has matplotlib: $BULKLEY_PYTHON if set, else python3 on the PATH, else /usr/bin/python3.
/// Throws RunError, one sentence, if there is none or the script fails. Not collective.
void draw(const PlotRequest& request);

}  // namespace bulkley
