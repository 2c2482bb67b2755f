#include "geometry/mesh_format.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cstring>
#include <limits>

#include "base/text.hpp"
#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

[[noreturn]] void refuse(const std::string& reason) { throw UsageError("cannot be read as a mesh: " + reason); }

// --- text ----------------------------------------------------------------------------------------------------------------

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }

/// The text line by line, each word by word.
class Lines {
 public:
  explicit Lines(std::string_view text, std::size_t number = 0) : rest_(text), number_(number) {}

  bool next() {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++number_;
    return true;
  }
  /// The next word of the line; empty at its end.
  std::string_view word() {
    while (!line_.empty() && is_blank(line_.front())) line_.remove_prefix(1);
    std::size_t n = 0;
    while (n < line_.size() && !is_blank(line_[n])) ++n;
    const std::string_view result = line_.substr(0, n);
    line_.remove_prefix(n);
    return result;
  }
  template <class Number>
  Number number(std::string_view text) const {
    if (text.starts_with('+')) text.remove_prefix(1);
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc{} || end != text.data() + text.size())
      fail(text.empty() ? "a number is missing" : excerpt(text) + " is no number that can be used here");
    return value;
  }
  Vec3 vector() {
    Vec3 result;
    for (int axis = 0; axis < 3; ++axis) result[axis] = number<double>(word());
    return result;
  }
  [[noreturn]] void fail(const std::string& reason) const { refuse(fmt::format("line {}: {}", number_, reason)); }
  std::string_view rest() const { return rest_; }
  std::size_t line_number() const { return number_; }

 private:
  std::string_view rest_, line_;
  std::size_t number_;
};

// --- polygons ------------------------------------------------------------------------------------------------------------

constexpr std::size_t most_corners = 1000;  ///< of a polygon whose best corner is searched in quadratic time

/// The corner from which no triangle of a fan folds over; the first if there is none.
std::size_t fan_corner(const TriangleMesh& mesh, const std::vector<int>& corners) {
  const std::size_t n = corners.size();
  if (n <= 3 || n > most_corners) return 0;
  const auto at = [&](std::size_t c) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(corners[c % n])]; };
  Vec3 area = Vec3::Zero();
  for (std::size_t c = 1; c + 1 < n; ++c) area += (at(c) - at(0)).cross(at(c + 1) - at(0));
  for (std::size_t start = 0; start < n; ++start) {
    bool folds = false;
    for (std::size_t c = 1; c + 1 < n && !folds; ++c)
      folds = (at(start + c) - at(start)).cross(at(start + c + 1) - at(start)).dot(area) < 0.0;
    if (!folds) return start;
  }
  return 0;
}

/// Adds a polygon as a fan. Precondition: its corners are vertices of the mesh.
void add_polygon(const std::vector<int>& corners, TriangleMesh& mesh) {
  const std::size_t n = corners.size(), start = fan_corner(mesh, corners);
  for (std::size_t c = 1; c + 1 < n; ++c)
    mesh.triangles.push_back({corners[start], corners[(start + c) % n], corners[(start + c + 1) % n]});
}

constexpr std::int64_t most_vertices = std::numeric_limits<int>::max();

void add_vertex(const Vec3& vertex, TriangleMesh& mesh) {
  if (std::ssize(mesh.vertices) >= most_vertices) throw UsageError("has more vertices than an index can count");
  mesh.vertices.push_back(vertex);
}

/// Polygons before all vertices are known: their corners one after the other.
struct Polygons {
  std::vector<std::int64_t> corners;
  std::vector<std::size_t> sizes;

  void close(std::size_t n) {
    if (n < 1) throw UsageError("has faces without vertices: the file is truncated or corrupted");
    sizes.push_back(n);
  }
  void add_to(TriangleMesh& mesh) const {
    const auto n_vertices = std::ssize(mesh.vertices);
    std::vector<int> polygon;
    auto corner = corners.begin();
    for (const std::size_t size : sizes) {
      polygon.clear();
      for (std::size_t c = 0; c < size; ++c, ++corner) {
        if (*corner < 0 || *corner >= n_vertices)
          throw UsageError(
              fmt::format("has a face with vertex {}, but only {} vertices (the first is 0)", *corner, n_vertices));
        polygon.push_back(static_cast<int>(*corner));
      }
      add_polygon(polygon, mesh);
    }
  }
};

// --- OBJ -----------------------------------------------------------------------------------------------------------------

/// Vertices and faces; normals, textures, groups and the rest are passed over.
TriangleMesh parse_obj(std::string_view bytes) {
  TriangleMesh mesh;
  Polygons faces;
  Lines lines(bytes);
  while (lines.next()) {
    const std::string_view kind = lines.word();
    if (kind == "v") add_vertex(lines.vector(), mesh);
    if (kind != "f") continue;
    std::size_t n = 0;
    for (std::string_view word = lines.word(); !word.empty() && word != "\\"; word = lines.word()) {
      const auto index = lines.number<std::int64_t>(word.substr(0, word.find('/')));
      if (index == 0) lines.fail("vertices are counted from 1, and from -1 backwards; there is no 0");
      // Backwards from the last vertex so far.
      faces.corners.push_back(index > 0 ? index - 1
                                        : std::max<std::int64_t>(index, -most_vertices) + std::ssize(mesh.vertices));
      ++n;
    }
    faces.close(n);
  }
  if (mesh.vertices.empty() && faces.sizes.empty()) refuse("it has neither vertices ('v') nor faces ('f')");
  faces.add_to(mesh);
  return mesh;
}

