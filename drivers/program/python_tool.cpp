#include "program/python_tool.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

constexpr int module_missing = 4;  // exit code of the package's tools
constexpr int not_started = 127;

// Beside an installed program, else where its build was told; by default in the source tree.
std::string package_path() {
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe");
  const std::filesystem::path installed = program.parent_path().parent_path() / "share" / "bulkley" / "python" / "bulkley";
  for (const std::filesystem::path& path : {installed, std::filesystem::path(BULKLEY_DRIVERS_FOLDER) / "python" / "bulkley"})
    if (std::filesystem::exists(path / "__main__.py")) return path.string();
  return {};
}

std::vector<std::string> interpreters() {
  if (const char* wanted = std::getenv("BULKLEY_PYTHON")) return {wanted};
  return {"python3", "/usr/bin/python3"};
}

// A file in memory, without a name: it is gone with this object, however the program ends.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& product) : file_(::memfd_create("bulkley", MFD_CLOEXEC)) {
    if (file_ < 0) throw RunError(fmt::format("no {}: {}", product, std::strerror(errno)));
  }
  ~MemoryFile() { ::close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return file_; }
  void rewind() { ::lseek(file_, 0, SEEK_SET); }
  // False if there is no room for it.
  bool write(const std::string& text) {
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t n = ::write(file_, text.data() + done, text.size() - done);
      if (n < 0 && errno != EINTR) return false;
      if (n > 0) done += static_cast<std::size_t>(n);
    }
    return true;
  }
  std::string text() {
    rewind();
    std::string all;
    char buffer[1 << 16];
    for (ssize_t n; (n = ::read(file_, buffer, sizeof buffer)) > 0;) all.append(buffer, static_cast<std::size_t>(n));
    return all;
  }

 private:
  int file_;
};

// Exit code of a program found on the PATH; not_started if it could not be started.
int run_child(std::vector<std::string> words, const MemoryFile& input, const MemoryFile& output) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, input.descriptor(), STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, output.descriptor(), STDOUT_FILENO);
  pid_t child = 0;
  const int failure = ::posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), ::environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) return not_started;
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return not_started;
  return WIFEXITED(status) ? WEXITSTATUS(status) : not_started;
}

}  // namespace

std::string run_python_tool(const std::vector<std::string>& words, const std::string& input, const std::string& product) {
  const std::string package = package_path();
  if (package.empty())
    throw RunError(
        fmt::format("no {}: the Python package is neither beside the program nor where it was built from", product));
  MemoryFile given(product);
  if (!given.write(input)) throw RunError(fmt::format("no {}: {}", product, std::strerror(errno)));
  int code = not_started;
  for (const std::string& python : interpreters()) {
    MemoryFile made(product);
    given.rewind();
    std::vector<std::string> command{python, package};
    command.insert(command.end(), words.begin(), words.end());
    code = run_child(std::move(command), given, made);
    if (code == 0) return made.text();
    if (code != module_missing && code != not_started) break;
  }
  if (code == module_missing || code == not_started)
    throw RunError(fmt::format(
        "no {}: no python3 with matplotlib was found; install it (Debian: python3-matplotlib) or name one in BULKLEY_PYTHON",
        product));
  throw RunError(fmt::format("no {}: `{}` of the Python package ended with exit code {}", product, words.front(), code));
}

}  // namespace bulkley
