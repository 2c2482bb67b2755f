#pragma once
// How many steps of the kernel a measurement takes.

namespace bulkley::rheometer {

/// Steps that divide `amount` (of strain or time) into parts of at most `largest`; at least 1. Throws UsageError above 1e9,
/// which would take minutes. Not collective.
int count_steps(double amount, double largest);

}  // namespace bulkley::rheometer
