#include "simulation/simulation_state.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

constexpr double same_time = 1e-12;  // over the time: rounding of a multiple of the interval

// One list of names serves both directions: `visit(name, number)` for every member, double or integer.
template <class State, class Visit>
void for_each_number(State& state, Visit visit) {
  visit("next_frame", state.next_frame);
  visit("n_removed", state.n_removed);
  visit("last_step", state.dt_last);

  auto& c = state.controller;
  visit("controller.stable_step", c.dt_stable);
  visit("controller.first_limit", c.dt_first_limit);
  visit("controller.wait", c.wait);
  visit("controller.since_trial", c.since_trial);
  visit("controller.n_steps", c.n_steps);
  visit("controller.n_trials", c.n_trials);
  visit("controller.n_accepted", c.n_accepted);
  visit("controller.n_rejected", c.n_rejected);
  visit("controller.n_unchecked_large", c.n_unchecked_large);

  // Bounds of the groups that the next step reads, each as "bounds.NAME", and "bounds.NAME_id" for the particle.
  const auto visit_bound = [&](const std::string& name, auto& member) {
    visit(("bounds." + name).c_str(), member.value);
    if constexpr (requires { member.id; }) visit(("bounds." + name + "_id").c_str(), member.id);
  };
  MotionBounds::each(visit_bound, state.bounds.motion);
  SumTerms::each(visit_bound, state.bounds.sums);
  ParticleTotals::each(visit_bound, state.bounds.totals);
}

// What older checkpoints may lack; it keeps its default then.
template <class State, class Visit>
void for_each_late_number(State& state, Visit visit) {
  visit("frame_tick", state.frame_tick);
  visit("balance.n_repartitions", state.n_repartitions);
  visit("balance.n_moved", state.n_moved);
  visit("balance.n_migrated", state.n_migrated);
  visit("pressure.n_steps", state.pressure.n_steps);
  visit("pressure.n_iterations", state.pressure.n_iterations);
  visit("pressure.most_iterations", state.pressure.most_iterations);
  visit("pressure.n_rounds", state.pressure.n_rounds);
  visit("viscosity.n_steps", state.viscosity.n_steps);
  visit("viscosity.n_iterations", state.viscosity.n_iterations);
  visit("viscosity.most_iterations", state.viscosity.most_iterations);
}

constexpr const char* history_time_name = "history.time";
std::string contact_word_name(std::size_t word) { return fmt::format("contact.word_{}", word); }

// Most words of the energy budget are zero, and only the others are written.
constexpr const char* n_energy_words_name = "energy.n_words";
std::string energy_word_name(std::size_t word) { return fmt::format("energy.word_{}", word); }
template <class State, class Visit>
void for_each_energy_start(State& state, Visit visit) {
  visit("energy.start_kinetic", state.energy_start.kinetic);
  visit("energy.start_elastic", state.energy_start.elastic);
  visit("energy.start_dissipated", state.energy_start.dissipated);
}

constexpr const char* force_prefix = "force.";  // as save_forces names them

template <class Number>
void copy_prefixed(const std::map<std::string, Number>& from, std::map<std::string, Number>& to) {
  for (auto entry = from.lower_bound(force_prefix); entry != from.end() && entry->first.starts_with(force_prefix); ++entry)
    to.insert(*entry);
}

constexpr const char* node_cost_name = "cost.node";
std::string particle_cost_name(std::size_t material) { return fmt::format("cost.particle_{}", material); }

template <class Number>
Number find_number(const std::map<std::string, Number>& numbers, const std::string& name) {
  const auto found = numbers.find(name);
  if (found == numbers.end()) throw RunError(fmt::format("the checkpoint does not hold '{}'", name));
  return found->second;
}

}  // namespace

void PressureTotals::add(const PressureReport& report) {
  ++n_steps;
  n_iterations += report.n_iterations;
  most_iterations = std::max(most_iterations, GlobalIndex{report.n_iterations});
  n_rounds += report.n_rounds;
}

