#include "io/files/write_watchdog.hpp"

#include <csignal>
#include <cstdlib>

#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>

namespace bulkley {

namespace {

constexpr std::chrono::seconds start_of_speaker{2};  // the root speaks and ends first; its end takes the others along

}  // namespace

WriteWatchdog::WriteWatchdog(const Comm& comm, double limit) : limit_(limit), speaks_(comm.is_root()) {
  if (limit_ <= 0.0) return;
  sigset_t all, before;  // signals are the main thread's
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { guard(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

WriteWatchdog::~WriteWatchdog() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

WriteWatchdog::Watch WriteWatchdog::watch(const std::string& file, const std::string& comfort) {
  set(fmt::format(
      "bulkley: writing '{}' has taken longer than {:g} s (checkpoint.timeout): the file system does not answer; {}\n", file,
      limit_, comfort));
  return Watch(*this);
}

void WriteWatchdog::set(const std::string& sentence) {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    sentence_ = sentence;
    deadline_ = std::chrono::steady_clock::now() +
                std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(limit_));
    if (!speaks_) deadline_ += start_of_speaker;
  }
  changed_.notify_one();
}

void WriteWatchdog::guard() {
  std::unique_lock lock(mutex_);
  while (!ends_) {
    if (sentence_.empty()) {
      changed_.wait(lock);
    } else if (std::chrono::steady_clock::now() < deadline_) {
      changed_.wait_until(lock, deadline_);
    } else {
      // Without MPI_Abort, which is the main thread's: mpirun and srun end the other ranks when one ends like this.
      [[maybe_unused]] const ssize_t n = ::write(STDERR_FILENO, sentence_.data(), sentence_.size());
      std::_Exit(static_cast<int>(ExitCode::failed));
    }
  }
}

}  // namespace bulkley
