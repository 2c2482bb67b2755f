#include "integrator/fronts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace bulkley {

namespace {

// Unsigned integers in the order of the doubles.
std::uint64_t key_of(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  constexpr std::uint64_t sign = std::uint64_t{1} << 63;
  return bits & sign ? ~bits : bits | sign;
}
double value_of(std::uint64_t key) {
  constexpr std::uint64_t sign = std::uint64_t{1} << 63;
  return std::bit_cast<double>(key & sign ? key ^ sign : ~key);
}

constexpr int digit_bits = 8, n_digits = 64 / digit_bits, n_digit_values = 1 << digit_bits;

// This rank's particles that a front counts.
struct Sample {
  std::vector<std::uint64_t> keys;
  std::vector<double> masses;  // only where a quantile is asked for
};

Sample sample_of(const Front& front, const ParticleSet& particles) {
  Sample sample;
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    if (front.material_number >= 0 && particles.material()[p] != front.material_number) continue;
    const double reach = reach_of(front, particles.vector(Field::position, p));
    if (std::isnan(reach)) continue;
    sample.keys.push_back(key_of(reach));
    if (front.quantile < 1.0) sample.masses.push_back(particles.mass(p));
  }
  return sample;
}

// The place of the sought key among all, digit by digit from the highest: each round adds up the mass of the particles that
// agree in the digits found so far, by their next digit.
struct Search {
  std::size_t front;
  double unit = 1.0;         // kg
  GlobalIndex missing = -1;  // units of mass that are still to be found below the next digits; -1: not known yet
  std::uint64_t key = 0;
};

GlobalIndex mass_in_units(double mass, double unit) { return static_cast<GlobalIndex>(std::nearbyint(mass / unit)); }

void add_masses(const Sample& sample, const Search& search, int shift, GlobalIndex* histogram) {
  const bool all = shift == 64 - digit_bits;
  for (std::size_t k = 0; k < sample.keys.size(); ++k) {
    const std::uint64_t key = sample.keys[k];
    if (!all && (key ^ search.key) >> (shift + digit_bits) != 0) continue;
    histogram[(key >> shift) % n_digit_values] += mass_in_units(sample.masses[k], search.unit);
  }
}

void choose_digit(const GlobalIndex* histogram, int shift, double quantile, Search& search) {
  if (search.missing < 0) {
    GlobalIndex total = 0;
    for (int digit = 0; digit < n_digit_values; ++digit) total += histogram[digit];
    // A part in 10^12 less, so that rounding of the quantile asks for no further particle.
    const double wanted = (quantile - 1e-12) * static_cast<double>(total);
    search.missing = std::max<GlobalIndex>(1, static_cast<GlobalIndex>(std::ceil(wanted)));
    search.missing = std::min(search.missing, total);
  }
  std::uint64_t digit = 0;
  while (digit + 1 < n_digit_values && search.missing > histogram[digit]) search.missing -= histogram[digit++];
  search.key |= digit << shift;
}

}  // namespace

double reach_of(const Front& front, const Vec3& position) {
  Vec3 x = position;
  if (front.eye) {
    const Vec3& eye = *front.eye;
    const double below = eye[2] - x[2];
    if (!(below > 0.0)) return std::numeric_limits<double>::quiet_NaN();
    x += (x - eye) * ((x[2] - front.plane) / below);
  }
  const Vec3 arm = x - front.origin;
  if (front.direction) return front.direction->normalized().dot(arm);
  const Vec3 axis = front.axis->normalized();
  return (arm - axis.dot(arm) * axis).norm();
}

std::vector<double> reaches(const Comm& comm, const std::vector<Front>& fronts, const ParticleSet& particles) {
  if (fronts.empty()) return {};
  const std::size_t n = fronts.size();
  std::vector<Sample> samples;
  // Largest reach and mass of a particle; none is less than minus infinity.
  std::vector<double> largest(2 * n, -std::numeric_limits<double>::infinity());
  for (std::size_t f = 0; f < n; ++f) {
    samples.push_back(sample_of(fronts[f], particles));
    for (const std::uint64_t key : samples[f].keys) largest[f] = std::max(largest[f], value_of(key));
    for (const double mass : samples[f].masses) largest[n + f] = std::max(largest[n + f], mass);
  }
  BULKLEY_MPI(
      MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(largest.size()), MPI_DOUBLE, MPI_MAX, comm.get()));
  const GlobalIndex n_particles = sum_global(comm, particles.size());

  std::vector<double> result(n, std::numeric_limits<double>::quiet_NaN());
  std::vector<Search> searches;
  for (std::size_t f = 0; f < n; ++f) {
    if (largest[f] == -std::numeric_limits<double>::infinity()) continue;
    result[f] = largest[f];
    if (fronts[f].quantile == 1.0) continue;
    // All masses together are less than 2^52 units, which a double counts.
    const int exponent = std::ilogb(largest[n + f]) + std::ilogb(static_cast<double>(n_particles)) + 2;
    searches.push_back({f, std::ldexp(1.0, exponent - 52)});
  }
  if (searches.empty()) return result;
  std::vector<GlobalIndex> histograms(searches.size() * n_digit_values);
  for (int shift = 64 - digit_bits; shift >= 0; shift -= digit_bits) {
    std::fill(histograms.begin(), histograms.end(), 0);
    for (std::size_t s = 0; s < searches.size(); ++s)
      add_masses(samples[searches[s].front], searches[s], shift, histograms.data() + s * n_digit_values);
    BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, histograms.data(), static_cast<int>(histograms.size()), MPI_INT64_T, MPI_SUM,
                              comm.get()));
    for (std::size_t s = 0; s < searches.size(); ++s)
      choose_digit(histograms.data() + s * n_digit_values, shift, fronts[searches[s].front].quantile, searches[s]);
  }
  for (const Search& search : searches) result[search.front] = value_of(search.key);
  return result;
}

}  // namespace bulkley
