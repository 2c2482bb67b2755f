#pragma once
// The error kinds of the project (docs/architecture.md, "Errors that cannot deadlock").

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace bulkley {

/// What the process returns to the shell.
enum class ExitCode : int {
  finished = 0,  ///< the run reached its end
  differs = 1,   ///< `compare` found a difference
  usage = 2,     ///< the user's input is wrong
  failed = 3,    ///< the run failed: physics or I/O
  stopped = 4,   ///< stopped early with a good checkpoint
};

/// The user's input is wrong; the text is one sentence naming key, value and allowed range. Exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The run failed (physics or I/O); thrown on every rank, or inside collective_guard. Exit code 3.
struct RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reports a broken invariant of our own and ends the process; MPI programs replace it by one that also aborts all ranks.
using AssertHandler = void (*)(const char* expression, const char* file, int line);

inline void default_assert_handler(const char* expression, const char* file, int line) {
  std::fprintf(stderr, "bulkley: internal error: '%s' is false at %s:%d\n", expression, file, line);
  std::abort();
}

inline AssertHandler assert_handler = default_assert_handler;

}  // namespace bulkley

#if defined(BULKLEY_AUDIT) || !defined(NDEBUG)
#define BULKLEY_ASSERT(condition) ((condition) ? (void)0 : ::bulkley::assert_handler(#condition, __FILE__, __LINE__))
#else
#define BULKLEY_ASSERT(condition) ((void)sizeof(!(condition)))
#endif
