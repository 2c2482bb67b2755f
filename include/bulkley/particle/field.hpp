#pragma once
// The table of all per-particle quantities. A new one is a row here: storage, sorting, migration, checkpoints and frames
// iterate the table.

#include <array>
#include <cstddef>

namespace bulkley {

/// Every per-particle quantity. The order is that of `field_table`.
enum class Field : int {
  position,
  velocity,
  affine_velocity,
  left_cauchy_green,
  volume_ratio,
  kirchhoff_stress,
  plastic_shear_rate,
  plastic_dissipation,
  reference_volume,
  velocity_gradient,
  structure,
  hardening,
  plastic_volume_ratio,
  viscous_left_cauchy_green,
  added_law_variables,
  cell_mean_stress,
  layer_pressure,
  viscous_stress,
  magnetic_field_strength,
  magnetic_force,
  magnetic_field,
  magnetisation,
  material,
  id,
};

enum class FieldType { real, uint8, int64 };

/// What the rest of the program needs to know of a field; packing, sorting, output and checkpoints iterate the table.
struct FieldInfo {
  Field field;
  const char* name;
  const char* unit;
  const char* meaning;
  FieldType type;
  int n_components;
  bool moves;             ///< travels with the particle in memory and between ranks (else: ParticleSet::hold_block)
  bool written;           ///< part of the checkpoint: needed for a bit-identical restart
  bool optional = false;  ///< held only where the scene needs it
};

inline constexpr std::array field_table = {
    FieldInfo{Field::position, "position", "m", "x_p", FieldType::real, 3, true, true},
    FieldInfo{Field::velocity, "velocity", "m/s", "v_p", FieldType::real, 3, true, true},
    FieldInfo{Field::affine_velocity, "affine_velocity", "1/s", "APIC matrix C_p = B_p D_p^-1, row-major", FieldType::real,
              9, true, true},
    FieldInfo{Field::left_cauchy_green, "left_cauchy_green", "1",
              "isochoric elastic left Cauchy-Green tensor, xx yy zz xy yz xz", FieldType::real, 6, true, true},
    FieldInfo{Field::volume_ratio, "volume_ratio", "1", "J = det F", FieldType::real, 1, true, true},
    FieldInfo{Field::kirchhoff_stress, "kirchhoff_stress", "Pa", "tau = J sigma, xx yy zz xy yz xz", FieldType::real, 6,
              true, true, true},
    FieldInfo{Field::plastic_shear_rate, "plastic_shear_rate", "1/s", "sqrt(2) gamma of the last step", FieldType::real, 1,
              true, true},
    FieldInfo{Field::plastic_dissipation, "plastic_dissipation", "J/m^3", "energy dissipated so far per reference volume",
              FieldType::real, 1, true, true},
    FieldInfo{Field::reference_volume, "reference_volume", "m^3", "V_p^0", FieldType::real, 1, true, true},
    FieldInfo{Field::velocity_gradient, "velocity_gradient", "1/s",
              "L_p where it differs from affine_velocity, row-major; lives within a step", FieldType::real, 9, false,
              false, true},
    FieldInfo{Field::structure, "structure", "1", "structure of a thixotropic fluid, 0 broken down, 1 built up",
              FieldType::real, 1, true, true, true},
    FieldInfo{Field::hardening, "hardening", "1", "accumulated plastic strain of sand", FieldType::real, 1, true, true,
              true},
    FieldInfo{Field::plastic_volume_ratio, "plastic_volume_ratio", "1", "J / J_elastic of snow", FieldType::real, 1, true,
              true, true},
    FieldInfo{Field::viscous_left_cauchy_green, "viscous_left_cauchy_green", "1",
              "elastic left Cauchy-Green tensor of a relaxing branch, xx yy zz xy yz xz", FieldType::real, 6, true, true,
              true},
    FieldInfo{Field::added_law_variables, "added_law_variables", "1",
              "variables of a law that the program added, in the order of the law", FieldType::real, 8, true, true, true},
    FieldInfo{Field::cell_mean_stress, "cell_mean_stress", "Pa",
              "mean Cauchy stress by the implicit pressure of the particle's cell, which tau then lacks; tension positive",
              FieldType::real, 1, true, true, true},
    FieldInfo{Field::layer_pressure, "layer_pressure", "Pa",
              "of a fluid with a yield stress over a sticky floor: its pressure, without the sound in its layer", FieldType::real, 1, true,
              true, true},
    FieldInfo{Field::viscous_stress, "viscous_stress", "Pa",
              "Kirchhoff stress by implicit viscosity, which tau then lacks, xx yy zz xy yz xz", FieldType::real, 6, true,
              true, true},
    FieldInfo{Field::magnetic_field_strength, "magnetic_field_strength", "A/m",
              "magnitude of the magnetic field H, of materials whose yield stress depends on it", FieldType::real, 1, true,
              true, true},
    FieldInfo{Field::magnetic_force, "magnetic_force", "N", "force of the magnetic field, as of its last solution",
              FieldType::real, 3, true, true, true},
    FieldInfo{Field::magnetic_field, "magnetic_field", "A/m",
              "magnetic field H as nodes with magnetic material have it, of its last solution", FieldType::real, 3, true,
              true, true},
    FieldInfo{Field::magnetisation, "magnetisation", "A/m",
              "magnetisation of the undiluted material in the field inside it, as of its last solution", FieldType::real, 3,
              true, true, true},
    FieldInfo{Field::material, "material", "1", "index into the scene's materials", FieldType::uint8, 1, true, true},
    FieldInfo{Field::id, "id", "1", "unique, from the seeding geometry alone", FieldType::int64, 1, true, true},
};

static_assert(
    [] {
      for (std::size_t i = 0; i < field_table.size(); ++i)
        if (field_table[i].field != static_cast<Field>(i)) return false;
      return true;
    }(),
    "field_table must be in the order of Field");

/// The row of a field. Not collective.
constexpr const FieldInfo& info(Field field) { return field_table[static_cast<std::size_t>(field)]; }

/// Bytes of one component of one particle. Not collective.
constexpr std::size_t element_size(FieldType type) { return type == FieldType::uint8 ? 1 : 8; }

}  // namespace bulkley
