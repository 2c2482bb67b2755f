#pragma once
// What does not come to an end becomes an error: a file system may leave a call hanging forever, and so may a rank on a
// machine that is gone.

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// The place of a rank among those that speak when something hangs, two seconds apart, until the first ends all: the root, then in turn
/// a rank of its node and the first one of another node; of 60 on, and for the other ranks of other nodes, it is 60. On one node, or where
/// nodes are not known, the rank. Not collective.
int speaking_order(int rank, int n_ranks, int ranks_per_node);

/// A thread of every rank that ends the program (exit code 3) when something that is watched takes too long, and when the
/// launcher of the ranks is gone. Where the launcher finds first that a host is gone, it tells the ranks to end (SIGTERM) and
/// kills them soon after: the root and the first rank of each host then say what they are in and do the last act, but go on.
/// It calls neither MPI nor the file system itself: both may be what hangs. Time in which this process was stopped as a
/// whole, such as a suspended job, does not count.
class Watchdog {
 public:
  /// What is watched. Both functions are called by the watchdog's thread and must not touch what the main thread changes.
  struct Task {
    double limit = 0.0;                     ///< s; 0: it may take as long as it likes
    double usual = 0.0;                     ///< s, that it may well take
    std::function<std::string()> sentence;  ///< what is printed at the limit, without "bulkley: "
    std::function<std::string()> place;     ///< what this rank does, and the last checkpoint: the end of other sentences
    /// Done, with the sentence, after it; given up after a second. May be empty.
    std::function<void(const std::string& sentence)> last_act = {};
  };

  /// Collective.
  explicit Watchdog(const Comm& comm);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// Watches from its making to its end. Watches nest: the innermost counts, and the one around it begins anew after it.
  class Watch {
   public:
    explicit Watch(Watchdog& dog) : dog_(dog) {}
    ~Watch() { dog_.pop(); }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

   private:
    Watchdog& dog_;
  };

  /// `task` begins. Not collective.
  [[nodiscard]] Watch watch(Task task);

 private:
  using Clock = std::chrono::steady_clock;

  void pop();
  void begin_top();
  void guard();
  [[noreturn]] void end(const Task& task) const;
  void speak_before_being_killed();

  const double delay_;          // s, after the limit: the root speaks and ends first
  const double delay_if_told_;  // s, after it has been told to end and has not; negative: others speak
  const int launcher_;          // its process; 0: there is none
  const std::string rank_;      // who this is
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Task> tasks_;  // the innermost last
  Clock::time_point deadline_;
  Clock::time_point told_;  // when it has been told to end
  int n_begun_ = 0;         // watches
  int begun_when_told_ = -1;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace bulkley
