#include "bulkley/parallel/comm.hpp"

#include <fmt/format.h>
#include <petscsys.h>

#include <algorithm>
#include <cstdio>
#include <new>
#include <utility>

namespace bulkley {

namespace {

constexpr GlobalIndex message_limit = GlobalIndex{1} << 30;  // bytes; MPI counts are int

void report_failed_assert(const char* expression, const char* file, int line) {
  abort_all_ranks(fmt::format("internal error: '{}' is false", expression), file, line);
}

template <class T>
T all_reduce(const Comm& comm, T value, MPI_Datatype type, MPI_Op operation) {
  T result{};
  BULKLEY_MPI(MPI_Allreduce(&value, &result, 1, type, operation, comm.get()));
  return result;
}

std::string broadcast_text_from(const Comm& comm, int source, std::string text) {
  GlobalIndex size = static_cast<GlobalIndex>(text.size());
  BULKLEY_MPI(MPI_Bcast(&size, 1, MPI_INT64_T, source, comm.get()));
  text.resize(static_cast<std::size_t>(size));
  for (GlobalIndex sent = 0; sent < size; sent += message_limit) {
    const int count = static_cast<int>(std::min(message_limit, size - sent));
    BULKLEY_MPI(MPI_Bcast(text.data() + sent, count, MPI_CHAR, source, comm.get()));
  }
  return text;
}

AbortHook::Work abort_work;

// What the run in progress has to say to its abort; nothing if that fails in turn.
std::string abort_words(const std::string& message, Fault fault) {
  if (!abort_work) return {};
  try {
    return std::exchange(abort_work, nullptr)(message, fault);  // an abort inside it must not call it again
  } catch (const std::exception&) {
    return {};
  }
}

enum class Failure : int { none, usage, run };

struct Outcome {
  Failure failure = Failure::none;
  std::string text;
};

Outcome outcome_of(const std::function<void()>& work) {
  try {
    work();
    return {};
  } catch (const UsageError& error) {
    return {Failure::usage, error.what()};
  } catch (const std::bad_alloc&) {
    return {Failure::run, "out of memory"};
  } catch (const std::exception& error) {
    return {Failure::run, error.what()};
  } catch (...) {
    return {Failure::run, "an exception of unknown type"};
  }
}

[[noreturn]] void throw_outcome(const Outcome& outcome) {
  if (outcome.failure == Failure::usage) throw UsageError(outcome.text);
  throw RunError(outcome.text);
}

}  // namespace

void check_mpi(int code, const char* call, const char* file, int line) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = "unknown error code";
  int length = 0;
  MPI_Error_string(code, text, &length);
  abort_all_ranks(fmt::format("{} failed: {}", call, text), file, line, Fault::machine);
}

void abort_all_ranks(const std::string& message, const char* file, int line, Fault fault) {
  int running = 0, finalized = 0;
  MPI_Initialized(&running);
  MPI_Finalized(&finalized);
  if (!running || finalized) {
    std::fprintf(stderr, "bulkley: %s (%s:%d)\n", message.c_str(), file, line);
    std::_Exit(static_cast<int>(ExitCode::failed));
  }
  // PETSc's world is the program's; it does not exist before PetscInitialize and after PetscFinalize.
  const MPI_Comm all = PETSC_COMM_WORLD != MPI_COMM_NULL ? PETSC_COMM_WORLD : MPI_COMM_SELF;
  int rank = 0;
  MPI_Comm_rank(all, &rank);
  std::fprintf(stderr, "bulkley: rank %d: %s%s (%s:%d)\n", rank, message.c_str(), abort_words(message, fault).c_str(), file,
               line);
  std::fflush(nullptr);
  MPI_Abort(all, static_cast<int>(ExitCode::failed));
  std::_Exit(static_cast<int>(ExitCode::failed));
}

