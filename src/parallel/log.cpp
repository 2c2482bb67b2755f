#include "parallel/log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <map>
#include <sstream>

#include "bulkley/parallel/petsc.hpp"
#include "parallel/gather.hpp"

namespace bulkley {

namespace {

PetscLogEvent event_named(const std::string& name) {
  static PetscClassId class_id = 0;
  if (class_id == 0) BULKLEY_PETSC(PetscClassIdRegister("Bulkley", &class_id));
  PetscLogEvent event = -1;
  BULKLEY_PETSC(PetscLogEventGetId(name.c_str(), &event));
  if (event < 0) BULKLEY_PETSC(PetscLogEventRegister(name.c_str(), class_id, &event));
  return event;
}

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

double PhaseTimes::seconds(std::string_view name) const {
  for (const Entry& entry : entries)
    if (entry.name == name) return entry.seconds;
  return 0.0;
}

GlobalIndex PhaseTimes::n_calls(std::string_view name) const {
  for (const Entry& entry : entries)
    if (entry.name == name) return entry.n_calls;
  return 0;
}

Phase::Phase(PhaseTimes& times, std::string_view name) : times_(times), index_(0) {
  auto& entries = times.entries;
  while (index_ < entries.size() && entries[index_].name != name) ++index_;
  if (index_ == entries.size()) {
    entries.push_back({std::string(name)});
    entries.back().event = event_named(entries.back().name);
  }
  BULKLEY_PETSC(PetscLogEventBegin(entries[index_].event, 0, 0, 0, 0));
  start_ = MPI_Wtime();
}

Phase::~Phase() {
  PhaseTimes::Entry& entry = times_.entries[index_];
  entry.seconds += MPI_Wtime() - start_;
  ++entry.n_calls;
  BULKLEY_PETSC(PetscLogEventEnd(entry.event, 0, 0, 0, 0));
}

namespace {

// The phases that any rank ran, in the order of first use on the lowest rank that ran them, alike on every rank.
std::vector<std::string> names_on_any_rank(const Comm& comm, const PhaseTimes& times) {
  std::string mine;
  for (const PhaseTimes::Entry& entry : times.entries) mine += entry.name + '\n';
  std::istringstream all(broadcast_text(comm, gather_text(comm, mine)));
  std::vector<std::string> names;
  for (std::string name; std::getline(all, name);)
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  return names;
}

}  // namespace

std::vector<PhaseSummary> summarize(const Comm& comm, const PhaseTimes& times) {
  const std::vector<std::string> names = names_on_any_rank(comm, times);
  const int n = static_cast<int>(names.size());
  std::vector<double> mine(n), smallest(n), sum(n), largest(n);
  std::vector<PhaseSummary> result(n);
  for (int i = 0; i < n; ++i) mine[i] = times.seconds(names[i]);
  BULKLEY_MPI(MPI_Allreduce(mine.data(), smallest.data(), n, MPI_DOUBLE, MPI_MIN, comm.get()));
  BULKLEY_MPI(MPI_Allreduce(mine.data(), sum.data(), n, MPI_DOUBLE, MPI_SUM, comm.get()));
  BULKLEY_MPI(MPI_Allreduce(mine.data(), largest.data(), n, MPI_DOUBLE, MPI_MAX, comm.get()));
  for (int i = 0; i < n; ++i) result[i] = {names[i], times.n_calls(names[i]), smallest[i], sum[i] / comm.size(), largest[i]};
  return result;
}

}  // namespace bulkley
