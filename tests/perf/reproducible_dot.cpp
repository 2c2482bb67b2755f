// What an order-free dot product costs beside a plain one, for arrays that no cache holds. Prints both; fails beyond the
// promise.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <random>
#include <vector>

#include "base/binned_sum.hpp"
#include "bulkley/base/pack.hpp"

namespace {

using namespace bulkley;

constexpr double promised = 2.5;

double plain_dot(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr std::size_t n_sums = 4;  // independent ones, so that additions need not wait for each other
  Pack sums[n_sums] = {};
  const std::size_t step = n_sums * n_lanes;
  for (std::size_t i = 0; i + step <= a.size(); i += step)
    for (std::size_t k = 0; k < n_sums; ++k) sums[k] += load(&a[i + k * n_lanes]) * load(&b[i + k * n_lanes]);
  double total = 0.0;
  for (const Pack& sum : sums)
    for (int lane = 0; lane < n_lanes; ++lane) total += sum[lane];
  return total;
}

template <class Work>
double seconds(Work work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

int main() {
  constexpr std::size_t size = 10'000'000;
  std::vector<double> a(size), b(size);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (double& x : a) x = normal(random);
  for (double& x : b) x = normal(random);

  // In turn, the best of each: others may use the machine.
  double plain = 0.0, binned = 0.0, plain_time = 1e9, binned_time = 1e9;
  for (int round = 0; round < 25; ++round) {
    plain_time = std::min(plain_time, seconds([&] { plain = plain_dot(a, b); }));
    binned_time = std::min(binned_time, seconds([&] {
                             BinnedSum sum;
                             sum.add_products(a, b);
                             binned = sum.value();
                           }));
  }
  const double ratio = binned_time / plain_time;
  std::printf("%zu products: plain %.2f ms (%.17g), order-free %.2f ms (%.17g), ratio %.2f, promised %.1f\n", size,
              1e3 * plain_time, plain, 1e3 * binned_time, binned, ratio, promised);
  return ratio <= promised ? 0 : 1;
}