void expect_number(const Comm& comm, const char* what, int rank, GlobalIndex theirs, GlobalIndex ours,
                   const std::source_location& place) {
  if (theirs != ours)
    abort_all_ranks(fmt::format("rank {} sends what belongs to {} {}, but rank {} is at {} {}", rank, what, theirs,
                                comm.rank(), what, ours),
                    place.file_name(), static_cast<int>(place.line()));
}

AbortHook::AbortHook(Work work) { abort_work = std::move(work); }
AbortHook::~AbortHook() { abort_work = nullptr; }

void install_assert_handler() { assert_handler = report_failed_assert; }

Comm::Comm(MPI_Comm parent) {
  BULKLEY_MPI(MPI_Comm_dup(parent, &comm_));
  BULKLEY_MPI(MPI_Comm_set_errhandler(comm_, MPI_ERRORS_RETURN));
  BULKLEY_MPI(MPI_Comm_rank(comm_, &rank_));
  BULKLEY_MPI(MPI_Comm_size(comm_, &size_));
}

Comm::~Comm() {
  if (comm_ != MPI_COMM_NULL) BULKLEY_MPI(MPI_Comm_free(&comm_));
}

Comm::Comm(Comm&& other) noexcept
    : comm_(std::exchange(other.comm_, MPI_COMM_NULL)), rank_(other.rank_), size_(other.size_) {}

GlobalIndex sum_global(const Comm& comm, GlobalIndex value) { return all_reduce(comm, value, MPI_INT64_T, MPI_SUM); }
GlobalIndex max_global(const Comm& comm, GlobalIndex value) { return all_reduce(comm, value, MPI_INT64_T, MPI_MAX); }
GlobalIndex min_global(const Comm& comm, GlobalIndex value) { return all_reduce(comm, value, MPI_INT64_T, MPI_MIN); }
double max_global(const Comm& comm, double value) { return all_reduce(comm, value, MPI_DOUBLE, MPI_MAX); }
double min_global(const Comm& comm, double value) { return all_reduce(comm, value, MPI_DOUBLE, MPI_MIN); }

GlobalIndex exclusive_sum(const Comm& comm, GlobalIndex value) {
  GlobalIndex sum = 0;
  BULKLEY_MPI(MPI_Exscan(&value, &sum, 1, MPI_INT64_T, MPI_SUM, comm.get()));
  return comm.is_root() ? 0 : sum;  // MPI leaves the first rank's result undefined
}

EvenShare even_share(const Comm& comm, GlobalIndex n) {
  return {n * comm.rank() / comm.size(), n * (comm.rank() + 1) / comm.size()};
}

int sharer_of(const Comm& comm, GlobalIndex n, GlobalIndex item) {
  return static_cast<int>((comm.size() * (item + 1) - 1) / n);
}

std::string broadcast_text(const Comm& comm, std::string text) { return broadcast_text_from(comm, 0, std::move(text)); }

void collective_guard(const Comm& comm, const std::function<void()>& work) {
  Outcome outcome = outcome_of(work);
  const bool failed = outcome.failure != Failure::none;
  const int first_failed = all_reduce(comm, failed ? comm.rank() : comm.size(), MPI_INT, MPI_MIN);
  if (first_failed == comm.size()) return;

  BULKLEY_MPI(MPI_Bcast(&outcome.failure, 1, MPI_INT, first_failed, comm.get()));
  outcome.text = broadcast_text_from(comm, first_failed, std::move(outcome.text));
  if (outcome.failure == Failure::run) outcome.text = fmt::format("rank {}: {}", first_failed, outcome.text);
  throw_outcome(outcome);
}

void root_guard(const Comm& comm, const std::function<void()>& work) {
  Outcome outcome;
  if (comm.is_root()) outcome = outcome_of(work);
  BULKLEY_MPI(MPI_Bcast(&outcome.failure, 1, MPI_INT, 0, comm.get()));
  if (outcome.failure == Failure::none) return;
  outcome.text = broadcast_text(comm, std::move(outcome.text));
  throw_outcome(outcome);
}

}  // namespace bulkley
