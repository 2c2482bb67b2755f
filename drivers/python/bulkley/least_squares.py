"""Nonlinear least squares for models that cost minutes a call: Levenberg-Marquardt with finite differences, whose model
calls come in batches, so that they can run side by side. Made for narrow, bent valleys, as fronts of yielding fluids have."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

DAMPING = (1e-3, 0.1)  # of the first candidates, relative to the diagonal of the normal matrix
HARDER = 30.0          # factor on them after candidates that were all worse
HARDEST = 500.0        # no better point is looked for beyond
FINER = 0.35           # factor on the steps of the differences where a move gains little
FINEST = 0.13          # factor on the steps given: none finer are tried
AWAY = 0.5             # of the priors' deviations: how far along the valley the search begins again


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


class Problem:
    """|r(x)|^2 + |(x - centre)/prior|^2, and the search for its minimum."""

    def __init__(self, residuals: Residuals, centre: np.ndarray, prior: np.ndarray, step: np.ndarray, bounds: np.ndarray,
                 tell: Callable[[int, np.ndarray, float], None] | None):
        self.residuals, self.prior, self.step, self.bounds = residuals, prior, step, bounds
        self.centre = self.within(np.asarray(centre, float))
        self.tell = tell or (lambda iteration, point, cost: None)
        self.iteration = 0
        self.seen = []  # (point, cost) of every call

    def within(self, point):
        return np.clip(point, self.bounds[:, 0], self.bounds[:, 1])

    def evaluate(self, points):
        """Residuals (n,) and costs, prior included, of points (m,)."""
        found = self.residuals(points)
        costs = [float(there @ there + np.sum(((point - self.centre) / self.prior)**2)) for there, point in zip(found, points)]
        self.seen += zip(points, costs)
        return found, costs

    def linearised(self, point, fineness):
        """Residuals (n,), their derivatives (n, m), by differences that stay within the bounds, and the cost, prior included."""
        steps = fineness * np.where(point + fineness * self.step <= self.bounds[:, 1], self.step, -self.step)
        (base, *moved), costs = self.evaluate([point, *(point + h * unit for h, unit in zip(steps, np.eye(len(point))))])
        return base, np.array([(there - base) / h for there, h in zip(moved, steps)]).T, costs[0]

    def better(self, point, base, jacobian, cost, easiest, largest):
        """The best point of a move, or the point itself, its cost, and the factor on the damping that the next move begins with."""
        normal = jacobian.T @ jacobian + np.diag(self.prior**-2)
        gradient = jacobian.T @ base + (point - self.centre) / self.prior**2
        while True:
            candidates = []
            for damping in DAMPING:
                move = -np.linalg.solve(normal + easiest * damping * np.diag(np.diag(normal)), gradient)
                move *= min(1.0, largest / max(np.abs(move / self.prior).max(), 1e-300))
                candidates.append(self.within(point + move))
            _, costs = self.evaluate(candidates)
            best = int(np.argmin(costs))
            if costs[best] < cost:
                return candidates[best], costs[best], max(1.0, easiest / HARDER)
            if easiest >= HARDEST:
                return point, cost, 1.0
            easiest *= HARDER

    def descend(self, point, largest, iterations, finest):
        """(point, cost, converged): moves until they gain little with differences over `finest` times the steps or less."""
        easiest, fineness, converged = 1.0, 1.0, False
        for _ in range(iterations):
            base, jacobian, before = self.linearised(point, fineness)
            self.tell(self.iteration, point, float(base @ base))
            self.iteration += 1
            point, cost, easiest = self.better(point, base, jacobian, before, easiest, largest)
            if before - cost < max(0.2, 0.01 * before):
                converged = fineness <= finest
                fineness *= FINER
            if converged:
                break
        return point, cost, converged

    def along_the_valley(self, point, cost, largest, iterations):
        """(point, converged): the better of a minimum and those that are found from both sides of it."""
        _, jacobian, _ = self.linearised(point, 1.0)
        free = self.prior > self.step
        scaled = jacobian[:, free] * self.prior[free]
        weakest = np.zeros(len(point))
        weakest[free] = np.linalg.eigh(scaled.T @ scaled)[1][:, 0]
        best = point, cost, True
        for side in (AWAY, -AWAY):
            other, reached, _ = self.descend(self.within(point + side * weakest * self.prior), largest, iterations, 1.0)
            if reached < best[1]:
                best = self.descend(other, largest, iterations, FINEST)
        return best[0], best[2]

    def enlarged(self, covariance, point, cost, variance):
        """The covariance, made so large that what it predicts of the costs of the runs near the minimum is not too much:
        the valley that they show may be longer than its slopes at the minimum say. `variance`: of the residuals."""
        ways = [(where - point, max(found - cost, variance)) for where, found in self.seen if found - cost < 9.0 * variance]
        for _ in range(len(ways)):
            precision = np.linalg.inv(covariance)
            way, rise = max(ways, key=lambda entry: entry[0] @ precision @ entry[0] / entry[1])
            predicted = way @ precision @ way
            if predicted <= rise:
                break
            covariance = covariance + np.outer(way, way) * (1.0 / rise - 1.0 / predicted)
        return covariance


def minimise(residuals: Residuals, start: np.ndarray, prior: np.ndarray, step: np.ndarray, bounds: np.ndarray,
             largest: float = 1.0, iterations: int = 12,
             tell: Callable[[int, np.ndarray, float], None] | None = None) -> Fit:
    """Minimises |r(x)|^2 + |(x - start)/prior|^2.

    `residuals` takes a batch of points (m,) and returns their residuals (n,), each of unit variance; it should remember those of
    points that it has seen. `prior`: (m,) standard deviations about the start; `step`: (m,) of the finite differences; `bounds`:
    (m, 2); `largest`: how far a coordinate may move in one iteration, in units of its prior's deviation; `iterations`: at most, in
    each descent; `tell(iteration, point, cost)` hears of progress.

    Where moves gain little the slopes are taken over shorter ways: in a narrow bent valley those over long ones point up its
    sides. From the point found the search begins again at both sides of it, along the direction that the data determine
    least, and goes on from there if that is better. The covariance is of slopes over the steps given, since over shorter ones bumps of
    the model pass for knowledge, and holds the points seen on the way whose cost is near the smallest.
    """
    problem = Problem(residuals, start, prior, step, bounds, tell)
    point, cost, converged = problem.descend(problem.centre, largest, iterations, FINEST)
    if converged:
        point, converged = problem.along_the_valley(point, cost, largest, iterations)
    base, jacobian, cost = problem.linearised(point, 1.0)
    misfit = float(base @ base)
    variance = max(1.0, misfit / max(1, len(base) - int(np.sum(prior > step))))
    covariance = problem.enlarged(np.linalg.inv(jacobian.T @ jacobian + np.diag(prior**-2)), point, cost, variance)
    return Fit(point, covariance, misfit, jacobian, problem.iteration, converged)


def whitener(sigma: np.ndarray, shared: float) -> np.ndarray:
    """(n, n): makes residuals of unit variance of differences whose standard deviations are `sigma` (n,), of which the part
    `shared` of the variance, >= 0 and < 1, is one error common to all points, such as that of a calibration."""
    covariance = np.diag(sigma**2 * (1.0 - shared)) + shared * np.outer(sigma, sigma)
    return np.linalg.inv(np.linalg.cholesky(covariance))
