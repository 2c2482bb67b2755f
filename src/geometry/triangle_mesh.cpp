#include "geometry/triangle_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdlib>
#include <map>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace bulkley {

namespace {

bool precedes(const Vec3& a, const Vec3& b) { return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end()); }
bool precedes(const Int3& a, const Int3& b) { return a < b; }

/// For each item the position of the first one that equals it.
template <class T>
std::vector<int> first_equal(const std::vector<T>& items) {
  std::vector<int> order(items.size());
  std::iota(order.begin(), order.end(), 0);
  const auto at = [&](int n) -> const T& { return items[static_cast<std::size_t>(n)]; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return precedes(at(a), at(b)); });
  std::vector<int> result(items.size());
  for (std::size_t n = 0; n < order.size(); ++n) {
    const bool repeated = n > 0 && at(order[n - 1]) == at(order[n]);
    result[static_cast<std::size_t>(order[n])] = repeated ? result[static_cast<std::size_t>(order[n - 1])] : order[n];
  }
  return result;
}

/// Starting at the smallest index, in the same sense.
Int3 turned_to_smallest(Int3 t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

Vec3 area_vector(const TriangleMesh& mesh, const Int3& t) {
  const auto at = [&](std::size_t c) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(t[c])]; };
  return 0.5 * (at(1) - at(0)).cross(at(2) - at(0));
}

void drop_unused_vertices(TriangleMesh& mesh) {
  std::vector<int> renumbered(mesh.vertices.size(), -1);
  for (const Int3& t : mesh.triangles)
    for (const int v : t) renumbered[static_cast<std::size_t>(v)] = 0;
  int n = 0;
  for (std::size_t v = 0; v < renumbered.size(); ++v) {
    if (renumbered[v] < 0) continue;
    renumbered[v] = n;
    mesh.vertices[static_cast<std::size_t>(n++)] = mesh.vertices[v];
  }
  mesh.vertices.resize(static_cast<std::size_t>(n));
  for (Int3& t : mesh.triangles)
    for (int& v : t) v = renumbered[static_cast<std::size_t>(v)];
}

/// Sets that grow together.
class Groups {
 public:
  explicit Groups(std::size_t n) : leader_(n) { std::iota(leader_.begin(), leader_.end(), 0); }
  int leader(int n) {
    while (at(n) != n) n = at(n) = at(at(n));
    return n;
  }
  void join(int a, int b) { at(std::max(leader(a), leader(b))) = std::min(leader(a), leader(b)); }

 private:
  int& at(int n) { return leader_[static_cast<std::size_t>(n)]; }
  std::vector<int> leader_;
};

/// Times that triangles run along each edge from its lower index to the higher, less the times they run back.
std::unordered_map<std::uint64_t, int> edge_balance(const TriangleMesh& mesh) {
  std::unordered_map<std::uint64_t, int> balance;
  balance.reserve(2 * mesh.triangles.size());
  for (const Int3& t : mesh.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const auto a = static_cast<std::uint64_t>(t[c]), b = static_cast<std::uint64_t>(t[(c + 1) % 3]);
      balance[std::min(a, b) << 32 | std::max(a, b)] += a < b ? 1 : -1;
    }
  return balance;
}

/// Counts the holes, and adds the volume that a fan from the middle of each rim closes.
void close_holes(const TriangleMesh& mesh, const Vec3& center, MeshFacts& result) {
  struct RimEdge {
    int from, to, times;
  };
  Groups rims(mesh.vertices.size());
  std::vector<RimEdge> edges;
  for (const auto& [edge, balance] : edge_balance(mesh)) {
    if (balance == 0) continue;
    const int a = static_cast<int>(edge >> 32), b = static_cast<int>(edge & 0xffffffffu);
    rims.join(a, b);
    edges.push_back({balance > 0 ? b : a, balance > 0 ? a : b, std::abs(balance)});
  }
  // The order of the sums below must not be that of a hash table.
  std::sort(edges.begin(), edges.end(),
            [](const RimEdge& a, const RimEdge& b) { return std::pair(a.from, a.to) < std::pair(b.from, b.to); });
  const auto at = [&](int v) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(v)]; };
  std::map<int, std::pair<Vec3, int>> middles;
  for (const RimEdge& e : edges) {
    auto& [sum, count] = middles.try_emplace(rims.leader(e.from), Vec3::Zero(), 0).first->second;
    sum += at(e.from) + at(e.to);
    count += 2;
  }
  for (const RimEdge& e : edges) {
    const auto& [sum, count] = middles.at(rims.leader(e.from));
    result.volume += e.times * (at(e.from) - center).cross(at(e.to) - center).dot(sum / count - center) / 6.0;
  }
  result.n_boundary_edges = edges.size();
  result.n_holes = middles.size();
}

}  // namespace

WeldCount weld(TriangleMesh& mesh) {
  WeldCount count;
  const std::vector<int> first = first_equal(mesh.vertices);
  for (std::size_t v = 0; v < first.size(); ++v)
    if (first[v] != static_cast<int>(v)) ++count.vertices;
  for (Int3& t : mesh.triangles)
    for (int& v : t) v = first[static_cast<std::size_t>(v)];

  // Three different points on a line stay: without them the mesh would have a slit.
  count.degenerate =
      std::erase_if(mesh.triangles, [](const Int3& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  std::vector<Int3> turned;
  for (const Int3& t : mesh.triangles) turned.push_back(turned_to_smallest(t));
  const std::vector<int> first_triangle = first_equal(turned);
  std::size_t n = 0;
  for (std::size_t t = 0; t < first_triangle.size(); ++t)
    if (first_triangle[t] == static_cast<int>(t)) mesh.triangles[n++] = mesh.triangles[t];
  count.duplicates = mesh.triangles.size() - n;
  mesh.triangles.resize(n);
  drop_unused_vertices(mesh);
  return count;
}

MeshFacts facts(const TriangleMesh& mesh) {
  MeshFacts result;
  result.lower = result.upper = mesh.vertices.at(0);
  for (const Vec3& v : mesh.vertices) {
    result.lower = result.lower.cwiseMin(v);
    result.upper = result.upper.cwiseMax(v);
  }
  const Vec3 center = 0.5 * (result.lower + result.upper);
  Groups parts(mesh.vertices.size());
  for (const Int3& t : mesh.triangles) {
    const Vec3 area = area_vector(mesh, t);
    result.area += area.norm();
    result.volume += area.dot(mesh.vertices[static_cast<std::size_t>(t[0])] - center) / 3.0;
    parts.join(t[0], t[1]);
    parts.join(t[0], t[2]);
  }
  for (int v = 0; v < static_cast<int>(mesh.vertices.size()); ++v)
    if (parts.leader(v) == v) ++result.n_components;
  close_holes(mesh, center, result);
  return result;
}

}  // namespace bulkley
