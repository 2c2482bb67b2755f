#pragma once
// A communicator of our own, reductions, and errors that cannot deadlock.

#include <mpi.h>

#include <functional>
#include <source_location>
#include <string>

#include "bulkley/base/error.hpp"
#include "bulkley/base/types.hpp"

namespace bulkley {

/// Aborts all ranks with a message that names the failed call; for MPI return codes.
void check_mpi(int code, const char* call, const char* file, int line);
#define BULKLEY_MPI(call) ::bulkley::check_mpi((call), #call, __FILE__, __LINE__)

/// What is to blame for an abort: this program or what it was given, or the machine, with which a run can go on from its checkpoint.
enum class Fault { program, machine };

/// Prints `message` with rank, file and line to stderr and ends every rank with exit code 3 through MPI_Abort.
/// Not collective.
[[noreturn]] void abort_all_ranks(const std::string& message, const char* file, int line, Fault fault = Fault::program);

class Comm;
/// Ends all ranks where a message that came from `rank` belongs to another map, plan or piece of work, `what`, than the one that this
/// rank is at. Not collective.
void expect_number(const Comm& comm, const char* what, int rank, GlobalIndex theirs, GlobalIndex ours,
                   const std::source_location& place = std::source_location::current());
/// `what` of messages that tell a number of Comm::draw_number.
inline constexpr const char* joint_work = "joint work of number";

/// While it lives, abort_all_ranks calls `work` with its message and the fault before it ends the ranks, and adds what it returns to the
/// message; on the rank that aborts only, so `work` must not communicate. One at a time.
class AbortHook {
 public:
  using Work = std::function<std::string(const std::string& message, Fault fault)>;
  explicit AbortHook(Work work);
  ~AbortHook();
  AbortHook(const AbortHook&) = delete;
  AbortHook& operator=(const AbortHook&) = delete;
};

/// Makes a failed BULKLEY_ASSERT end every rank; called once by each main() that starts MPI. Not collective.
void install_assert_handler();

/// Owner of a duplicate of a communicator whose errors are returned, so that BULKLEY_MPI can report them. Move-only.
class Comm {
 public:
  explicit Comm(MPI_Comm parent);  ///< Collective.
  ~Comm();                         ///< Collective.
  Comm(Comm&& other) noexcept;
  Comm& operator=(Comm&&) = delete;
  MPI_Comm get() const { return comm_; }
  int rank() const { return rank_; }
  int size() const { return size_; }
  bool is_root() const { return rank_ == 0; }
  /// 1, 2, 3, ...: a name for what all ranks are about to do together, to be told in their messages. Not collective, but every rank
  /// must draw at the same points.
  GlobalIndex draw_number() const { return ++n_drawn_; }

 private:
  mutable GlobalIndex n_drawn_ = 0;
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0;
  int size_ = 1;
};

/// Sum, minimum, maximum over ranks of exact quantities. Collective.
GlobalIndex sum_global(const Comm& comm, GlobalIndex value);
GlobalIndex max_global(const Comm& comm, GlobalIndex value);
GlobalIndex min_global(const Comm& comm, GlobalIndex value);
double max_global(const Comm& comm, double value);
double min_global(const Comm& comm, double value);
/// Sum of `value` over the ranks below this one. Collective.
GlobalIndex exclusive_sum(const Comm& comm, GlobalIndex value);

/// Things first, first + 1, ... end - 1.
struct EvenShare {
  GlobalIndex first, end;
  GlobalIndex count() const { return end - first; }
};

/// This rank's part of `n` items, in the order of ranks; no two parts differ by more than one. Not collective.
EvenShare even_share(const Comm& comm, GlobalIndex n);
/// The rank in whose part item number `item` is, 0 <= item < n. Not collective.
int sharer_of(const Comm& comm, GlobalIndex n, GlobalIndex item);

/// The root's text on every rank. Collective.
std::string broadcast_text(const Comm& comm, std::string text);

/// Runs local work that may throw; if any rank threw, every rank throws the error of the lowest such rank (UsageError stays
/// one, anything else becomes RunError naming the rank). `work` must not communicate. Collective.
void collective_guard(const Comm& comm, const std::function<void()>& work);

/// As collective_guard, for work that only the root does. Collective.
void root_guard(const Comm& comm, const std::function<void()>& work);

}  // namespace bulkley