void ViscosityTotals::add(const ViscosityReport& report) {
  ++n_steps;
  n_iterations += report.n_iterations;
  most_iterations = std::max(most_iterations, GlobalIndex{report.n_iterations});
}

void save_state(const SimulationState& state, Reals& reals, Integers& integers) {
  const auto save = [&]<class Number>(const char* name, const Number& number) {
    if constexpr (std::is_same_v<Number, double>)
      reals[name] = number;
    else
      integers[name] = number;
  };
  for_each_number(state, save);
  for_each_late_number(state, save);
  reals[history_time_name] = state.history_time;
  for (std::size_t w = 0; w < state.contact_impulses.size(); ++w) integers[contact_word_name(w)] = state.contact_impulses[w];
  for_each_energy_start(state, save);
  integers[n_energy_words_name] = static_cast<GlobalIndex>(state.energy_words.size());
  for (std::size_t w = 0; w < state.energy_words.size(); ++w)
    if (state.energy_words[w] != 0) integers[energy_word_name(w)] = state.energy_words[w];
  reals.insert(state.force_reals.begin(), state.force_reals.end());
  integers.insert(state.force_integers.begin(), state.force_integers.end());
  reals[node_cost_name] = state.cost.node;
  for (std::size_t m = 0; m < state.cost.particle.size(); ++m) reals[particle_cost_name(m)] = state.cost.particle[m];
}

CostModel load_cost(const Reals& reals) {
  CostModel cost;
  if (const auto node = reals.find(node_cost_name); node != reals.end()) cost.node = node->second;
  for (auto found = reals.find(particle_cost_name(0)); found != reals.end();
       found = reals.find(particle_cost_name(cost.particle.size())))
    cost.particle.push_back(found->second);
  return cost;
}

SimulationState load_state(GlobalIndex step, double time, const Reals& reals, const Integers& integers) {
  SimulationState state;
  state.step = step;
  state.time = time;
  for_each_number(state, [&]<class Number>(const char* name, Number& number) {
    if constexpr (std::is_same_v<Number, double>)
      number = find_number(reals, name);
    else
      number = find_number(integers, name);
  });
  state.frame_tick = state.next_frame;
  for_each_late_number(state, [&](const char* name, GlobalIndex& number) {
    if (const auto found = integers.find(name); found != integers.end()) number = found->second;
  });
  const auto row_before = reals.find(history_time_name);
  state.history_time = row_before != reals.end() ? row_before->second : time;
  for (auto word = integers.find(contact_word_name(0)); word != integers.end();
       word = integers.find(contact_word_name(state.contact_impulses.size())))
    state.contact_impulses.push_back(word->second);
  if (const auto n = integers.find(n_energy_words_name); n != integers.end()) {
    for_each_energy_start(state, [&](const char* name, double& number) { number = find_number(reals, name); });
    for (std::size_t w = 0; w < static_cast<std::size_t>(n->second); ++w) {
      const auto word = integers.find(energy_word_name(w));
      state.energy_words.push_back(word != integers.end() ? word->second : 0);
    }
  }
  copy_prefixed(reals, state.force_reals);
  copy_prefixed(integers, state.force_integers);
  state.cost = load_cost(reals);
  return state;
}

double next_frame_time(const SimulationState& state, double frame_interval, double end_time) {
  const double time = static_cast<double>(state.frame_tick) * frame_interval;
  return std::abs(time - end_time) <= same_time * end_time ? end_time : time;
}

void fit_frame_tick(SimulationState& state, double frame_interval) {
  if (frame_interval <= 0.0) return;
  GlobalIndex& tick = state.frame_tick;
  const auto is_past = [&](GlobalIndex n) {
    return static_cast<double>(n) * frame_interval <= state.time * (1.0 + same_time);
  };
  if (!is_past(tick) && is_past(tick - 1)) return;
  constexpr double most = 1e15;  // still whole numbers
  tick = static_cast<GlobalIndex>(std::min(most, std::floor(state.time / frame_interval)));
  while (is_past(tick) && static_cast<double>(tick) < most) ++tick;
}

}  // namespace bulkley
