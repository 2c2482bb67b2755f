"""Thin layers of a yield-stress fluid: how they spread and where they stop, for the cases of arrest.

`Layer` holds the fluid and the slope; heights are column heights h(x) over a floor on which the fluid sticks, behind a wall (or
axis) at x = 0. Shear convention throughout: tau = yield_stress + consistency (shear rate)^index."""

import math
from dataclasses import dataclass, replace

import numpy

G = 9.81
STAGES = 15  # odd: of the steps of `Layer.spread`


@dataclass
class Layer:
    density: float
    yield_stress: float
    consistency: float
    index: float
    angle: float = 0.0         # of the floor, radians; downhill along +x
    axisymmetric: bool = False

    def as_it_lies(self, particles):
        """The fluid with the mean density that its particles have: a soft modulus lets it be compressed, by 1 to 2 % in these cases."""
        volume = particles["reference_volume"]
        return replace(self, density=self.density * float(numpy.sum(volume) / numpy.sum(volume * particles["volume_ratio"])))

    def spread(self, edges, heights, times, second_order=False):
        """The lubrication equation h_t + q_x = 0, or h_t + (r q)_r / r = 0, at `times`. With the driving stress per depth
        S = rho g (sin a - cos a h_x) and the sheared depth Y = max(h - tau_c / |S|, 0), the flow is
        q = sgn(S) n / ((n + 1)(2 n + 1)) (|S| / K)^(1/n) Y^(1 + 1/n) ((2 n + 1) h - n Y). Finite volumes, with Runge-Kutta-Legendre steps of
        first order (Meyer, Balsara, Aslam 2014): as many stages as STAGES are stable over a step that grows with their square. The second
        order, of a layer that stretches as it flows, adds the normal stress of `arrested` to the drive: S + `tension` h_x / h."""
        n, width, s = self.index, edges[1] - edges[0], STAGES
        weight = edges if self.axisymmetric else numpy.ones_like(edges)
        middle = 0.5 * (weight[1:] + weight[:-1])
        fall, lean = self.density * G * math.cos(self.angle), self.density * G * math.sin(self.angle)
        pull = self.tension() if second_order else 0.0
        flow = numpy.zeros_like(edges)

        def rate(h):
            """h_t, and the longest step that is stable."""
            higher = numpy.maximum(numpy.maximum(h[:-1], h[1:]), 1e-9)
            drive = lean - numpy.maximum(fall - pull / higher, 0.0) * numpy.diff(h) / width
            size = numpy.maximum(numpy.abs(drive), 1e-9)
            wet = numpy.where(drive > 0.0, h[:-1], h[1:]) > 1e-9  # nothing flows out of a dry cell
            depth = numpy.where(wet, 0.5 * (h[1:] + h[:-1]), 0.0)
            sheared = numpy.maximum(depth - self.yield_stress / size, 0.0)
            base = n / ((n + 1) * (2 * n + 1)) * (size / self.consistency)**(1 / n) * sheared**(1 / n)
            flow[1:-1] = numpy.sign(drive) * base * sheared * ((2 * n + 1) * depth - n * sheared)
            # dq / dh_x, bounded: through the power of S, and through Y
            spread = fall / size * (numpy.abs(flow[1:-1]) / n + base * (1 + 1 / n) * (2 * n + 1) * depth * self.yield_stress / size)
            return -numpy.diff(weight * flow) / (width * middle), 0.2 * width**2 / (spread.max() + 1e-30) * (s * s + s) / 2

        def stepped(h, first, step):
            before, last, share = h, h + 2.0 / (s * s + s) * step * first, 2.0 / (s * s + s)
            for k in range(2, s + 1):
                mu = (2 * k - 1) / k
                before, last = last, mu * last + (1 - k) / k * before + mu * share * step * rate(last)[0]
            return last

        h, now, result = heights.copy(), 0.0, []
        change, longest = rate(h)
        for time in times:
            while now < time - 1e-12:
                step = min(longest, time - now)
                while True:  # the diffusivity may grow within a step
                    with numpy.errstate(over="ignore", invalid="ignore"):
                        after = stepped(h, change, step)
                        change_after, longest = rate(after)
                    if numpy.isfinite(after).all() and step <= 1.5 * longest:
                        break
                    step *= 0.5
                h, change, now = after, change_after, now + step
            result.append(h.copy())
        return result

    def tension(self):
        """The mean over the depth of the normal stress along the layer beyond that along the depth, Pa, of a layer at yield that stretches
        and whose floor carries tau_c: shear is tau_c (1 - z/h), so that tau_c sqrt(1 - (1 - z/h)^2), pi/4 of tau_c in the mean, is
        left for stretching. Along x that is 2 of it. About an axis, where a layer that comes to rest spreads like r (it stays similar to
        itself, h = R^-2 g(r/R)), stretching is the same along r and around: sqrt(3) of it, and no hoop force."""
        return (math.sqrt(3.0) if self.axisymmetric else 2.0) * 0.25 * math.pi * self.yield_stress

    def arrested(self, volume, second_order=False):
        """The layer at rest on a level floor with `volume`, per width along x: (front, function h(x)). Where all of it has yielded, the
        floor carries tau_c everywhere: h h_x = -t with t = tau_c / (rho g). The second order adds the normal stress of a layer at
        yield that stretches: (h - c) h_x = -t with c = `tension` / (rho g). The front bears no force: h = 2 c there."""
        t = self.yield_stress / (self.density * G)
        c = self.tension() / (self.density * G) if second_order else 0.0

        def height(x, length):
            return numpy.where(x < length, c + numpy.sqrt(c * c + 2.0 * t * numpy.maximum(length - x, 0.0)), 0.0)

        def content(length):  # x = length (1 - s^2) takes the root of the front away
            s = (numpy.arange(2000) + 0.5) / 2000
            x = length * (1.0 - s * s)
            return float(numpy.mean(height(x, length) * (2.0 * math.pi * x if self.axisymmetric else 1.0) * 2.0 * length * s))
        low, high = 0.0, 1.0
        while content(high) < volume:
            high *= 2.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if content(middle) < volume else (low, middle)
        return high, lambda x: height(x, high)


