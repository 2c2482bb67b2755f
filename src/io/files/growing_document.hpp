#pragma once
// A text file of an opening, parts and a closing that gets parts at its end and is whole at every moment. One process; not
// collective.
//
// A part cannot be written over the closing in place: a process that is killed, or a disk that is full, may end a write at any
// byte, and the file would have no closing. So there are two files that take turns, the document and one named `.next` that is
// a part behind. The latter gets the part that it lacks, the new one and the closing, is flushed to disk, and takes the
// document's name; the document that was keeps a second name through that and is the next `.next`. What bears the document's
// name is therefore always complete and on disk, and a part costs its own bytes and those of the part before.

#include <span>
#include <string>

#include "bulkley/base/types.hpp"

namespace bulkley {

class GrowingDocument {
 public:
  GrowingDocument(std::string path, std::string opening, std::string closing);
  ~GrowingDocument();  ///< Removes what belongs to it beside the document.
  GrowingDocument(const GrowingDocument&) = delete;
  GrowingDocument& operator=(const GrowingDocument&) = delete;

  /// Writes a document of these parts in the place of what is there, and removes what an earlier process has left beside it. No
  /// parts: there is no file. Throws RunError, and then an earlier document is untouched.
  void begin(std::span<const std::string> parts);

  /// Adds a part. On a file system without hard links the document is copied first. Throws RunError, and then the document
  /// is whole, with the part or without. Precondition: begin().
  void add(const std::string& part);

 private:
  void write_next(const std::string& tail);
  void remove_next();

  const std::string path_, next_, previous_, opening_, closing_;
  std::string last_;            ///< the last part; empty: there is no document
  GlobalIndex last_place_ = 0;  ///< bytes before it
  bool has_next_ = false;       ///< `next_` is right up to there
};

}  // namespace bulkley
