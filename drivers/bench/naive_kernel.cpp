#include "bench/naive_kernel.hpp"

#include <chrono>
#include <cmath>
#include <random>
#include <string>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

/// Base node and quadratic weights along the three axes.
struct Weights {
  int base[3];
  double offset[3];  ///< from the base node, in cells
  double w[3][3];    ///< [axis][node]

  Weights(const double* x, double inverse_dx) {
    for (int a = 0; a < 3; ++a) {
      const double xi = x[a] * inverse_dx;
      base[a] = static_cast<int>(xi - 0.5);
      const double f = xi - base[a];
      offset[a] = f;
      w[a][0] = 0.5 * (1.5 - f) * (1.5 - f);
      w[a][1] = 0.75 - (f - 1.0) * (f - 1.0);
      w[a][2] = 0.5 * (f - 0.5) * (f - 0.5);
    }
  }
};

}  // namespace

NaiveKernel::NaiveKernel(int n_cells, double radius, int particles_per_cell)
    : n_(n_cells), dx_(1.0 / n_cells), inverse_dx_(n_cells), gravity_(9.81) {
  lattice_width_ = static_cast<int>(std::lround(std::cbrt(particles_per_cell)));
  if (lattice_width_ < 1 || lattice_width_ > 4 || lattice_width_ * lattice_width_ * lattice_width_ != particles_per_cell)
    throw UsageError("particles_per_cell = " + std::to_string(particles_per_cell) + " must be 1, 8, 27 or 64");
  if (!(radius > 0.0 && 0.5 - radius >= 2.0 * dx_))
    throw UsageError("a ball of radius " + std::to_string(radius) + " does not fit into " + std::to_string(n_cells) +
                     " cells");
  const double E = 1e5, nu = 0.3, density = 1000.0, elastic_cfl = 0.1;
  shear_modulus_ = E / (2.0 * (1.0 + nu));
  bulk_modulus_ = E / (3.0 * (1.0 - 2.0 * nu));
  volume_ = dx_ * dx_ * dx_ / particles_per_cell;
  mass_ = density * volume_;
  dt_ = elastic_cfl * dx_ / std::sqrt((bulk_modulus_ + 4.0 / 3.0 * shear_modulus_) / density);
  grid_.resize(static_cast<std::size_t>(n_) * n_ * n_);
  seed(radius);
}

void NaiveKernel::seed(double radius) {
  const double shear_rate = 25.0, fall_speed = 2.0;
  const int k = lattice_width_;
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> jitter(-0.4, 0.4);
  for (int cell = 0; cell < n_ * n_ * n_; ++cell) {
    const int c[3] = {cell / (n_ * n_), cell / n_ % n_, cell % n_};
    for (int place = 0; place < k * k * k; ++place) {
      const int a[3] = {place / (k * k), place / k % k, place % k};
      NaiveParticle p{};
      double distance_squared = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        const double home = dx_ * (c[axis] + (a[axis] + 0.5) / k);
        distance_squared += (home - 0.5) * (home - 0.5);
        p.x[axis] = home + dx_ / k * jitter(generator);
      }
      if (distance_squared > radius * radius) continue;
      p.v[0] = shear_rate * (p.x[1] - 0.5);
      p.v[2] = -fall_speed;
      p.C[1] = shear_rate;
      for (int axis = 0; axis < 3; ++axis) p.F[4 * axis] = 1.0;
      particles_.push_back(p);
    }
  }
}

double NaiveKernel::step() {
  const auto start = std::chrono::steady_clock::now();
  p2g();
  grid_update();
  g2p();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void NaiveKernel::p2g() {
  for (GridNode& node : grid_) node = {};
  const double stress_factor = -dt_ * volume_ * 4.0 * inverse_dx_ * inverse_dx_;
  for (NaiveParticle& p : particles_) {
    double F[9];  // (1 + dt C) F
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        F[3 * r + c] =
            p.F[3 * r + c] + dt_ * (p.C[3 * r] * p.F[c] + p.C[3 * r + 1] * p.F[3 + c] + p.C[3 * r + 2] * p.F[6 + c]);
    for (int c = 0; c < 9; ++c) p.F[c] = F[c];

    // tau = kappa / 2 (J^2 - 1) 1 + mu J^(-2/3) dev(F F^T)
    const double J =
        F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) + F[2] * (F[3] * F[7] - F[4] * F[6]);
    const double root = std::cbrt(J);
    const double mu = shear_modulus_ / (root * root);
    double b[9];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        b[3 * r + c] = F[3 * r] * F[3 * c] + F[3 * r + 1] * F[3 * c + 1] + F[3 * r + 2] * F[3 * c + 2];
    const double pressure = 0.5 * bulk_modulus_ * (J * J - 1.0) - mu * (b[0] + b[4] + b[8]) / 3.0;
    double A[9];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        A[3 * r + c] = stress_factor * (mu * b[3 * r + c] + (r == c ? pressure : 0.0)) + mass_ * p.C[3 * r + c];

    const Weights s(p.x, inverse_dx_);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
          const double w = s.w[0][i] * s.w[1][j] * s.w[2][k];
          const double d[3] = {(i - s.offset[0]) * dx_, (j - s.offset[1]) * dx_, (k - s.offset[2]) * dx_};
          GridNode& to = node(s.base[0] + i, s.base[1] + j, s.base[2] + k);
          for (int r = 0; r < 3; ++r)
            to.v[r] += w * (mass_ * p.v[r] + A[3 * r] * d[0] + A[3 * r + 1] * d[1] + A[3 * r + 2] * d[2]);
          to.m += w * mass_;
        }
  }
}

void NaiveKernel::grid_update() {
  const int margin = 3;  // sticky walls, wide enough that no stencil leaves the grid
  for (int i = 0; i < n_; ++i)
    for (int j = 0; j < n_; ++j)
      for (int k = 0; k < n_; ++k) {
        GridNode& g = node(i, j, k);
        if (g.m <= 0.0) continue;
        for (double& v : g.v) v /= g.m;
        g.v[2] -= dt_ * gravity_;
        const auto in_wall = [&](int index) { return index < margin || index >= n_ - margin; };
        if (in_wall(i) || in_wall(j) || in_wall(k)) g.v[0] = g.v[1] = g.v[2] = 0.0;
      }
}

void NaiveKernel::g2p() {
  for (NaiveParticle& p : particles_) {
    const Weights s(p.x, inverse_dx_);
    double v[3] = {}, B[9] = {};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
          const double w = s.w[0][i] * s.w[1][j] * s.w[2][k];
          const double d[3] = {i - s.offset[0], j - s.offset[1], k - s.offset[2]};
          const GridNode& from = node(s.base[0] + i, s.base[1] + j, s.base[2] + k);
          for (int r = 0; r < 3; ++r) {
            const double wv = w * from.v[r];
            v[r] += wv;
            for (int c = 0; c < 3; ++c) B[3 * r + c] += wv * d[c];
          }
        }
    for (int r = 0; r < 3; ++r) {
      p.v[r] = v[r];
      p.x[r] += dt_ * v[r];
    }
    for (int c = 0; c < 9; ++c) p.C[c] = 4.0 * inverse_dx_ * B[c];
  }
}

}  // namespace bulkley
