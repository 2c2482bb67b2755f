#pragma once
// How a program adds a constitutive law to those of the library.
//
// A law of a program is a struct that keeps the contract of law.hpp, with the keys of its scene table next to it
// (plain_keys.hpp). It takes part everywhere - runs, restarts, the rheometer - once main has called add_law<Law>().
// docs/own-material.md is the guide, docs/examples/own_material the example.

#include <concepts>

#include "bulkley/material/added_law.hpp"
#include "bulkley/material/plain_keys.hpp"

namespace bulkley {

/// Everything that add_law asks of a law at compile time; the rest of the contract fails where it is used.
template <class Law>
concept AddableLaw = std::copyable<Law> && n_internal<Law> <= n_added_law_variables && requires(const Law& law) {
  { Law::law_name } -> std::convertible_to<const char*>;
  { Law::flows } -> std::convertible_to<bool>;
  { law.density() } -> std::same_as<double>;
  { law.viscosity() } -> std::same_as<double>;
  LawKeys<Law>::table();
};

/// The model of a law that keeps the contract of law.hpp.
template <AddableLaw Law>
class AddedLawModelOf final : public AddedLawModel {
 public:
  explicit AddedLawModelOf(Law law) : law_(std::move(law)) {}

  const char* name() const override { return Law::law_name; }
  bool flows() const override { return Law::flows; }
  double density() const override { return law_.density(); }
  double viscosity() const override { return law_.viscosity(); }
  std::array<double, n_added_law_variables> initial_internal() const override {
    std::array<double, n_added_law_variables> all{};
    if constexpr (n > 0) {
      const auto initial = law_.initial_internal();
      static_assert(initial.size() == n);
      for (std::size_t k = 0; k < initial.size(); ++k) all[k] = initial[k];
    }
    return all;
  }

  Update<double> update(State<double>& state, const Tensor<double>& velocity_gradient, double dt) const override {
    return update_own(state, velocity_gradient, dt);
  }
  Update<Pack> update(State<Pack>& state, const Tensor<Pack>& velocity_gradient, double dt) const override {
    return update_own(state, velocity_gradient, dt);
  }
  double wave_speed_squared(const State<double>& state) const override { return law_.wave_speed_squared(own(state)); }
  Pack wave_speed_squared(const State<Pack>& state) const override { return law_.wave_speed_squared(own(state)); }
  double energy_density(const State<double>& state) const override { return law_.energy_density(own(state)); }
  Pack energy_density(const State<Pack>& state) const override { return law_.energy_density(own(state)); }
  SymTensor<double> kirchhoff_stress(const State<double>& state) const override { return law_.kirchhoff_stress(own(state)); }
  SymTensor<Pack> kirchhoff_stress(const State<Pack>& state) const override { return law_.kirchhoff_stress(own(state)); }

  std::optional<CharacteristicStress> characteristic_stress([[maybe_unused]] double rate) const override {
    if constexpr (requires { law_.characteristic_stress(rate); })
      return law_.characteristic_stress(rate);
    else
      return std::nullopt;
  }

  std::optional<std::string> fault() const override { return law_fault(law_); }
  std::shared_ptr<const AddedLawModel> read(const config::Value& table, config::Faults& faults) const override {
    Law law = law_;
    if (!read_law(table, law, faults)) return nullptr;
    return std::make_shared<AddedLawModelOf>(std::move(law));
  }
  config::Value write() const override { return LawKeys<Law>::write(law_); }
  void describe(const std::string& title, const std::string& path, std::vector<config::TableText>& out) const override {
    LawKeys<Law>::table().describe(title, path, out);
  }

 private:
  static constexpr int n = n_internal<Law>;
  template <class Real>
  using OwnState = bulkley::State<Real, n>;

  template <class Real>
  static OwnState<Real> own(const State<Real>& state) {
    OwnState<Real> result;
    result.left_cauchy_green = state.left_cauchy_green;
    result.volume_ratio = state.volume_ratio;
    if constexpr (n > 0)
      for (int k = 0; k < n; ++k) result.internal[k] = state.internal[k];
    return result;
  }

  template <class Real>
  Update<Real> update_own(State<Real>& state, const Tensor<Real>& velocity_gradient, double dt) const {
    OwnState<Real> mine = own(state);
    const Update<Real> result = law_.update(mine, velocity_gradient, dt);
    state.left_cauchy_green = mine.left_cauchy_green;
    state.volume_ratio = mine.volume_ratio;
    if constexpr (n > 0)
      for (int k = 0; k < n; ++k) state.internal[k] = mine.internal[k];
    return result;
  }

  Law law_;
};

/// Lets scenes name a law; see add_law. Not collective.
void add_law_model(std::shared_ptr<const AddedLawModel> model);

/// Lets scenes name the law `Law::law_name`. To be called on every rank before a scene is parsed, first thing in main; not from
/// several threads. Throws UsageError if a law of that name exists. Not collective.
template <AddableLaw Law>
void add_law() {
  add_law_model(std::make_shared<AddedLawModelOf<Law>>(Law{}));
}

}  // namespace bulkley
