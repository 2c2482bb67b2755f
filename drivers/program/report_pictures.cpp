#include "program/report_pictures.hpp"

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "io/files/text_file.hpp"
#include "program/run_folder.hpp"

namespace bulkley {

namespace {

constexpr std::size_t most_pictures = 12, most_bytes_each = 3'000'000, most_bytes = 12'000'000;

// Empty if it is too large, cannot be read or is no PNG.
std::string png_bytes(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error || size > most_bytes_each) return {};
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return bytes.starts_with("\x89PNG\r\n\x1a\n") ? bytes : std::string();
}

}  // namespace

std::string base64(const std::string& bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(bytes.size() / 3 * 4 + 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - at);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < n ? static_cast<unsigned char>(bytes[at + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= n ? digits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

EmbeddedPictures embed_pictures(const std::string& folder) {
  const std::vector<std::string> names = pictures_in(folder);
  EmbeddedPictures result;
  result.n_found = names.size();
  const std::size_t n = std::min(names.size(), most_pictures);
  std::size_t total = 0;
  for (std::size_t k = 0; k < n; ++k) {
    // The last ones of equal parts, so that the last of all is there.
    const std::string& name = names[(k + 1) * names.size() / n - 1];
    const std::string bytes = png_bytes(path_in(folder, name));
    if (bytes.empty() || total + bytes.size() > most_bytes) continue;
    total += bytes.size();
    result.pictures.push_back({name, "data:image/png;base64," + base64(bytes)});
  }
  return result;
}

}  // namespace bulkley
