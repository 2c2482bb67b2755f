#include "balance/diffusion.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <queue>
#include <set>

// How loads are made equal.
//
// Every move of a tile has a gain: the nodes that cease to be shared between parts less those that come to be shared. Three
// tools move tiles. They choose single tiles by the largest gain, so that borders stay short, and break ties in a fixed
// order, so that the result is always the same.
// - Polishing moves a single tile out of the most loaded part into a part that touches it, as long as the larger of the two
//   loads falls. Where no touching part has room, the separate piece of the part that fits best goes to the least
//   loaded part instead.
// - Flows: parts are the vertices of a graph, with an edge where they touch. The potentials u with (Laplacian of the graph)
//   u = load - mean give the flow u_p - u_q over each edge; of all flows that make the loads equal it has the least sum of
//   squares (Hu, Blake & Emerson 1998). Flows are carried out tile by tile, from high potentials to low: a part has then
//   received what it has to pass on. Since tiles are not divided, it takes a few rounds.
// - Direct relief pairs the part with the largest excess with the one with the largest deficit, wherever they lie. The first
//   tile is the one whose removal costs least; later ones join it, because their gain counts the nodes they share with it.
// `diffused` polishes, and uses flows only where polishing gets stuck and flows end with a load at least 1 % of the mean
// lower: they shift every border. `relieved` does direct relief and then polishes.

namespace bulkley {

namespace {

constexpr int max_rounds = 12;
constexpr double worth_flowing = 0.01;  // of the mean load: a smaller gain of the flows is not worth the longer borders

struct Flow {
  int from, to;
  double amount;     // of load
  double potential;  // of `from`
};

class Diffusion {
 public:
  Diffusion(const TileGraph& graph, const TileLoad& load, std::vector<std::int32_t> part, int n_parts)
      : graph_(graph), load_(load), part_(std::move(part)), n_parts_(n_parts), tiles_(n_parts), part_load_(n_parts, 0) {
    for (std::int32_t t = 0; t < graph.size(); ++t) {
      tiles_[part_[t]].push_back(t);
      part_load_[part_[t]] += load.weight[t];
    }
    mean_ = static_cast<double>(load.total()) / n_parts;
  }

  const std::vector<std::int32_t>& part() const { return part_; }
  double largest() const { return static_cast<double>(*std::max_element(part_load_.begin(), part_load_.end())) / mean_; }

  // Carries out one set of flows.
  void round() {
    for (const Flow& flow : flows()) carry_out(flow);
  }

  // Excess of overloaded parts over the mean to underloaded ones, the largest excess to the largest deficit first.
  void relieve_directly() {
    std::vector<std::pair<double, int>> excess;
    for (int p = 0; p < n_parts_; ++p) excess.emplace_back(static_cast<double>(part_load_[p]) - mean_, p);
    std::sort(excess.begin(), excess.end());
    for (auto low = excess.begin(), high = excess.end() - 1; low < high && low->first < 0.0 && high->first > 0.0;) {
      const double amount = std::min(-low->first, high->first);
      carry_out({high->second, low->second, amount, 0.0}, true);
      low->first += amount;
      high->first -= amount;
      if (low->first >= 0.0) ++low;
      if (high->first <= 0.0) --high;
    }
  }

  // Moves single tiles, or pieces, out of the most loaded part as long as that lowers the larger of the two loads.
  void polish(double tolerance) {
    for (int n = 0; n < 4 * n_parts_ && largest() > tolerance; ++n)
      if (!relieve(static_cast<int>(std::max_element(part_load_.begin(), part_load_.end()) - part_load_.begin()))) return;
  }

 private:
  // Calls visit(other tile, shared nodes) for the neighbours of a tile.
  template <class Visit>
  void for_each_neighbour(std::int32_t t, Visit visit) const {
    for (GlobalIndex e = graph_.first[t]; e < graph_.first[t + 1]; ++e) visit(graph_.neighbour[e], graph_.shared[e]);
  }

