#pragma once
// Pictures for a page that must stand alone: their bytes within it.

#include <cstddef>
#include <string>
#include <vector>

namespace bulkley {

struct EmbeddedPicture {
  std::string name;  ///< within the folder
  std::string url;   ///< data:image/png;base64,...
};

struct EmbeddedPictures {
  std::vector<EmbeddedPicture> pictures;
  std::size_t n_found = 0;  ///< in the folder; those that are too large or too many are left out
};

/// PNG files of `folder` and the folders in it: at most 12, evenly from all, none above 3 MB, together at most 12 MB. Not
/// collective.
EmbeddedPictures embed_pictures(const std::string& folder);

/// Bytes as base64 (RFC 4648). Not collective.
std::string base64(const std::string& bytes);

}  // namespace bulkley
