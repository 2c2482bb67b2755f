#pragma once
// What the machine can do at best: the floor under every step. One core; not collective.

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace bulkley {

struct MachineLimits {
  double triad_bandwidth = 0.0;    ///< bytes/s of a = b + s c as the code counts them, 24 per element
  double traffic_bandwidth = 0.0;  ///< bytes/s with the line of `a` that is read before it is written, 32 per element
  double flops = 0.0;  ///< operations/s of packs as the compiler makes them, a fused product and sum counted as two
};

/// Best of several passes over arrays far beyond the last cache (300 MiB in all), and of chains of packs in registers.
MachineLimits measure_machine();

/// Threads that do nothing but stream memory (a = b + s c over 300 MiB each) as long as this lives, as other ranks on a full
/// node would at worst. The constructor returns when all of them do.
class MemoryStreams {
 public:
  explicit MemoryStreams(int n_threads);
  ~MemoryStreams();
  MemoryStreams(const MemoryStreams&) = delete;
  MemoryStreams& operator=(const MemoryStreams&) = delete;
  /// Bytes that so many threads take.
  static double memory(int n_threads);
  /// Bytes/s of all of them so far, 32 per element.
  double traffic_bandwidth() const;

 private:
  std::atomic<bool> ended_ = false;
  std::atomic<long> n_started_ = 0, n_passes_ = 0;
  double begin_ = 0.0;  ///< s
  std::vector<std::thread> threads_;
};

/// Whether so many bytes, and a tenth more, could be had without swapping; true if the system does not report it.
bool fits_into_memory(double bytes);

/// Cores that this process may run on.
int n_usable_cores();

}  // namespace bulkley
