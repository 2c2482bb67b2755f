// ranks: 1 3
#include "io/status/history.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "io/files/text_file.hpp"
#include "io/status/status.hpp"
#include "support/io_particles.hpp"

namespace bulkley::history_mpi_test {
namespace {

const std::vector<std::string> columns{"step", "time (s)", "limiter"};

class HistoryFile : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  SharedFolder folder{comm};

  std::string text_of(const std::string& name) {
    std::string text;
    root_guard(comm, [&] { text = whole_file(folder.file(name)); });
    return broadcast_text(comm, text);
  }
};

TEST_F(HistoryFile, RowsAreThereAtOnceAndRoundTrip) {
  History history(comm, folder.path(), columns, -1);
  EXPECT_EQ(text_of("history.csv"), "step,time (s),limiter\n");
  history.write(comm, {GlobalIndex{1}, 0.1, std::string("speed")});
  history.write(comm, {GlobalIndex{2}, 0.1 + 0.2, std::string("a \"quoted\", word")});
  history.write(comm, {GlobalIndex{3}, std::nan(""), std::string()});
  EXPECT_EQ(text_of("history.csv"),
            "step,time (s),limiter\n1,0.1,speed\n2,0.30000000000000004,\"a \"\"quoted\"\", word\"\n3,nan,\n");
}

TEST_F(HistoryFile, RefusesARowOfTheWrongLength) {
  History history(comm, folder.path(), columns, -1);
  EXPECT_NE(sentence_of<RunError>([&] { history.write(comm, {GlobalIndex{1}}); }).find("1 values for the 3 columns"),
            std::string::npos);
}

TEST_F(HistoryFile, RestartCutsWhatIsRunAgain) {
  root_guard(comm,
             [&] { replace_file(folder.file("history.csv"), "step,time (s),limiter\n1,0.1,a\n5,0.5,b\n9,0.9,c\n12,1.2"); });
  {
    History history(comm, folder.path(), columns, 5);
    history.write(comm, {GlobalIndex{6}, 0.6, std::string("d")});
  }
  EXPECT_EQ(text_of("history.csv"), "step,time (s),limiter\n1,0.1,a\n5,0.5,b\n6,0.6,d\n");
  { const History history(comm, folder.path(), columns, 100); }
  EXPECT_EQ(text_of("history.csv"), "step,time (s),limiter\n1,0.1,a\n5,0.5,b\n6,0.6,d\n");
  { const History history(comm, folder.path(), columns, -1); }
  EXPECT_EQ(text_of("history.csv"), "step,time (s),limiter\n");
}

TEST_F(HistoryFile, RestartInAnEmptyFolderBeginsATable) {
  { const History history(comm, folder.path(), columns, 7); }
  EXPECT_EQ(text_of("history.csv"), "step,time (s),limiter\n");
}

TEST_F(HistoryFile, RestartRefusesATableThatIsNotOurs) {
  root_guard(comm, [&] { replace_file(folder.file("history.csv"), "step,energy\n1,2\n"); });
  EXPECT_NE(sentence_of<RunError>([&] { History(comm, folder.path(), columns, 5); }).find("its columns are not those"),
            std::string::npos);
  root_guard(comm, [&] { replace_file(folder.file("history.csv"), "step,time (s),limiter\nnonsense\n"); });
  EXPECT_NE(
      sentence_of<RunError>([&] { History(comm, folder.path(), columns, 5); }).find("a row does not begin with a step"),
      std::string::npos);
  EXPECT_EQ(text_of("history.csv"), "step,time (s),limiter\nnonsense\n") << "left as it was";
}

TEST_F(HistoryFile, CannotOpenIsAnErrorEverywhere) {
  EXPECT_NE(sentence_of<RunError>([&] { History(comm, folder.file("nowhere"), columns, -1); }).find("nowhere"),
            std::string::npos);
}

TEST_F(HistoryFile, StatusIsJson) {
  RunProgress progress;
  progress.title = "Splash";
  progress.started = "noon";
  progress.n_ranks = 3;
  progress.elapsed = 7.5;
  progress.pressure = {12.5, 31, 1.0};
  progress.viscosity = {6.5, 9};
  progress.volume_error = 0.25;
  progress.longest_silence = 660.0;
  progress.phases = {{"p2g", 4, 1.0, 1.5, 2.0}};
  progress.warnings = {"one", "two"};
  write_status(comm, folder.path(), {RunState::failed, 12, 0.5, "checkpoint_000000010.h5", "a \"bad\"\nthing \\", progress});
  EXPECT_EQ(
      text_of("status.json"),
      "{\n  \"state\": \"failed\",\n  \"step\": 12,\n  \"time\": 0.5,\n  \"checkpoint\": \"checkpoint_000000010.h5\",\n"
      "  \"reason\": \"a \\\"bad\\\"\\nthing \\\\\",\n  \"title\": \"Splash\",\n  \"end_time\": 0.0,\n  \"ranks\": 3,\n"
      "  \"particles\": 0,\n  \"first_step\": 0,\n  \"first_time\": 0.0,\n  \"wall_time\": 7.5,\n"
      "  \"wall_time_stepping\": 0.0,\n  \"wall_time_output\": 0.0,\n  \"peak_memory\": 0,\n  \"checkpoint_time\": 0.0,\n"
      "  \"longest_silence\": 660.0,\n"
      "  \"pressure_iterations\": 12.5,\n  \"pressure_iterations_max\": 31,\n  \"contact_rounds\": 1.0,\n"
      "  \"viscosity_iterations\": 6.5,\n  \"viscosity_iterations_max\": 9,\n  \"volume_error\": 0.25,\n"
      "  \"continuation\": \"\",\n  \"host\": \"\",\n  \"started\": \"noon\",\n"
      "  \"program\": \"\",\n  \"phases\": [\n    {\n      \"name\": \"p2g\",\n      \"mean\": 1.5,\n      \"largest\": "
      "2.0\n    }\n  ],\n"
      "  \"warnings\": [\n    \"one\",\n    \"two\"\n  ]\n}\n");
  write_status(comm, folder.path(), {RunState::running, 0, std::nan(""), "", "", {}});
  EXPECT_NE(text_of("status.json").find("\"time\": null"), std::string::npos);
  EXPECT_FALSE(folder.has("status.json.tmp"));
}

TEST_F(HistoryFile, StatusTellsThatItIsOfASetUpOnlyWhereItIs) {
  Status status{RunState::failed, 0, 0.0, "", "no", {}};
  write_status(comm, folder.path(), status);
  EXPECT_EQ(text_of("status.json").find("failed_in_set_up"), std::string::npos);
  status.in_set_up = true;
  write_status(comm, folder.path(), status);
  EXPECT_NE(text_of("status.json").find("\"failed_in_set_up\": true"), std::string::npos);
}

// The first word about a part of a run stays, and one about an earlier part does not count.
TEST_F(HistoryFile, FirstWordAboutAFailureStays) {
  RunProgress progress;
  progress.started = "noon";
  write_status(comm, folder.path(), {RunState::failed, 12, 0.5, "", "the cause", progress});
  root_guard(comm, [&] {
    EXPECT_TRUE(says_failed(folder.path(), "noon"));
    EXPECT_FALSE(says_failed(folder.path(), "evening"));
    mark_unresponsive_alone(folder.path(), "what follows", "noon", 1);
  });
  EXPECT_NE(text_of("status.json").find("the cause"), std::string::npos);
  EXPECT_EQ(text_of("status.json").find("unresponsive"), std::string::npos);
  root_guard(comm, [&] {
    mark_unresponsive_alone(folder.path(), "another part", "evening", 1);
    EXPECT_TRUE(says_failed(folder.path(), "evening"));
    mark_unresponsive_alone(folder.path(), "what follows", "evening", 0);
  });
  EXPECT_NE(text_of("status.json").find("another part"), std::string::npos);
  EXPECT_NE(text_of("status.json").find("\"unresponsive\": true"), std::string::npos);
  progress.started = "night";
  write_status(comm, folder.path(), {RunState::running, 13, 0.5, "", "", progress});
  root_guard(comm, [&] { EXPECT_FALSE(says_failed(folder.path(), "night")); });
}

TEST_F(HistoryFile, MarkedAsFailedKeepsTheRest) {
  write_status(comm, folder.path(), {RunState::stopped, 12, 0.5, "checkpoint_000000010.h5", "", {}});
  root_guard(comm, [&] { EXPECT_TRUE(mark_failed_alone(folder.path(), "damaged", true)); });
  const std::string text = text_of("status.json");
  for (const char* part : {"\"state\": \"failed\"", "\"reason\": \"damaged\"", "\"step\": 12", "checkpoint_000000010.h5"})
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
  EXPECT_NE(text.find("\"unresponsive\": true"), std::string::npos) << text;
  root_guard(comm, [&] { EXPECT_TRUE(mark_failed_alone(folder.path(), "wrong", false)); });
  EXPECT_EQ(text_of("status.json").find("unresponsive"), std::string::npos);
  root_guard(comm, [&] { EXPECT_FALSE(mark_failed_alone(folder.file("nowhere"), "damaged", false)); });
}

TEST_F(HistoryFile, PeakMemoryGrows) {
  const std::size_t before = peak_resident_bytes();
  EXPECT_GT(before, std::size_t{1} << 20);
  std::vector<char> block(std::size_t{200} << 20);
  for (std::size_t i = 0; i < block.size(); i += 4096) block[i] = 1;
  EXPECT_GE(peak_resident_bytes(), before + (std::size_t{100} << 20)) << block[4096];
}

}  // namespace
}  // namespace bulkley::history_mpi_test
