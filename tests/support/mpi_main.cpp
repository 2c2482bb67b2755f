// main() of the tests that need MPI: every rank runs every test, the exit code is the worst over the ranks.
// The root prints as usual; the other ranks print their failures only, each with its rank.

#include <gtest/gtest.h>
#include <petscsys.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "bulkley/parallel/petsc.hpp"

namespace {

class FailurePrinter : public testing::EmptyTestEventListener {
 public:
  explicit FailurePrinter(int rank) : rank_(rank) {}

  void OnTestStart(const testing::TestInfo& test) override {
    test_ = std::string(test.test_suite_name()) + "." + test.name();  // cannot be asked for while a result is reported
  }
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (!result.failed()) return;
    std::fprintf(stderr, "[rank %d] %s, %s:%d: failure\n%s\n", rank_, test_.c_str(),
                 result.file_name() ? result.file_name() : "", result.line_number(), result.message());
    std::fflush(stderr);
  }

 private:
  int rank_;
  std::string test_;
};

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  // An exception that leaves a test ends the process, and with it the job; caught on one rank only, it would leave the
  // others waiting.
  GTEST_FLAG_SET(catch_exceptions, false);
  if (GTEST_FLAG_GET(list_tests)) return RUN_ALL_TESTS();  // one process, without MPI

  setenv("HWLOC_COMPONENTS", "-gl", 0);  // as the program does, see run_program
  BULKLEY_PETSC(PetscInitializeNoArguments());
  bulkley::install_assert_handler();
  int rank = 0;
  BULKLEY_MPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank != 0) {
    testing::TestEventListeners& listeners = testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new FailurePrinter(rank));
  }

  const int result = RUN_ALL_TESTS();
  int worst = 0;
  BULKLEY_MPI(MPI_Allreduce(&result, &worst, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD));
  BULKLEY_PETSC(PetscFinalize());
  return worst;
}