  // Pairs of parts that touch, each once, lower number first.
  std::vector<std::pair<int, int>> borders() const {
    std::vector<std::pair<int, int>> pairs;
    for (std::int32_t t = 0; t < graph_.size(); ++t)
      for_each_neighbour(t, [&](std::int32_t other, int) {
        if (part_[t] < part_[other]) pairs.emplace_back(part_[t], part_[other]);
      });
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    return pairs;
  }

  // The flows over borders that make all loads equal with the least sum of squares: differences of potentials that solve a
  // Poisson equation on the graph of parts. Sources first.
  std::vector<Flow> flows() const {
    const std::vector<std::pair<int, int>> pairs = borders();
    std::vector<Eigen::Triplet<double>> entries;
    // Pieces of material that do not touch make the equation singular; the shift leaves their potentials finite.
    constexpr double shift = 1e-6;
    for (int p = 0; p < n_parts_; ++p) entries.emplace_back(p, p, shift);
    for (const auto& [p, q] : pairs) {
      entries.emplace_back(p, p, 1.0), entries.emplace_back(q, q, 1.0);
      entries.emplace_back(p, q, -1.0), entries.emplace_back(q, p, -1.0);
    }
    Eigen::SparseMatrix<double> laplacian(n_parts_, n_parts_);
    laplacian.setFromTriplets(entries.begin(), entries.end());
    Eigen::VectorXd excess(n_parts_);
    for (int p = 0; p < n_parts_; ++p) excess[p] = static_cast<double>(part_load_[p]) / mean_ - 1.0;
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver(laplacian);
    solver.setTolerance(1e-6);
    const Eigen::VectorXd potential = solver.solve(excess);

    std::vector<Flow> result;
    for (const auto& [p, q] : pairs) {
      const double amount = (potential[p] - potential[q]) * mean_;
      if (amount > 0.0) result.push_back({p, q, amount, potential[p]});
      if (amount < 0.0) result.push_back({q, p, -amount, potential[q]});
    }
    std::stable_sort(result.begin(), result.end(), [](const Flow& a, const Flow& b) { return a.potential > b.potential; });
    return result;
  }

  // Shared nodes that cease to be shared, less those that come to be, if tile t moves to part `to`; far below zero where it
  // does not touch that part.
  static constexpr int apart = -1000000;
  int gain(std::int32_t t, int to) const {
    int gain = 0;
    bool touch = false;
    for_each_neighbour(t, [&](std::int32_t other, int shared) {
      if (part_[other] == to) gain += shared, touch = true;
      if (part_[other] == part_[t]) gain -= shared;
    });
    return touch ? gain : gain + apart;
  }
  static bool touches(int gain) { return gain > apart / 2; }

  void move(std::int32_t t, int to) {
    std::vector<std::int32_t>& left = tiles_[part_[t]];
    left.erase(std::find(left.begin(), left.end(), t));
    tiles_[to].push_back(t);
    part_load_[part_[t]] -= load_.weight[t];
    part_load_[to] += load_.weight[t];
    part_[t] = to;
  }

  // `anywhere`: also where the parts do not touch.
  void carry_out(const Flow& flow, bool anywhere = false) {
    // The best tile first; ties by number, so that the outcome is one.
    using Candidate = std::pair<int, std::int32_t>;
    std::priority_queue<Candidate> queue;
    for (const std::int32_t t : tiles_[flow.from])
      if (const int g = gain(t, flow.to); anywhere || touches(g)) queue.emplace(g, -t);
    double left = flow.amount;
    while (!queue.empty() && left > 0.0 && tiles_[flow.from].size() > 1) {
      const auto [old_gain, minus_t] = queue.top();
      const std::int32_t t = -minus_t;
      queue.pop();
      if (part_[t] != flow.from) continue;
      if (const int g = gain(t, flow.to); g != old_gain) {
        queue.emplace(g, minus_t);
        continue;
      }
      const auto weight = static_cast<double>(load_.weight[t]);
      if (weight >= 2.0 * left) continue;  // nearer to the wanted flow without it
      move(t, flow.to);
      left -= weight;
      for_each_neighbour(t, [&](std::int32_t other, int) {
        if (part_[other] == flow.from) queue.emplace(gain(other, flow.to), -other);
      });
    }
  }

