#include "bench/child.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <sstream>
#include <thread>

#include "bulkley/base/error.hpp"
#include "io/files/text_file.hpp"

namespace bulkley {

namespace {

std::vector<std::string> environment;

bool is_set(const std::string& name) {
  for (const std::string& entry : environment)
    if (entry.rfind(name + "=", 0) == 0) return true;
  return false;
}

// The full path of a program on the PATH; empty when there is none.
std::string found_on_path(const std::string& name) {
  for (const std::string& entry : environment) {
    if (entry.rfind("PATH=", 0) != 0) continue;
    std::istringstream folders(entry.substr(5));
    for (std::string folder; std::getline(folders, folder, ':');) {
      std::string path = path_in(folder, name);
      if (::access(path.c_str(), X_OK) == 0) return path;
    }
  }
  return {};
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

// Waits for a child and returns the error, if any. One that takes too long is terminated, then killed.
std::string wait_for(pid_t child, double time_limit) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const double grace = 10.0;  // s
  bool asked = false;
  for (int status = 0;;) {
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended < 0) return "it could not be waited for";
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    if (ended == child) {
      if (asked) return fmt::format("it did not end within {:.0f} s", time_limit);
      if (WIFSIGNALED(status)) return fmt::format("it was ended by signal {}", WTERMSIG(status));
      return WEXITSTATUS(status) == 0 ? std::string() : fmt::format("it ended with exit code {}", WEXITSTATUS(status));
    }
    if (!asked && seconds > time_limit) {
      ::kill(child, SIGTERM);
      asked = true;
    }
    if (seconds > time_limit + grace) ::kill(child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

}  // namespace

void remember_environment() {
  environment.clear();
  for (char** entry = ::environ; *entry != nullptr; ++entry) environment.emplace_back(*entry);
}

std::string child_obstacle(int n_ranks) {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"})
    if (is_set(name)) return "the suite itself was started by mpirun or srun";
  if (n_ranks > 1 && found_on_path("mpirun").empty()) return "there is no mpirun on the PATH";
  return {};
}

ChildOutcome run_child_bench(int n_ranks, const std::vector<std::string>& arguments, double time_limit) {
  if (std::string skip_reason = child_obstacle(n_ranks); !skip_reason.empty()) return {std::move(skip_reason), {}};
  std::string name = (std::filesystem::temp_directory_path() / "bulkley_bench_XXXXXX").string();
  const int descriptor = ::mkstemp(name.data());
  if (descriptor < 0) return {fmt::format("no file can be made in {}", std::filesystem::temp_directory_path().string()), {}};
  ::close(descriptor);

  std::vector<std::string> words;
  if (n_ranks > 1) words = {found_on_path("mpirun"), "-n", std::to_string(n_ranks)};
  for (const std::string& word : {std::filesystem::read_symlink("/proc/self/exe").string(), std::string("bench")})
    words.push_back(word);
  words.insert(words.end(), arguments.begin(), arguments.end());
  words.insert(words.end(), {"--json", name});

  // What the child prints is in its file as well.
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int failure =
      ::posix_spawn(&child, words.front().c_str(), &actions, nullptr, pointers(words).data(), pointers(environment).data());
  ::posix_spawn_file_actions_destroy(&actions);

  ChildOutcome outcome;
  outcome.fault = failure != 0 ? fmt::format("{} could not be started", words.front()) : wait_for(child, time_limit);
  if (outcome.fault.empty()) outcome.json = Json::parse(read_text(name), nullptr, false);
  if (outcome.json.is_discarded()) outcome.fault = "it wrote no JSON";
  std::filesystem::remove(name);
  return outcome;
}

}  // namespace bulkley
