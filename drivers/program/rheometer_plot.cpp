#include "program/rheometer_plot.hpp"

#include "io/files/text_file.hpp"
#include "program/python_tool.hpp"

namespace bulkley {

void draw(const PlotRequest& request) {
  write_text_atomically(request.file,
                        run_python_tool({"plot-rheometer", "--kind", request.kind, "--title", request.title, "-", "-"},
                                        request.csv, "picture " + request.file));
}

}  // namespace bulkley
