#include "io/arrays/box_array.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

namespace bulkley {

namespace {

Array array_of(const BoxFields& box, const BoxFields::Field& field, ArrayType type) {
  Array array;
  array.path = "/" + box.name + "/" + field.name;
  array.type = type;
  array.unit = field.unit;
  array.meaning = field.meaning;
  for (const std::size_t axis : {2u, 1u, 0u}) {
    array.shape.push_back(box.n_nodes[axis]);
    array.start.push_back(box.first[axis]);
    array.count.push_back(box.count[axis]);
  }
  const auto n_components = static_cast<GlobalIndex>(field.components.size());
  if (n_components > 1) {
    array.shape.push_back(n_components);
    array.start.push_back(0);
    array.count.push_back(n_components);
  }
  return array;
}

// `visit(node)` of own nodes in planes [first, first + n) along z, x fastest, as files have them; nodes are numbered z fastest.
template <class Visit>
void for_planes(const BoxFields& box, GlobalIndex first, GlobalIndex n, Visit visit) {
  for (GlobalIndex k = first; k < first + n; ++k)
    for (GlobalIndex j = 0; j < box.count[1]; ++j)
      for (GlobalIndex i = 0; i < box.count[0]; ++i)
        visit(static_cast<std::size_t>((i * box.count[1] + j) * box.count[2] + k));
}

std::vector<double> origin_of(const BoxFields& box) { return {box.origin[0], box.origin[1], box.origin[2]}; }

}  // namespace

void add_box(FileContent& content, const BoxFields& box, ArrayType type) {
  content.attributes.push_back({"/" + box.name, "origin", origin_of(box)});
  content.attributes.push_back({"/" + box.name, "cell_size", box.spacing});
  for (const BoxFields::Field& field : box.fields) {
    Array array = array_of(box, field, type);
    array.fill = [&box, &field, type](GlobalIndex first, GlobalIndex n, std::byte* out) {
      for_planes(box, first, n, [&](std::size_t node) {
        for (const std::vector<double>& values : field.components) {
          const auto narrow = static_cast<float>(values[node]);
          const std::size_t size = element_size(type);
          std::memcpy(out, type == ArrayType::float32 ? static_cast<const void*>(&narrow) : &values[node], size);
          out += size;
        }
      });
    };
    content.arrays.push_back(std::move(array));
  }
}

bool read_box(const Hdf5Reader& file, BoxFields& box) {
  const std::string group = "/" + box.name;
  if (!file.has(group) || file.reals(group, "origin") != origin_of(box) || file.real(group, "cell_size") != box.spacing)
    return false;
  std::vector<ArrayInfo> arrays;
  for (const BoxFields::Field& field : box.fields) {
    const Array expected = array_of(box, field, ArrayType::float64);
    if (!file.has(expected.path)) return false;
    arrays.push_back(file.array(expected.path));
    if (arrays.back().type != expected.type || arrays.back().shape != expected.shape) return false;
  }
  for (std::size_t f = 0; f < arrays.size(); ++f) {
    BoxFields::Field& field = box.fields[f];
    const Array own = array_of(box, field, ArrayType::float64);
    std::vector<double> values(static_cast<std::size_t>(n_elements(own.count)));
    if (values.empty()) continue;
    file.read(arrays[f], own.start, own.count, values.data());
    if (!std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); }))
      throw RunError(fmt::format("cannot read '{}': {} holds numbers that are not finite", file.path(), own.path));
    const double* from = values.data();
    for_planes(box, 0, box.count[2], [&](std::size_t node) {
      for (std::vector<double>& component : field.components) component[node] = *from++;
    });
  }
  return true;
}

}  // namespace bulkley
