#include "parallel/watchdog.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <future>
#include <memory>

#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>

#include "parallel/node_layout.hpp"
#include "parallel/signals.hpp"

namespace bulkley {

namespace {

// The end of the root takes the others along. Where it cannot act, they speak one after the other, and the first ends the rest.
constexpr double start_of_root = 1.0, start_of_next = 2.0;  // s
constexpr int most_starts = 60;

constexpr std::chrono::milliseconds look_interval{100};
// A look that comes as much later than it should was held up with the whole process, as by SIGSTOP.
constexpr std::chrono::seconds stopped_for{3};
constexpr std::chrono::seconds last_act_limit{5};
// A rank that has been told to stop is perhaps being ended by the launcher already, because another has spoken.
constexpr std::chrono::seconds time_to_be_ended{5};

// mpirun kills a rank a second after it has told it to end.
constexpr double told_root = 0.25, told_first_of_host = 0.5;  // s

double delay_of(const Comm& comm) {
  const int place = speaking_order(comm.rank(), comm.size(), node_layout(comm).ranks_per_node);
  return place == 0 ? 0.0 : start_of_root + start_of_next * std::min(place, most_starts);
}

double delay_if_told_of(const Comm& comm) {
  if (comm.is_root()) return told_root;
  for (const char* variable : {"OMPI_COMM_WORLD_LOCAL_RANK", "SLURM_LOCALID"})
    if (const char* local = std::getenv(variable)) return std::string(local) == "0" ? told_first_of_host : -1.0;
  return -1.0;
}

template <class Seconds>
std::chrono::steady_clock::duration duration_of(Seconds seconds) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(seconds));
}

void say(const std::string& sentence) {
  const std::string line = fmt::format("bulkley: {}\n", sentence);
  [[maybe_unused]] const ssize_t n = ::write(STDERR_FILENO, line.data(), line.size());
}

void do_last_act(const Watchdog::Task& task, const std::string& sentence) {
  if (!task.last_act) return;
  auto done = std::make_shared<std::promise<void>>();
  const std::future<void> finished = done->get_future();
  std::thread([done, sentence, act = task.last_act] {
    try {
      act(sentence);
    } catch (...) {  // the sentence is out; the exit code says the rest
    }
    done->set_value();
  }).detach();
  finished.wait_for(last_act_limit);
}

// Without MPI_Abort, which is the main thread's: mpirun and srun end the other ranks when one ends like this.
[[noreturn]] void exit_now() { std::_Exit(static_cast<int>(ExitCode::failed)); }

}  // namespace

int speaking_order(int rank, int n_ranks, int ranks_per_node) {
  if (n_ranks <= ranks_per_node || ranks_per_node == 1) return rank;
  const int node = rank / ranks_per_node, local = rank % ranks_per_node;
  if (node == 0) return local == 0 ? 0 : 2 * local - 1;
  return local == 0 ? 2 * node : most_starts;
}

Watchdog::Watchdog(const Comm& comm)
    : delay_(delay_of(comm)),
      delay_if_told_(delay_if_told_of(comm)),
      launcher_(comm.size() > 1 ? ::getppid() : 0),
      rank_(fmt::format("rank {} of {}", comm.rank(), comm.size())) {
  sigset_t all, before;  // signals are the main thread's
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { guard(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

Watchdog::~Watchdog() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

Watchdog::Watch Watchdog::watch(Task task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
    begin_top();
  }
  return Watch(*this);
}

void Watchdog::pop() {
  const std::lock_guard lock(mutex_);
  tasks_.pop_back();
  begin_top();
}

void Watchdog::begin_top() {
  ++n_begun_;
  if (!tasks_.empty()) deadline_ = Clock::now() + duration_of(tasks_.back().limit + delay_);
}

// Looks in intervals, so that a step, which is short, need not wake this thread.
void Watchdog::guard() {
  std::unique_lock lock(mutex_);
  Clock::time_point last = Clock::now();
  while (!ends_) {
    changed_.wait_for(lock, look_interval);
    const Clock::time_point now = Clock::now();
    if (now - last > look_interval + stopped_for) deadline_ += now - last;
    last = now;
    if (ends_) return;
    if (launcher_ != 0 && ::getppid() != launcher_) {
      const std::string sentence =
          fmt::format("{} has lost what started it, and ends{}", rank_, tasks_.empty() ? "" : tasks_.back().place());
      say(sentence);
      if (!tasks_.empty() && delay_ == 0.0) do_last_act(tasks_.back(), sentence);
      exit_now();
    }
    speak_before_being_killed();
    if (!tasks_.empty() && tasks_.back().limit > 0.0 && now >= deadline_) end(tasks_.back());
  }
}

void Watchdog::end(const Task& task) const {
  if (delay_ > 0.0 && pending_request() == Request::stop) std::this_thread::sleep_for(time_to_be_ended);
  const std::string sentence = task.sentence();
  say(sentence);
  do_last_act(task, sentence);
  exit_now();
}

// Once, if what was going on when the launcher told this rank to end goes on longer than usual. The main thread cannot leave
// it meanwhile, so that the last act is not done beside it.
void Watchdog::speak_before_being_killed() {
  if (delay_if_told_ < 0.0 || tasks_.empty() || !told_to_end()) return;
  if (begun_when_told_ < 0) {
    begun_when_told_ = n_begun_;
    told_ = Clock::now();
  }
  const Task& task = tasks_.back();
  if (begun_when_told_ != n_begun_ || Clock::now() < told_ + duration_of(std::max(delay_if_told_, task.usual))) return;
  begun_when_told_ = 0;
  const std::string sentence = fmt::format("{} was told to end, and cannot{}", rank_, task.place());
  say(sentence);
  do_last_act(task, sentence);
}

}  // namespace bulkley
