"""Nonlinear least squares for models that cost minutes a call: Levenberg-Marquardt with finite differences, whose model
calls come in batches, so that they can run side by side."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

DAMPING = (1e-3, 0.1)  # of the first candidates, relative to the diagonal of the normal matrix
HARDER = 30.0          # factor on them after candidates that were all worse
HARDEST = 1e5          # no better point is looked for beyond


@dataclass
class Fit:
    """`point`: (m,); `covariance`: (m, m), of residuals with unit variance, prior included; `cost`: the sum of squares of
    the residuals without the prior, at the point; `jacobian`: (n, m), without the prior; `converged`: whether nothing
    better was found."""
    point: np.ndarray
    covariance: np.ndarray
    cost: float
    jacobian: np.ndarray
    iterations: int
    converged: bool


Residuals = Callable[[Sequence[np.ndarray]], Sequence[np.ndarray]]


def minimise(residuals: Residuals, start: np.ndarray, prior: np.ndarray, step: np.ndarray, bounds: np.ndarray,
             largest: float = 1.0, iterations: int = 12,
             tell: Callable[[int, np.ndarray, float], None] | None = None) -> Fit:
    """Minimises |r(x)|^2 + |(x - start)/prior|^2.

    `residuals` takes a batch of points (m,) and returns their residuals (n,), each of unit variance. `prior`: (m,) standard
    deviations about the start; `step`: (m,) of the finite differences; `bounds`: (m, 2); `largest`: how far a coordinate may
    move in one iteration, in units of its prior's deviation; `tell(iteration, point, cost)` hears of progress.
    """
    point = np.clip(np.asarray(start, float), bounds[:, 0], bounds[:, 1])
    centre = point.copy()

    def whole(found, where):
        return float(found @ found + np.sum(((where - centre) / prior)**2))

    easiest, iteration, converged = 1.0, 0, False
    base, jacobian = linearised(residuals, point, step, bounds)
    while True:
        if tell:
            tell(iteration, point, float(base @ base))
        if iteration == iterations or converged:
            break
        iteration += 1
        cost = whole(base, point)
        normal = jacobian.T @ jacobian + np.diag(prior**-2)
        gradient = jacobian.T @ base + (point - centre) / prior**2
        while True:
            candidates = []
            for damping in DAMPING:
                move = -np.linalg.solve(normal + easiest * damping * np.diag(np.diag(normal)), gradient)
                move *= min(1.0, largest / max(np.abs(move / prior).max(), 1e-300))
                candidates.append(np.clip(point + move, bounds[:, 0], bounds[:, 1]))
            costs = [whole(found, where) for found, where in zip(residuals(candidates), candidates)]
            best = int(np.argmin(costs))
            if costs[best] < cost or easiest >= HARDEST:
                break
            easiest *= HARDER
        if costs[best] >= cost:
            converged = True
            continue
        small = np.abs(candidates[best] - point).max() < 0.2 * np.min(step)
        converged = bool(small or cost - costs[best] < max(0.2, 0.01 * cost))
        point = candidates[best]
        easiest = max(1.0, easiest / HARDER)
        base, jacobian = linearised(residuals, point, step, bounds)
    covariance = np.linalg.inv(jacobian.T @ jacobian + np.diag(prior**-2))
    return Fit(point, covariance, float(base @ base), jacobian, iteration, converged)


def linearised(residuals: Residuals, point: np.ndarray, step: np.ndarray,
               bounds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (n,) and their derivatives (n, m) at a point, by differences that stay within the bounds."""
    steps = np.where(point + step <= bounds[:, 1], step, -step)
    base, *moved = residuals([point, *(point + h * unit for h, unit in zip(steps, np.eye(len(point))))])
    return base, np.array([(there - base) / h for there, h in zip(moved, steps)]).T


def whitener(sigma: np.ndarray, shared: float) -> np.ndarray:
    """(n, n): makes residuals of unit variance of differences whose standard deviations are `sigma` (n,), of which the part
    `shared` of the variance, >= 0 and < 1, is one error common to all points, such as that of a calibration."""
    covariance = np.diag(sigma**2 * (1.0 - shared)) + shared * np.outer(sigma, sigma)
    return np.linalg.inv(np.linalg.cholesky(covariance))
