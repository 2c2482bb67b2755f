#pragma once
// Small text files that a reader finds whole or not at all, and the folder they lie in. One process; not collective.

#include <string>
#include <vector>

namespace bulkley {

/// `folder`/`name`.
std::string path_in(const std::string& folder, const std::string& name);

/// Writes `text` under a temporary name in the folder of `path`, flushes it to disk and renames it, so that a reader sees
/// the old file or the new one, never a part. `writer`: a part of the temporary name, for several that may write at once.
/// Throws RunError.
void write_text_atomically(const std::string& path, const std::string& text, const std::string& writer = "");

/// The same for who may be killed at any moment: renames the text before it is flushed, so that readers find it even if the disk is slow.
/// It outlives the process as soon as it is renamed, the machine once this has returned. Throws RunError.
void write_text_before_end(const std::string& path, const std::string& text, const std::string& writer = "");

/// The whole file. Throws RunError.
std::string read_text(const std::string& path);

/// Flushes a file to disk (fsync). Throws RunError.
void sync_file(const std::string& path);
/// Makes renames and removals in a folder durable (fsync of the folder; file systems that cannot do it are let be). Throws
/// RunError.
void sync_folder(const std::string& folder);

/// Renames `from` to `to`, which must lie in the same folder, and makes that durable. Throws RunError.
void rename_durably(const std::string& from, const std::string& to);

/// Removes a file if it is there. Throws RunError.
void remove_file(const std::string& path);

/// Removes what writes that never came to their end left in `folder`: files of a run with ".tmp" behind their names. Throws
/// RunError.
void remove_leftovers(const std::string& folder);

/// A text file that grows at its end; what is appended is handed to the operating system at once.
class GrowingFile {
 public:
  GrowingFile() = default;
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;
  /// Opens a file that exists. Throws RunError.
  void open(const std::string& path);
  /// Throws RunError; then a part of `text` may be at the end of the file.
  void append(const std::string& text);
  /// Flushes what was appended to disk. Throws RunError.
  void sync();

 private:
  std::string path_;
  int file_ = -1;
};

/// Names (not paths) of the files in `folder` that read `prefix`, digits, `suffix`, by ascending number; empty when the
/// folder is not there. Throws RunError when it cannot be read.
std::vector<std::string> numbered_files(const std::string& folder, const std::string& prefix, const std::string& suffix);

/// Lines joined by, and text cut at, newlines.
std::string join_lines(const std::vector<std::string>& lines);
std::vector<std::string> split_lines(const std::string& text);

/// The number in a name of numbered_files.
long number_in(const std::string& name, const std::string& prefix);

}  // namespace bulkley
