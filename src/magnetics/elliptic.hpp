#pragma once
// Complete elliptic integrals.

namespace bulkley {

/// Bulirsch's general integral over psi from 0 to pi/2 of
/// (a cos^2 + b sin^2) / ((cos^2 + p sin^2) sqrt(cos^2 + kc^2 sin^2)), to about 1e-15 of its terms. NaN for kc = 0 or p <= 0.
/// Bulirsch, Numerische Mathematik 13 (1969) 305. Not collective.
double complete_elliptic(double kc, double p, double a, double b);

}  // namespace bulkley
