#include "io/files/growing_document.hpp"

#include <unistd.h>

#include <filesystem>

#include <fmt/format.h>

#include "bulkley/base/error.hpp"
#include "io/files/placed_file.hpp"
#include "io/files/text_file.hpp"

namespace bulkley {

namespace {

GlobalIndex size_of(const std::string& text) { return static_cast<GlobalIndex>(text.size()); }

}  // namespace

GrowingDocument::GrowingDocument(std::string path, std::string opening, std::string closing)
    : path_(std::move(path)),
      next_(path_ + ".next"),
      previous_(path_ + ".previous"),
      opening_(std::move(opening)),
      closing_(std::move(closing)) {}

GrowingDocument::~GrowingDocument() {
  if (has_next_) remove_next();
}

// Nothing is lost where they cannot be removed: begin() removes them.
void GrowingDocument::remove_next() {
  ::unlink(next_.c_str());
  ::unlink(previous_.c_str());
  has_next_ = false;
}

void GrowingDocument::begin(std::span<const std::string> parts) {
  has_next_ = false;
  remove_file(next_);
  remove_file(previous_);
  last_.clear();
  if (parts.empty()) return remove_file(path_);
  std::string text = opening_;
  for (const std::string& part : parts) text += part;
  write_text_atomically(path_, text + closing_);
  last_ = parts.back();
  last_place_ = size_of(text) - size_of(last_);
}

void GrowingDocument::add(const std::string& part) {
  if (last_.empty()) return begin({&part, 1});
  try {
    write_next(last_ + part + closing_);
    has_next_ = ::link(path_.c_str(), previous_.c_str()) == 0;
    rename_durably(next_, path_);
  } catch (const RunError&) {
    remove_next();
    throw;
  }
  last_place_ += size_of(last_);
  last_ = part;
  if (has_next_ && ::rename(previous_.c_str(), next_.c_str()) != 0) remove_next();
}

/// The next document: what both files have in common, and `tail`.
void GrowingDocument::write_next(const std::string& tail) {
  if (!has_next_) {
    std::error_code error;
    std::filesystem::copy_file(path_, next_, std::filesystem::copy_options::overwrite_existing, error);
    if (!error) std::filesystem::resize_file(next_, static_cast<std::uintmax_t>(last_place_), error);
    if (error) throw RunError(fmt::format("cannot write '{}': {}", next_, error.message()));
  }
  const PlacedFile file(next_);
  file.write(tail.data(), size_of(tail), last_place_);
  file.sync();
}

}  // namespace bulkley
