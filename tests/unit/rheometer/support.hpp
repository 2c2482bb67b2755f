#pragma once
// Materials of the rheometer tests.

#include "material/material.hpp"

namespace bulkley::rheometer_test {

/// The foam of the reference tables.
inline HerschelBulkley foam() { return {{200.0, 109000.0, 290.0, 31.9, 27.2, 0.22}}; }
inline HerschelBulkley stiff_foam() { return {{200.0, 109000.0, 29000.0, 31.9, 27.2, 0.22}}; }
inline HerschelBulkley bingham() { return {{1000.0, 1e5, 1e4, 30.0, 10.0, 1.0}}; }
inline HerschelBulkley thickening() { return {{1000.0, 1e5, 1e4, 0.1, 10.0, 2.8}}; }
/// Viscosity 20 Pa s, relaxation time 0.02 s.
inline HerschelBulkley maxwell() { return {{1000.0, 1e5, 1000.0, 0.0, 40.0, 1.0}}; }
inline NeoHookean rubber() { return {{1000.0, 1e6, 2000.0}}; }

}  // namespace bulkley::rheometer_test
