#include "program/rheometer_plot.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "bulkley/base/error.hpp"
#include "io/files/text_file.hpp"

namespace bulkley {

namespace {

constexpr const char* script_name = "plot_rheometer.py";
constexpr int no_matplotlib = 4;  // exit code of the script

// Beside an installed program, else where the program was built from.
std::string script_path() {
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe");
  const std::filesystem::path installed = program.parent_path().parent_path() / "share" / "bulkley" / script_name;
  for (const std::filesystem::path& path : {installed, std::filesystem::path(BULKLEY_DRIVERS_FOLDER) / script_name})
    if (std::filesystem::exists(path)) return path.string();
  throw RunError(fmt::format("no picture: {} is neither installed with the program nor in its source folder", script_name));
}

std::vector<std::string> interpreters() {
  if (const char* wanted = std::getenv("BULKLEY_PYTHON")) return {wanted};
  return {"python3", "/usr/bin/python3"};
}

// Exit code of a program found on the PATH; nothing of it is kept. 127: it could not be started.
int run_child(const std::vector<std::string>& words) {
  constexpr int not_started = 127;
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t child = 0;
  if (::posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), ::environ) != 0) return not_started;
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return not_started;
  return WIFEXITED(status) ? WEXITSTATUS(status) : not_started;
}

}  // namespace

void draw(const PlotRequest& request) {
  const std::string table = request.file + ".part.csv";
  write_text_atomically(table, request.csv);
  int code = no_matplotlib;
  for (const std::string& python : interpreters()) {
    code = run_child({python, script_path(), "--kind", request.kind, "--title", request.title, table, request.file});
    if (code == 0 || (code != no_matplotlib && code != 127)) break;
  }
  remove_file(table);
  if (code == no_matplotlib || code == 127)
    throw RunError(fmt::format(
        "no picture {}: no python3 with matplotlib was found; install it (Debian: python3-matplotlib) or name one in "
        "BULKLEY_PYTHON",
        request.file));
  if (code != 0) throw RunError(fmt::format("no picture {}: {} ended with exit code {}", request.file, script_name, code));
}

}  // namespace bulkley