// --- STL -----------------------------------------------------------------------------------------------------------------

constexpr std::size_t stl_header = 84, stl_row = 50;  // bytes

template <class Number>
Number number_at(std::string_view bytes, std::size_t at, bool is_big_endian = false) {
  std::array<char, sizeof(Number)> raw;
  std::memcpy(raw.data(), bytes.data() + at, sizeof(Number));
  if (is_big_endian) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<Number>(raw);
}

TriangleMesh parse_stl_binary(std::string_view bytes, std::size_t n_triangles) {
  TriangleMesh mesh;
  for (std::size_t t = 0; t < n_triangles; ++t) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::size_t at = stl_header + t * stl_row + 12 * (corner + 1);  // after the normal
      add_vertex({number_at<float>(bytes, at), number_at<float>(bytes, at + 4), number_at<float>(bytes, at + 8)}, mesh);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

TriangleMesh parse_stl_text(std::string_view bytes) {
  TriangleMesh mesh;
  std::vector<int> loop;
  bool is_open = true;
  Lines lines(bytes);
  while (lines.next()) {
    const std::string_view kind = lines.word();
    if (kind == "vertex") {
      loop.push_back(static_cast<int>(mesh.vertices.size()));
      add_vertex(lines.vector(), mesh);
    } else if (kind == "endloop") {
      if (loop.size() < 3) lines.fail("a facet has fewer than three vertices");
      add_polygon(loop, mesh);
      loop.clear();
    } else if (kind == "solid" || kind == "endsolid") {
      is_open = kind == "solid";
    } else if (!kind.empty() && kind != "facet" && kind != "endfacet" && kind != "outer") {
      lines.fail(excerpt(kind) + " does not belong into an STL file");
    }
  }
  if (is_open || !loop.empty()) refuse("it is truncated: its last line is not 'endsolid'");
  return mesh;
}

TriangleMesh parse_stl(std::string_view bytes) {
  const bool has_header = bytes.size() >= stl_header;
  const std::size_t n = has_header ? number_at<std::uint32_t>(bytes, stl_header - 4) : 0;
  const std::size_t wanted = stl_header + n * stl_row;
  if (has_header && wanted == bytes.size()) return parse_stl_binary(bytes, n);
  Lines first(bytes);
  if (first.next() && first.word() == "solid") return parse_stl_text(bytes);
  if (!has_header) refuse("it neither begins with 'solid' nor has the 84 bytes of a binary STL file's header");
  if (wanted > bytes.size())
    refuse(fmt::format("it is truncated: {} triangles take {} bytes, and it has {}", n, wanted, bytes.size()));
  return parse_stl_binary(bytes, n);  // some programs append bytes of their own
}

// --- PLY -----------------------------------------------------------------------------------------------------------------

enum class PlyKind { ascii, little_endian, big_endian };

struct PlyType {
  const char *name, *other_name;
  std::size_t size;
  double (*read)(std::string_view bytes, std::size_t at, bool is_big_endian);
};
template <class Number>
double read_as(std::string_view bytes, std::size_t at, bool is_big_endian) {
  return static_cast<double>(number_at<Number>(bytes, at, is_big_endian));
}
constexpr PlyType ply_types[] = {
    {"char", "int8", 1, read_as<std::int8_t>},    {"uchar", "uint8", 1, read_as<std::uint8_t>},
    {"short", "int16", 2, read_as<std::int16_t>}, {"ushort", "uint16", 2, read_as<std::uint16_t>},
    {"int", "int32", 4, read_as<std::int32_t>},   {"uint", "uint32", 4, read_as<std::uint32_t>},
    {"float", "float32", 4, read_as<float>},      {"double", "float64", 8, read_as<double>}};

struct PlyProperty {
  std::string name;
  const PlyType* count = nullptr;  ///< of a list
  const PlyType* type = nullptr;
};

struct PlyElement {
  std::string name;
  std::uint64_t n = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  std::optional<PlyKind> kind;
  std::vector<PlyElement> elements;
};

const PlyType* ply_type(const Lines& lines, std::string_view name) {
  for (const PlyType& type : ply_types)
    if (name == type.name || name == type.other_name) return &type;
  lines.fail(excerpt(name) + " is no type of number");
}

void read_property(Lines& lines, PlyHeader& header) {
  if (header.elements.empty()) lines.fail("a property precedes the first element");
  PlyProperty property;
  std::string_view word = lines.word();
  if (word == "list") {
    property.count = ply_type(lines, lines.word());
    word = lines.word();
  }
  property.type = ply_type(lines, word);
  property.name = lines.word();
  header.elements.back().properties.push_back(property);
}

/// Reads up to "end_header".
PlyHeader read_ply_header(Lines& lines) {
  constexpr std::size_t most_lines = 10000;
  PlyHeader header;
  if (!lines.next() || lines.word() != "ply") refuse("its first line is not 'ply'");
  while (lines.next() && lines.line_number() < most_lines) {
    const std::string_view kind = lines.word();
    if (kind == "end_header") {
      if (!header.kind) lines.fail("the header names no format");
      return header;
    }
    if (kind == "format") {
      const std::string_view name = lines.word();
      if (name == "ascii") header.kind = PlyKind::ascii;
      if (name == "binary_little_endian") header.kind = PlyKind::little_endian;
      if (name == "binary_big_endian") header.kind = PlyKind::big_endian;
      if (!header.kind) lines.fail(excerpt(name) + " is no format of PLY files");
    } else if (kind == "element") {
      const std::string name(lines.word());
      header.elements.push_back({name, lines.number<std::uint64_t>(lines.word()), {}});
    } else if (kind == "property") {
      read_property(lines, header);
    } else if (!kind.empty() && kind != "comment" && kind != "obj_info") {
      lines.fail(excerpt(kind) + " does not belong into the header of a PLY file");
    }
  }
  refuse("its header has no end");
}

/// The numbers after the header, one after the other.
class PlyBody {
 public:
  PlyBody(PlyKind kind, const Lines& header)
      : kind_(kind), bytes_(header.rest()), lines_(header.rest(), header.line_number()) {}

  double number(const PlyType& type) {
    if (kind_ == PlyKind::ascii) {
      std::string_view word = lines_.word();
      while (word.empty()) {
        if (!lines_.next()) cut_off();
        word = lines_.word();
      }
      return lines_.number<double>(word);
    }
    if (bytes_.size() - at_ < type.size) cut_off();
    const double value = type.read(bytes_, at_, kind_ == PlyKind::big_endian);
    at_ += type.size;
    return value;
  }
  std::int64_t integer(const PlyType& type) {
    const double value = number(type);
    // Larger values are no indices, and doubles no longer represent all integers.
    if (!(value >= -9e15 && value <= 9e15) || value != static_cast<double>(static_cast<std::int64_t>(value)))
      refuse(fmt::format("{} is no valid number of vertices or vertex index", value));
    return static_cast<std::int64_t>(value);
  }
  /// Bytes that are left, and at least as many as the numbers.
  std::uint64_t n_left() const {
    return kind_ == PlyKind::ascii ? lines_.rest().size() + bytes_.size() : bytes_.size() - at_;
  }

 private:
  [[noreturn]] static void cut_off() { refuse("it is truncated: its header declares more vertices or faces than follow"); }
  PlyKind kind_;
  std::string_view bytes_;
  std::size_t at_ = 0;
  Lines lines_;
};

bool is_face_list(const PlyElement& element, const PlyProperty& property) {
  return element.name == "face" && property.count && (property.name == "vertex_indices" || property.name == "vertex_index");
}

void read_ply_row(const PlyElement& element, PlyBody& body, TriangleMesh& mesh, Polygons& faces) {
  Vec3 vertex = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  for (const PlyProperty& property : element.properties) {
    if (!property.count) {
      const double value = body.number(*property.type);
      if (property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z')
        vertex[property.name[0] - 'x'] = value;
      continue;
    }
    const std::int64_t n = body.integer(*property.count);
    if (n < 0) refuse(fmt::format("a list has {} entries", n));
    const bool is_face = is_face_list(element, property);
    for (std::int64_t k = 0; k < n; ++k) {
      if (is_face)
        faces.corners.push_back(body.integer(*property.type));
      else
        body.number(*property.type);
    }
    if (is_face) faces.close(static_cast<std::size_t>(n));
  }
  if (element.name == "vertex") add_vertex(vertex, mesh);
}

TriangleMesh parse_ply(std::string_view bytes) {
  Lines lines(bytes);
  const PlyHeader header = read_ply_header(lines);
  PlyBody body(*header.kind, lines);
  TriangleMesh mesh;
  Polygons faces;
  for (const PlyElement& element : header.elements) {
    // Every property takes a byte at least, so this also bounds the time.
    if (element.properties.empty() ? element.n > 0 : element.n > body.n_left())
      refuse(fmt::format("it is truncated: its header declares {} of {}", element.n, excerpt(element.name)));
    for (std::uint64_t row = 0; row < element.n; ++row) read_ply_row(element, body, mesh, faces);
  }
  faces.add_to(mesh);
  return mesh;
}

}  // namespace

std::optional<MeshFormat> mesh_format(const std::string& file_name) {
  const std::size_t dot = file_name.rfind('.');
  std::string extension = dot == std::string::npos ? "" : file_name.substr(dot);
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
  if (extension == ".obj") return MeshFormat::obj;
  if (extension == ".stl") return MeshFormat::stl;
  if (extension == ".ply") return MeshFormat::ply;
  return std::nullopt;
}

TriangleMesh parse_mesh(std::string_view bytes, MeshFormat format) {
  if (format == MeshFormat::obj) return parse_obj(bytes);
  return format == MeshFormat::stl ? parse_stl(bytes) : parse_ply(bytes);
}

}  // namespace bulkley
