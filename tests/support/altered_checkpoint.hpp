#pragma once
// Checkpoints with everything right, checksums included, but for one thing.

#include <algorithm>
#include <cstring>
#include <functional>
#include <string>

#include "io/arrays/array_file.hpp"
#include "support/io_particles.hpp"

namespace bulkley {

/// Writes what checkpoint `from` holds, changed by `alter`, to `to`. `groups`: of attributes that go with it. Collective.
inline void write_altered(const Comm& comm, const std::string& from, const std::string& to,
                          const std::function<void(FileContent&)>& alter,
                          const std::vector<std::string>& groups = {"/", "/state/reals", "/state/integers",
                                                                    "/state/fingerprints"}) {
  const Hdf5Reader reader(from);
  FileContent content{"bulkley checkpoint", 1, {}, {}};
  for (const std::string& object : groups)
    for (const std::string& name : reader.attribute_names(object))
      if (!name.starts_with("format")) content.attributes.push_back({object, name, reader.attribute(object, name)});
  for (const std::string& name : reader.members("/particles")) {
    const ArrayInfo found = reader.array("/particles/" + name);
    Array array{found.path, found.type, found.shape, Extents(found.shape.size(), 0), found.shape, "1", "", {}};
    if (!comm.is_root()) array.count[0] = 0;
    array.fill = [from, found](GlobalIndex first, GlobalIndex n, std::byte* out) {
      Extents start(found.shape.size(), 0), count = found.shape;
      start[0] = first;
      count[0] = n;
      Hdf5Reader(from).read(found, start, count, out);
    };
    content.arrays.push_back(array);
  }
  alter(content);
  write_array_file(comm, to, content);
}

inline Array& array_of(FileContent& content, const std::string& path) {
  return *std::find_if(content.arrays.begin(), content.arrays.end(), [&](const Array& a) { return a.path == path; });
}

/// Gives one value of a field, counted over rows and components, another number.
template <class Number>
std::function<void(FileContent&)> with_value(const std::string& field, std::size_t element, Number value) {
  return [=](FileContent& content) {
    Array& array = array_of(content, "/particles/" + field);
    array.fill = [=, right = array.fill](GlobalIndex first, GlobalIndex n, std::byte* out) {
      right(first, n, out);
      std::memcpy(out + element * sizeof value, &value, sizeof value);  // there is only one portion
    };
  };
}

}  // namespace bulkley
