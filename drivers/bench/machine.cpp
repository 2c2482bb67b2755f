// Compiled with fused products and sums, as the kernels are.
#include "bench/machine.hpp"

#include <sched.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "bulkley/base/pack.hpp"

namespace bulkley {

namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

constexpr std::size_t n_triad = std::size_t{100} << 17;  // 100 MiB an array

// Elements per second.
double triad_rate() {
  constexpr int n_passes = 20;
  std::vector<double> a(n_triad, 0.0), b(n_triad, 1.0), c(n_triad, 2.0);
  double best = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < n_passes; ++pass) {
    const double begin = now();
    const double s = 1.0 + pass;
    for (std::size_t k = 0; k < n_triad; ++k) a[k] = b[k] + s * c[k];
    best = std::min(best, now() - begin);
    std::swap(a, b);  // so that no pass can be left out
  }
  return static_cast<double>(n_triad) / best;
}

double sum_of_lanes(Pack pack) {
  double sum = 0.0;
  for (int lane = 0; lane < n_lanes; ++lane) sum += pack[lane];
  return sum;
}

// Operations per second.
double pack_rate() {
#if defined(__AVX__)
  constexpr int n_chains = 12;  // enough to hide the latency, few enough to stay in registers
#else
  constexpr int n_chains = 4;
#endif
  constexpr int n_links = 200'000, n_passes = 20;
  const Pack factor = broadcast<Pack>(1.0 - 1e-9), addend = broadcast<Pack>(1e-9);
  double best = std::numeric_limits<double>::infinity();
  volatile double sink = 0.0;
  for (int pass = 0; pass < n_passes; ++pass) {
    Pack chain[n_chains];
    for (int k = 0; k < n_chains; ++k) chain[k] = broadcast<Pack>(k + sink * 1e-30);
    const double begin = now();
    for (int link = 0; link < n_links; ++link)
      for (Pack& x : chain) x = x * factor + addend;
    best = std::min(best, now() - begin);
    for (const Pack& x : chain) sink = sink + sum_of_lanes(x);
  }
  return 2.0 * n_lanes * n_chains * n_links / best;
}

}  // namespace

MachineLimits measure_machine() {
  const double elements = triad_rate();
  return {24.0 * elements, 32.0 * elements, pack_rate()};
}

double MemoryStreams::memory(int n_threads) { return 3.0 * sizeof(double) * n_triad * n_threads; }

MemoryStreams::MemoryStreams(int n_threads) {
  for (int t = 0; t < n_threads; ++t)
    threads_.emplace_back([this] {
      std::vector<double> a(n_triad, 0.0), b(n_triad, 1.0), c(n_triad, 2.0);
      ++n_started_;
      for (double s = 1.0; !ended_; s = 1.5 - 0.5 * s) {
        for (std::size_t k = 0; k < n_triad; ++k) a[k] = b[k] + s * c[k];
        std::swap(a, b);
        ++n_passes_;
      }
    });
  while (n_started_ < n_threads) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  n_passes_ = 0;
  begin_ = now();
}

MemoryStreams::~MemoryStreams() {
  ended_ = true;
  for (std::thread& thread : threads_) thread.join();
}

double MemoryStreams::traffic_bandwidth() const {
  return 32.0 * static_cast<double>(n_triad) * static_cast<double>(n_passes_) / (now() - begin_);
}

bool fits_into_memory(double bytes) {
  std::ifstream file("/proc/meminfo");
  for (std::string word; file >> word;) {
    double kibibytes = 0.0;
    if (word == "MemAvailable:" && file >> kibibytes) return 1.1 * bytes < kibibytes * 1024.0;
  }
  return true;
}

int n_usable_cores() {
  cpu_set_t cores;
  if (::sched_getaffinity(0, sizeof cores, &cores) == 0) return CPU_COUNT(&cores);
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace bulkley
