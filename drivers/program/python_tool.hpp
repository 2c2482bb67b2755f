#pragma once
// The tools of the Python package (drivers/python) that this program calls: text goes in, a file's bytes come out.

#include <string>
#include <vector>

namespace bulkley {

/// What the tool `words` of the package writes to its standard output when `input` is on its standard input. It runs in the
/// first Python that has what the tool imports: $BULKLEY_PYTHON if set, else python3 on the PATH, else /usr/bin/python3.
/// Throws RunError, one sentence that begins with "no " and `product`, if there is none or the tool fails. Not collective.
std::string run_python_tool(const std::vector<std::string>& words, const std::string& input, const std::string& product);

}  // namespace bulkley
