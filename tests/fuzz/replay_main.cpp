// main() of a fuzzer where there is no libFuzzer: replays a corpus, then mutates it at random, always in the same way, for a
// while. What crashes, hangs or lets an exception escape is left in the file `FUZZER.failure` of the current folder.
//
//   fuzz_NAME CORPUS... [--seconds S] [--seed N]

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv);

namespace {

constexpr unsigned longest_case = 10;                      // s
constexpr std::size_t most_memory = std::size_t{1} << 30;  // bytes
constexpr std::size_t longest_input = 1 << 16;             // bytes

std::string current, failure_file;

// Only calls that a signal handler may make.
extern "C" void keep_input(int signal) {
  const int file = ::open(failure_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (file >= 0 && ::write(file, current.data(), current.size()) < 0) ::_exit(1);
  const char* sentence = signal == SIGALRM ? "a case hangs; its input is in the file FUZZER.failure\n"
                                           : "a case crashes; its input is in the file FUZZER.failure\n";
  for (const char* c = sentence; *c; ++c)
    if (::write(STDERR_FILENO, c, 1) < 0) break;
  ::signal(signal == SIGALRM ? SIGKILL : signal, SIG_DFL);
  ::raise(signal == SIGALRM ? SIGKILL : signal);
}

void run(const std::string& input) {
  current = input;
  ::alarm(longest_case);
  // A copy of exactly this size, so that a sanitizer sees what reads past it.
  const std::vector<std::uint8_t> bytes(input.begin(), input.end());
  LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  ::alarm(0);
}

std::vector<std::string> read_corpus(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths)
    if (std::filesystem::is_directory(path))
      for (const auto& entry : std::filesystem::recursive_directory_iterator(path)) {
        if (entry.is_regular_file()) files.push_back(entry.path().string());
      }
    else
      files.push_back(path);
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  for (const std::string& file : files) {
    std::ifstream stream(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return corpus;
}

/// Mutates inputs; the numbers that it draws are the same everywhere, unlike those of the distributions of <random>.
class Mutator {
 public:
  Mutator(std::vector<std::string> corpus, std::uint64_t seed) : corpus_(std::move(corpus)), random_(seed) {}

  std::string next() {
    std::string input = any(corpus_);
    for (std::size_t n = 1 + below(4); n > 0; --n) change(input);
    input.resize(std::min(input.size(), longest_input));
    return input;
  }

 private:
  std::size_t below(std::size_t n) { return n > 0 ? static_cast<std::size_t>(random_() % n) : 0; }
  const std::string& any(const std::vector<std::string>& list) { return list[below(list.size())]; }

  void change(std::string& s) {
    const std::size_t at = below(s.size() + 1), length = std::min(s.size() - at, 1 + below(16));
    switch (below(8)) {
      case 0:
        if (at < s.size()) s[at] = static_cast<char>(s[at] ^ (1 << below(8)));
        break;
      case 1:
        if (at < s.size()) s[at] = static_cast<char>(below(256));
        break;
      case 2:
        s.erase(at, length);
        break;
      case 3:
        s.insert(at, s.substr(at, length));
        break;
      case 4:
        s.insert(at, any(tokens_));
        break;
      case 5:
        replace_number(s, at);
        break;
      case 6: {  // goes on with a piece of another input
        const std::string& other = any(corpus_);
        const std::size_t from = below(other.size() + 1);
        s.replace(at, length, other.substr(from, 1 + below(200)));
        break;
      }
      default:
        if (below(8) == 0)
          s.resize(at);
        else if (at + 4 <= s.size())
          for (std::size_t k = 0; k < 4; ++k) s[at + k] = static_cast<char>(below(2) == 0 ? 0xff : 0);
    }
  }

  void replace_number(std::string& s, std::size_t at) {
    const std::size_t first = s.find_first_of("0123456789", at);
    if (first == std::string::npos) return;
    const std::size_t last = s.find_first_not_of("0123456789.e", first);
    s.replace(first, (last == std::string::npos ? s.size() : last) - first, any(tokens_));
  }

  std::vector<std::string> corpus_;
  std::mt19937_64 random_;
  const std::vector<std::string> tokens_{"0",          "-1",
                                         "1e99",       "1e308",
                                         "-1e-99",     "nan",
                                         "inf",        "9223372036854775807",
                                         "2147483648", "99999999999999999999",
                                         "\"",         "'",
                                         "\n",         "[",
                                         "]",          "{",
                                         "}",          "= ",
                                         ",",          ".",
                                         "true",       "[[a]]",
                                         "\xff",       "(x",
                                         "x ? 1 : y",  "r = ",
                                         "#",          "1979-05-27",
                                         "\"\"\"",     "4"};
};

struct Arguments {
  std::vector<std::string> corpus;
  double seconds = 10.0;
  std::uint64_t seed = 1;
};

Arguments arguments_of(int argc, char** argv) {
  Arguments a;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    if (word == "--seconds" && k + 1 < argc)
      a.seconds = std::strtod(argv[++k], nullptr);
    else if (word == "--seed" && k + 1 < argc)
      a.seed = std::strtoull(argv[++k], nullptr, 10);
    else
      a.corpus.push_back(word);
  }
  return a;
}

}  // namespace

int main(int argc, char** argv) {
  LLVMFuzzerInitialize(&argc, &argv);
  const Arguments arguments = arguments_of(argc, argv);
  failure_file = std::filesystem::path(argv[0]).filename().string() + ".failure";
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGALRM}) std::signal(signal, keep_input);

  const std::vector<std::string> corpus = read_corpus(arguments.corpus);
  if (corpus.empty()) {
    std::fprintf(stderr, "%s: no corpus; usage: CORPUS... [--seconds S] [--seed N]\n", argv[0]);
    return 2;
  }
  for (const std::string& input : corpus) run(input);

  Mutator mutator(corpus, arguments.seed);
  std::uint64_t n_cases = 0;
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - start < std::chrono::duration<double>(arguments.seconds)) {
    run(mutator.next());
    ++n_cases;
  }
  struct rusage usage = {};
  ::getrusage(RUSAGE_SELF, &usage);
  const std::size_t peak = static_cast<std::size_t>(usage.ru_maxrss) << 10;
  std::printf("%zu inputs replayed, %llu mutated ones tried, at most %zu MiB of memory\n", corpus.size(),
              static_cast<unsigned long long>(n_cases), peak >> 20);
  std::fflush(stdout);
  ::_exit(peak > most_memory ? 1 : 0);  // MPI, where there is one, is not shut down
}
