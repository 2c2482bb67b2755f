"""Steady shear flows of Herschel-Bulkley fluids between walls: the analytic profiles, and what cases measure of a run."""

import dataclasses

import numpy


@dataclasses.dataclass
class Flow:
    """A fluid that a force per volume drives; its shear stress grows by `slope` (Pa/m) with the distance y from the plane, axis
    or surface without stress, as far as the wall at `half`. The stress is `slope` y: the force in a channel and a film, half of
    it in a pipe."""
    yield_stress: float
    consistency: float
    index: float
    slope: float
    half: float

    @property
    def plug(self):
        """Half-width of the part that does not yield."""
        return self.yield_stress / self.slope

    def speed(self, y):
        power = 1.0 + 1.0 / self.index
        factor = (self.slope / self.consistency) ** (1.0 / self.index) / power
        return factor * ((self.half - self.plug) ** power - numpy.maximum(numpy.abs(y) - self.plug, 0.0) ** power)

    @property
    def largest(self):
        return float(self.speed(numpy.zeros(1))[0])

    @property
    def plane_mean(self):
        """Mean speed between y = 0 and the wall."""
        return self.largest * (1.0 - self.index / (2.0 * self.index + 1.0) * (1.0 - self.plug / self.half))

    def fluid_sets(self, stiffness=50.0, bulk=3.0):
        """Keys of the material `fluid`: shear modulus `stiffness` times the stress at the wall, bulk modulus `bulk` times that."""
        modulus = stiffness * self.slope * self.half
        return {"materials.fluid.yield_stress": self.yield_stress, "materials.fluid.consistency": self.consistency,
                "materials.fluid.flow_index": self.index, "materials.fluid.shear_modulus": modulus,
                "materials.fluid.bulk_modulus": bulk * modulus}


def profile_error(speed, truth):
    """Norm of the error over the norm of the truth, both over the particles."""
    return float(numpy.sqrt(((speed - truth) ** 2).sum() / (truth**2).sum()))


def yielding_from(y, particles):
    """The smallest |y| of a particle that flowed in the last step: what is nearer has not."""
    return float(numpy.abs(y)[particles["plastic_shear_rate"] > 0.0].min())


def unsteadiness(run):
    """Relative change of the mean speed along x over the last tenth of the run."""
    history = run.history()
    late = history["momentum_x_kg_ms"][history["time_s"] >= 0.9 * history["time_s"][-1]]
    return float((late.max() - late.min()) / late[-1])


def channel_sets(half, cells, layers=(-1.0, 1.0)):
    """A column of one cell, `cells` to a half, from layers[0] to layers[1] halves; filled as far as the fluid goes."""
    size = half / cells
    lower, upper = [0.0, 0.0, layers[0] * half], [size, size, layers[1] * half]
    return {"domain.lower": lower, "domain.upper": upper, "domain.cell_size": size}