  bool relieve(int full) { return tiles_[full].size() > 1 && (pass_tile(full) || pass_piece(full)); }

  // A tile of the part to one that touches it.
  bool pass_tile(int full) {
    std::int32_t best = -1;
    int best_gain = 0, best_part = -1;
    for (const std::int32_t t : tiles_[full])
      for_each_neighbour(t, [&](std::int32_t other, int) {
        const int to = part_[other];
        if (to == full || part_load_[to] + load_.weight[t] >= part_load_[full]) return;
        const int g = gain(t, to);
        if (best >= 0 && g <= best_gain) return;
        best = t, best_gain = g, best_part = to;
      });
    if (best < 0) return false;
    move(best, best_part);
    return true;
  }

  // A separate piece of the part, such as a drop, to the least loaded part: all parts that touch it may be full, or there
  // may be none.
  bool pass_piece(int full) {
    const int to = static_cast<int>(std::min_element(part_load_.begin(), part_load_.end()) - part_load_.begin());
    const std::vector<std::vector<std::int32_t>> pieces = pieces_of(full);
    if (pieces.size() == 1) return false;
    const std::vector<std::int32_t>* best = nullptr;
    GlobalIndex smallest = part_load_[full];
    for (const std::vector<std::int32_t>& piece : pieces) {
      GlobalIndex weight = 0;
      for (const std::int32_t t : piece) weight += load_.weight[t];
      const GlobalIndex larger = std::max(part_load_[full] - weight, part_load_[to] + weight);
      if (larger >= smallest) continue;
      smallest = larger;
      best = &piece;
    }
    if (!best) return false;
    for (const std::int32_t t : *best) move(t, to);
    return true;
  }

  std::vector<std::vector<std::int32_t>> pieces_of(int part) const {
    std::vector<std::vector<std::int32_t>> pieces;
    std::set<std::int32_t> left(tiles_[part].begin(), tiles_[part].end());
    while (!left.empty()) {
      std::vector<std::int32_t>& piece = pieces.emplace_back(1, *left.begin());
      left.erase(left.begin());
      for (std::size_t n = 0; n < piece.size(); ++n)
        for_each_neighbour(piece[n], [&](std::int32_t other, int) {
          if (left.erase(other) > 0) piece.push_back(other);
        });
    }
    return pieces;
  }

  const TileGraph& graph_;
  const TileLoad& load_;
  std::vector<std::int32_t> part_;
  int n_parts_;
  std::vector<std::vector<std::int32_t>> tiles_;  // of each part
  std::vector<GlobalIndex> part_load_;
  double mean_ = 0.0;
};

}  // namespace

std::vector<std::int32_t> relieved(const TileGraph& graph, const TileLoad& load, std::vector<std::int32_t> part, int n_parts,
                                   double tolerance) {
  if (n_parts == 1 || graph.size() == 0) return part;
  Diffusion diffusion(graph, load, part, n_parts);
  const double before = diffusion.largest();
  diffusion.relieve_directly();
  diffusion.polish(tolerance);
  return diffusion.largest() < before ? diffusion.part() : part;
}

std::vector<std::int32_t> diffused(const TileGraph& graph, const TileLoad& load, std::vector<std::int32_t> part, int n_parts,
                                   double tolerance) {
  if (n_parts == 1 || graph.size() == 0) return part;
  Diffusion polished(graph, load, part, n_parts);
  const double at_first = polished.largest();
  polished.polish(tolerance);
  if (polished.largest() <= tolerance) return polished.part();

  // Single tiles find no way through full parts; flows do, but shift all borders.
  Diffusion flown(graph, load, std::move(part), n_parts);
  double before = at_first;
  for (int round = 0; round < max_rounds && before > tolerance; ++round) {
    flown.round();
    if (flown.largest() >= before) break;
    before = flown.largest();
  }
  flown.polish(tolerance);
  return flown.largest() < polished.largest() - worth_flowing ? flown.part() : polished.part();
}

}  // namespace bulkley
