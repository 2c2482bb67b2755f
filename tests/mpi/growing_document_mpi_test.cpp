// ranks: 1
#include "io/files/growing_document.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "io/files/text_file.hpp"
#include "support/io_particles.hpp"

namespace bulkley::growing_document_mpi_test {
namespace {

class Growing : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  SharedFolder folder{comm};
  const std::string path = folder.file("list.txt");
  const std::string opening = "<list>\n", closing = "</list>\n";

  static std::string part(int number) {
    return fmt::format("<part>{}{}</part>\n", number, std::string(static_cast<std::size_t>(40 + number % 7), '.'));
  }
  std::string document(int n_parts) const {
    std::string text = opening;
    for (int number = 0; number < n_parts; ++number) text += part(number);
    return text + closing;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) found.push_back(entry.path().filename());
    std::sort(found.begin(), found.end());
    return found;
  }
};

GlobalIndex bytes_written_so_far() {
  const std::string text = whole_file("/proc/self/io");
  return std::stol(text.substr(text.find("wchar: ") + 7));
}

TEST_F(Growing, HasAllPartsInOrderAfterEach) {
  {
    GrowingDocument growing(path, opening, closing);
    growing.begin({});
    EXPECT_TRUE(names().empty());
    for (int n = 1; n <= 30; ++n) {
      growing.add(part(n - 1));
      ASSERT_EQ(whole_file(path), document(n));
    }
  }
  EXPECT_EQ(names(), std::vector<std::string>{"list.txt"});
}

TEST_F(Growing, BeginsAnew) {
  GrowingDocument growing(path, opening, closing);
  growing.begin({});
  for (int n = 0; n < 5; ++n) growing.add(part(n));
  growing.begin(std::vector{part(0), part(1)});
  EXPECT_EQ(whole_file(path), document(2));
  growing.add(part(2));
  growing.add(part(3));
  EXPECT_EQ(whole_file(path), document(4));
  growing.begin({});
  EXPECT_TRUE(names().empty());
}

TEST_F(Growing, APartCostsTheSameHoweverManyThereAre) {
  GrowingDocument growing(path, opening, closing);
  std::vector<std::string> parts;
  for (int n = 0; n < 5000; ++n) parts.push_back(part(n));
  growing.begin(parts);
  growing.add(part(5000));  // copies the document once
  GlobalIndex before = bytes_written_so_far();
  for (int n = 5001; n <= 5010; ++n) {
    growing.add(part(n));
    const GlobalIndex now = bytes_written_so_far();
    EXPECT_EQ(now - before, static_cast<GlobalIndex>((part(n - 1) + part(n) + closing).size()));
    before = now;
  }
}

// A process that may write no byte beyond a limit of the file is killed exactly there.
TEST_F(Growing, IsWholeWhereverTheProcessIsKilled) {
  const auto whole = static_cast<rlim_t>(document(4).size()), shared = static_cast<rlim_t>(document(2).size());
  int n_killed = 0;
  for (rlim_t limit = shared; limit <= whole; limit += 4) {
    {
      GrowingDocument growing(path, opening, closing);
      growing.begin(std::vector{part(0)});
    }
    const pid_t child = ::fork();
    if (child == 0) {
      std::signal(SIGXFSZ, SIG_DFL);
      const struct rlimit no_core = {0, 0};
      ::setrlimit(RLIMIT_CORE, &no_core);
      GrowingDocument growing(path, opening, closing);
      growing.begin(std::vector{part(0), part(1)});
      growing.add(part(2));
      const struct rlimit size = {limit, limit};
      ::setrlimit(RLIMIT_FSIZE, &size);
      try {
        growing.add(part(3));
      } catch (const RunError&) {  // where not a byte more fits, the write is refused at first
        ::_exit(1);
      }
      ::_exit(0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    n_killed += WIFSIGNALED(status);
    ASSERT_EQ(whole_file(path), document(WIFEXITED(status) && WEXITSTATUS(status) == 0 ? 4 : 3)) << limit << " bytes";

    GrowingDocument again(path, opening, closing);
    again.begin(std::vector{part(0), part(1)});
    EXPECT_EQ(names(), std::vector<std::string>{"list.txt"});
  }
  EXPECT_GT(n_killed, static_cast<int>(whole - shared) / 8);
}

TEST_F(Growing, ARefusedPartLeavesItWhole) {
  GrowingDocument growing(path, opening, closing);
  growing.begin(std::vector{part(0)});
  growing.add(part(1));
  struct rlimit before = {};
  getrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_IGN);
  struct rlimit less = before;
  less.rlim_cur = static_cast<rlim_t>(document(3).size()) - 3;
  setrlimit(RLIMIT_FSIZE, &less);
  const std::string sentence = sentence_of<RunError>([&] { growing.add(part(2)); });
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(sentence, fmt::format("cannot write '{}.next': File too large", path));
  EXPECT_EQ(whole_file(path), document(2));
  growing.add(part(2));
  growing.add(part(3));
  EXPECT_EQ(whole_file(path), document(4));
}

}  // namespace
}  // namespace bulkley::growing_document_mpi_test