def quarter_cylinder(radius, height, cell):
    """A quarter of an upright cylinder about the z axis as a shape of strips half a cell wide, one a row of particles: bodies may
    not reach out of the domain, so the scene's planes of symmetry cannot cut a whole one."""
    width = 0.5 * cell
    rows = [(i + 0.5) * width for i in range(math.ceil(radius / width))]
    parts = [{"type": "box", "lower": [x - 0.5 * width, 0.0, 0.0],
              "upper": [x + 0.5 * width, math.sqrt(radius**2 - x**2), height]} for x in rows if x < radius]
    return {"type": "union", "parts": parts}


def columns(particles, edges, thickness):
    """Column heights between `edges` along x, from the particles' present volumes; `thickness`: of the slab along y."""
    volume = particles["reference_volume"] * particles["volume_ratio"]
    return numpy.histogram(particles["position"][:, 0], edges, weights=volume)[0] / numpy.diff(edges) / thickness


def means(height, edges):
    """Means of the function `height` between `edges`."""
    parts = (numpy.arange(20) + 0.5) / 20
    return numpy.mean(height(edges[:-1, None] + parts * numpy.diff(edges)[:, None]), axis=1)


def rings(particles, edges, share):
    """Mean heights over rings about the z axis; `share`: part of the full circle that is filled."""
    volume = particles["reference_volume"] * particles["volume_ratio"]
    radius = numpy.hypot(particles["position"][:, 0], particles["position"][:, 1])
    return numpy.histogram(radius, edges, weights=volume)[0] / (share * math.pi * numpy.diff(edges**2))


def misplaced(heights, truth, areas):
    """Share of the volume that lies elsewhere than in `truth`: half the L1 norm of the difference over the volume."""
    return 0.5 * float(numpy.sum(numpy.abs(heights - truth) * areas) / numpy.sum(truth * areas))


def front(middles, heights, least):
    """Where the height last falls below `least`, between the middles of columns."""
    last = int(numpy.nonzero(heights > least)[0].max())
    share = (heights[last] - least) / (heights[last] - heights[last + 1])
    return middles[last] + share * (middles[last + 1] - middles[last])


def speed(particles):
    """Root mean square of the particles' speeds."""
    return float(numpy.sqrt(numpy.mean(numpy.sum(particles["velocity"]**2, axis=1))))
