// ranks: 1 2 3
#include "bulkley/parallel/comm.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <map>
#include <stdexcept>
#include <type_traits>

#include "parallel/node_layout.hpp"
#include "parallel/phases.hpp"
#include "parallel/watchdog.hpp"

namespace bulkley::parallel_mpi_test {
namespace {

enum class Kind { none, usage, run, other };

struct Caught {
  Kind kind = Kind::none;
  std::string text;
};

Caught caught_from(const std::function<void()>& call) {
  try {
    call();
  } catch (const UsageError& error) {
    return {Kind::usage, error.what()};
  } catch (const RunError& error) {
    return {Kind::run, error.what()};
  } catch (...) {
    return {Kind::other, ""};
  }
  return {};
}

class Parallel : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  const int last = comm.size() - 1;
};

TEST_F(Parallel, CommIsADuplicateThatReturnsErrors) {
  int comparison = MPI_UNEQUAL;
  BULKLEY_MPI(MPI_Comm_compare(comm.get(), PETSC_COMM_WORLD, &comparison));
  EXPECT_EQ(comparison, MPI_CONGRUENT);
  MPI_Errhandler handler;
  BULKLEY_MPI(MPI_Comm_get_errhandler(comm.get(), &handler));
  EXPECT_EQ(handler, MPI_ERRORS_RETURN);
  BULKLEY_MPI(MPI_Errhandler_free(&handler));
  EXPECT_EQ(comm.is_root(), comm.rank() == 0);
}

// Several nodes: tests/cluster/nodes/identity.py.
TEST_F(Parallel, RanksOfOneMachineShareANode) {
  const NodeLayout layout = node_layout(comm);
  EXPECT_EQ(layout.ranks_per_node, comm.size());
  EXPECT_TRUE(layout.in_order);
  EXPECT_EQ(placement_fault(layout), "");
}

// Where the root cannot, a rank beside it speaks next and the first rank of the next node before a second one: a lost node, however many ranks
// it had, leaves one that is early.
TEST(SpeakingOrder, AFirstRankOfEveryNodeComesEarlyAndAlone) {
  for (const int ranks_per_node : {1, 2, 48, 128}) {
    const int n_ranks = 5 * ranks_per_node - ranks_per_node / 2;
    std::map<int, int> of_place;
    for (int rank = 0; rank < n_ranks; ++rank) {
      const int place = speaking_order(rank, n_ranks, ranks_per_node);
      if (rank % ranks_per_node == 0) {
        EXPECT_LE(place, 8) << rank;
        EXPECT_EQ(of_place.count(place), 0u) << rank;
      }
      if (rank == 1) {
        EXPECT_EQ(place, 1);
      }
      ++of_place[place];
    }
    EXPECT_EQ(speaking_order(0, n_ranks, ranks_per_node), 0);
    for (int place = 0; place <= 8; ++place) EXPECT_LE(of_place[place], 1) << ranks_per_node;
  }
  for (int rank = 0; rank < 7; ++rank) EXPECT_EQ(speaking_order(rank, 7, 7), rank);
}

TEST_F(Parallel, MovedCommKeepsTheCommunicator) {
  Comm first(comm.get());
  const MPI_Comm handle = first.get();
  const Comm second(std::move(first));
  EXPECT_EQ(second.get(), handle);
  EXPECT_EQ(first.get(), MPI_COMM_NULL);
  EXPECT_EQ(second.size(), comm.size());
  static_assert(!std::is_copy_constructible_v<Comm>);
}

TEST_F(Parallel, Reductions) {
  const GlobalIndex large = GlobalIndex{1} << 40;  // beyond 32 bits
  const GlobalIndex rank = comm.rank(), size = comm.size();
  EXPECT_EQ(sum_global(comm, large + rank), size * large + size * (size - 1) / 2);
  EXPECT_EQ(max_global(comm, large + rank), large + size - 1);
  EXPECT_EQ(min_global(comm, rank - large), -large);
  EXPECT_EQ(max_global(comm, 0.5 - static_cast<double>(rank)), 0.5);
  EXPECT_EQ(min_global(comm, 0.5 - static_cast<double>(rank)), 1.5 - static_cast<double>(size));
  EXPECT_EQ(exclusive_sum(comm, large + rank), rank * large + rank * (rank - 1) / 2);
}

TEST_F(Parallel, EvenSharesFollowEachOtherAndDifferByOneAtMost) {
  for (const GlobalIndex n : {GlobalIndex{0}, GlobalIndex{1}, GlobalIndex{7}, GlobalIndex{1000}, GlobalIndex{1} << 40}) {
    const EvenShare share = even_share(comm, n);
    EXPECT_EQ(exclusive_sum(comm, share.count()), share.first);
    EXPECT_EQ(sum_global(comm, share.count()), n);
    EXPECT_LE(max_global(comm, share.count()) - min_global(comm, share.count()), 1);
  }
}

TEST_F(Parallel, BroadcastText) {
  std::string text = "line 1\nline 2";
  text += '\0';
  text += "after a zero byte";
  EXPECT_EQ(broadcast_text(comm, comm.is_root() ? text : "mine"), text);
  EXPECT_EQ(broadcast_text(comm, comm.is_root() ? "" : "mine"), "");
}

TEST_F(Parallel, GuardPassesWhenNobodyFails) {
  int n_calls = 0;
  const Caught caught = caught_from([&] { collective_guard(comm, [&] { ++n_calls; }); });
  EXPECT_EQ(caught.kind, Kind::none) << caught.text;
  EXPECT_EQ(n_calls, 1);
}

TEST_F(Parallel, GuardTurnsOneFailureIntoTheSameErrorEverywhere) {
  for (int failing = 0; failing < comm.size(); ++failing) {
    const Caught caught = caught_from([&] {
      collective_guard(comm, [&] {
        if (comm.rank() == failing) throw std::runtime_error("the disk is full");
      });
    });
    EXPECT_EQ(caught.kind, Kind::run);
    EXPECT_EQ(caught.text, "rank " + std::to_string(failing) + ": the disk is full");
  }
}

TEST_F(Parallel, GuardKeepsUsageErrors) {
  const Caught caught = caught_from([&] {
    collective_guard(comm, [&] {
      if (comm.rank() == last) throw UsageError("scene.toml:3:1: unknown key");
    });
  });
  EXPECT_EQ(caught.kind, Kind::usage);
  EXPECT_EQ(caught.text, "scene.toml:3:1: unknown key");
}

TEST_F(Parallel, GuardReportsTheLowestRank) {
  const Caught caught = caught_from([&] {
    collective_guard(comm, [&] {
      if (comm.rank() == 0 && comm.size() > 1) return;
      if (comm.rank() == last) throw UsageError("of the last rank");
      throw RunError("of rank " + std::to_string(comm.rank()));
    });
  });
  if (comm.size() <= 2) {
    EXPECT_EQ(caught.kind, Kind::usage);
    EXPECT_EQ(caught.text, "of the last rank");
  } else {
    EXPECT_EQ(caught.kind, Kind::run);
    EXPECT_EQ(caught.text, "rank 1: of rank 1");
  }
}

TEST_F(Parallel, GuardUnderstandsForeignExceptions) {
  const Caught memory = caught_from([&] { collective_guard(comm, [] { throw std::bad_alloc(); }); });
  EXPECT_EQ(memory.kind, Kind::run);
  EXPECT_EQ(memory.text, "rank 0: out of memory");
  const Caught number = caught_from([&] { collective_guard(comm, [] { throw 5; }); });
  EXPECT_EQ(number.kind, Kind::run);
  EXPECT_EQ(number.text, "rank 0: an exception of unknown type");
}

TEST_F(Parallel, RootGuardRunsOnTheRootAndTellsEveryone) {
  int n_calls = 0;
  const Caught good = caught_from([&] { root_guard(comm, [&] { ++n_calls; }); });
  EXPECT_EQ(good.kind, Kind::none);
  EXPECT_EQ(n_calls, comm.is_root() ? 1 : 0);
  const Caught bad = caught_from([&] { root_guard(comm, [] { throw RunError("cannot open history.csv"); }); });
  EXPECT_EQ(bad.kind, Kind::run);
  EXPECT_EQ(bad.text, "cannot open history.csv");
  const Caught usage = caught_from([&] { root_guard(comm, [] { throw UsageError("no such file"); }); });
  EXPECT_EQ(usage.kind, Kind::usage);
}

TEST_F(Parallel, PhasesAccumulate) {
  PhaseTimes times;
  const auto busy = [](double seconds) {
    for (const double start = MPI_Wtime(); MPI_Wtime() - start < seconds;) {
    }
  };
  for (int n = 0; n < 3; ++n) {
    const PhaseTimer step(times, Phase::p2g);
    busy(0.001);
    {
      const PhaseTimer inner(times, Phase::exchange);
      busy(0.002);
    }
  }
  EXPECT_GE(times[Phase::exchange].seconds, 0.006);
  EXPECT_GE(times[Phase::p2g].seconds, times[Phase::exchange].seconds + 0.003);
  EXPECT_EQ(times[Phase::sort].seconds, 0.0);
  const std::vector<PhaseSummary> summary = summarize(comm, times);
  EXPECT_EQ(summary.size(), 2u);
  if (summary.size() == 2) {
    EXPECT_EQ(summary[0].name, "p2g");
    EXPECT_EQ(summary[1].name, "exchange");
    EXPECT_EQ(summary[1].n_calls, 3);
    EXPECT_LE(summary[1].smallest, times[Phase::exchange].seconds);
    EXPECT_GE(summary[1].largest, times[Phase::exchange].seconds);
    EXPECT_LE(summary[1].smallest, summary[1].mean);
    EXPECT_LE(summary[1].mean, summary[1].largest);
  }
}

TEST_F(Parallel, PhasesOfSomeRanksAreSummarizedByPhase) {
  // Every rank runs two of three phases, in an order of its own; the summary is in the order of the enumeration.
  PhaseTimes times;
  const Phase phases[3] = {Phase::p2g, Phase::g2p, Phase::balance};
  const int left_out = comm.rank() % 3;
  for (int n = 2; n >= 1; --n) {
    const PhaseTimer timer(times, phases[(left_out + n) % 3]);
    for (const double start = MPI_Wtime(); MPI_Wtime() - start < 0.001;) {
    }
  }
  const std::vector<PhaseSummary> summary = summarize(comm, times);
  EXPECT_EQ(summary.size(), comm.size() == 1 ? 2u : 3u);
  for (const PhaseSummary& phase : summary) {
    EXPECT_EQ(phase.n_calls, 1) << phase.name;
    EXPECT_GE(phase.largest, 0.001) << phase.name;
  }
  for (const Phase phase : phases) {
    const auto found =
        std::find_if(summary.begin(), summary.end(), [&](const PhaseSummary& s) { return s.name == name(phase); });
    if (found == summary.end()) {
      EXPECT_EQ(times[phase].n_calls, 0) << name(phase);
      continue;
    }
    EXPECT_GE(found->largest, times[phase].seconds) << name(phase);
    EXPECT_LE(found->smallest, times[phase].seconds) << name(phase);
  }
}

}  // namespace
}  // namespace bulkley::parallel_mpi_test
