#pragma once
// A write that never ends becomes an error: file systems over a network can leave a call hanging forever.

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// A thread of every rank that ends the program (exit code 3) when a watched write takes too long. It calls neither MPI nor
/// the file system for anything: both may be what hangs.
class WriteWatchdog {
 public:
  /// `limit`: s; 0: no thread, nothing is watched. Not collective.
  WriteWatchdog(const Comm& comm, double limit);
  ~WriteWatchdog();
  WriteWatchdog(const WriteWatchdog&) = delete;
  WriteWatchdog& operator=(const WriteWatchdog&) = delete;

  /// Watches from its making to its end.
  class Watch {
   public:
    explicit Watch(WriteWatchdog& dog) : dog_(dog) {}
    ~Watch() { dog_.set({}); }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

   private:
    WriteWatchdog& dog_;
  };

  /// The write of `file` begins. `comfort`: what the sentence adds, such as the last good checkpoint. Not collective.
  [[nodiscard]] Watch watch(const std::string& file, const std::string& comfort);

 private:
  void set(const std::string& sentence);
  void guard();

  const double limit_;
  const bool speaks_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string sentence_;  // empty: nothing is being written
  std::chrono::steady_clock::time_point deadline_;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace bulkley
