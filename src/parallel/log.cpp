#include "parallel/log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <map>
#include <sstream>

#include "parallel/gather.hpp"

namespace bulkley {

namespace {

// The texts of all ranks on the root, each ended by a zero byte; empty elsewhere. `text` may hold zero bytes itself.
std::string gather_text(const Comm& comm, const std::string& text) {
  const std::vector<char> all = gather_values(comm, std::vector<char>(text.begin(), text.end()));
  return {all.begin(), all.end()};
}

}  // namespace

void log_line(const Comm& comm, std::string_view text) {
  if (!comm.is_root()) return;
  fmt::print("{}\n", text);
  std::fflush(stdout);
}

void Warnings::add(std::string text) {
  const auto same = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.text == text; });
  if (same != entries_.end())
    ++same->count;
  else
    entries_.push_back({std::move(text), 1});
}

void Warnings::print(const Comm& comm) {
  std::string packed;  // count, zero byte, text, zero byte, …
  for (const Entry& entry : entries_) {
    packed += std::to_string(entry.count) + '\0';
    packed += entry.text + '\0';
  }
  entries_.clear();
  const std::string all = gather_text(comm, packed);

  struct Merged {
    GlobalIndex count = 0;
    int n_ranks = 0;
  };
  std::map<std::string, Merged> merged;
  for (const char* at = all.data(); at < all.data() + all.size();) {
    const GlobalIndex count = std::stoll(at);
    at += std::strlen(at) + 1;
    Merged& entry = merged[at];
    entry.count += count;
    ++entry.n_ranks;
    at += std::strlen(at) + 1;
  }
  for (const auto& [text, entry] : merged) {
    if (entry.count == 1)
      fmt::print(stderr, "warning: {}\n", text);
    else
      fmt::print(stderr, "warning: {} ({} times on {} rank{})\n", text, entry.count, entry.n_ranks,
                 entry.n_ranks == 1 ? "" : "s");
  }
}

}  // namespace bulkley
