#pragma once
// The page about a run: one file of HTML that needs no other, no network and no script. Not collective.

#include <string>

namespace bulkley {

/// Reads the output folder and writes its page as text. Throws UsageError when `folder` holds no run.
std::string report_page(const std::string& folder);

}  // namespace bulkley
