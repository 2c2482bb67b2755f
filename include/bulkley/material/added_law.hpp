#pragma once
// The place in the family Material of the laws that a program adds to it (add_law.hpp).

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bulkley/material/law.hpp"

namespace bulkley {

namespace config {
class Faults;
struct TableText;
struct Value;
}  // namespace config

/// What AddedLaw needs to know of the law behind it: the contract of law.hpp for `double` and `Pack`, and its keys. The
/// variables that a law keeps in addition to b and J come first in State::internal; the rest stays 0.
class AddedLawModel {
 public:
  template <class Real>
  using State = bulkley::State<Real, n_added_law_variables>;

  virtual ~AddedLawModel() = default;

  virtual const char* name() const = 0;
  virtual bool flows() const = 0;
  virtual double density() const = 0;    ///< kg/m^3
  virtual double viscosity() const = 0;  ///< Pa s
  virtual std::array<double, n_added_law_variables> initial_internal() const = 0;

  virtual Update<double> update(State<double>& state, const Tensor<double>& velocity_gradient, double dt) const = 0;
  virtual Update<Pack> update(State<Pack>& state, const Tensor<Pack>& velocity_gradient, double dt) const = 0;
  virtual double wave_speed_squared(const State<double>& state) const = 0;  ///< m^2/s^2
  virtual Pack wave_speed_squared(const State<Pack>& state) const = 0;
  virtual double energy_density(const State<double>& state) const = 0;  ///< J/m^3
  virtual Pack energy_density(const State<Pack>& state) const = 0;
  virtual SymTensor<double> kirchhoff_stress(const State<double>& state) const = 0;  ///< Pa
  virtual SymTensor<Pack> kirchhoff_stress(const State<Pack>& state) const = 0;

  /// Pa at a shear rate (1/s), if the law says it.
  virtual std::optional<CharacteristicStress> characteristic_stress(double rate) const = 0;

  /// What is wrong with the parameters, as one sentence.
  virtual std::optional<std::string> fault() const = 0;
  /// The law with the parameters of a scene's table; null after a fault.
  virtual std::shared_ptr<const AddedLawModel> read(const config::Value& table, config::Faults& faults) const = 0;
  /// The table that gives the law again, without its name.
  virtual config::Value write() const = 0;
  /// Its section of the input reference.
  virtual void describe(const std::string& title, const std::string& path, std::vector<config::TableText>& out) const = 0;
};

/// A law of the family Material that hands everything to a law that the program added: one virtual call a pack of particles.
struct AddedLaw {
  struct Parameters {
    std::shared_ptr<const AddedLawModel> model;
  };
  Parameters parameters;

  static constexpr const char* law_name = "added";  ///< that of the law behind it: bulkley::law_name
  static constexpr bool flows = true;               ///< reports what the law behind it reports; bulkley::flows
  static constexpr std::array internal{Field::added_law_variables};

  double density() const { return parameters.model->density(); }
  double viscosity() const { return parameters.model->viscosity(); }
  std::array<double, n_added_law_variables> initial_internal() const { return parameters.model->initial_internal(); }
  std::optional<CharacteristicStress> characteristic_stress(double rate) const {
    return parameters.model->characteristic_stress(rate);
  }

  template <class Real>
  Update<Real> update(AddedLawModel::State<Real>& state, const Tensor<Real>& velocity_gradient, double dt) const {
    return parameters.model->update(state, velocity_gradient, dt);
  }
  template <class Real>
  Real wave_speed_squared(const AddedLawModel::State<Real>& state) const {
    return parameters.model->wave_speed_squared(state);
  }
  template <class Real>
  Real energy_density(const AddedLawModel::State<Real>& state) const {
    return parameters.model->energy_density(state);
  }
  template <class Real>
  SymTensor<Real> kirchhoff_stress(const AddedLawModel::State<Real>& state) const {
    return parameters.model->kirchhoff_stress(state);
  }
};

}  // namespace bulkley
