"""One number a particle, of any field."""

import numpy as np

from bulkley.faults import DataError
from bulkley.particles import ParticleFile, suffixes


def values_of(file: ParticleFile, field: str, component: str | int | None = None) -> np.ndarray:
    """(n,), float64: a scalar field, or of a vector or tensor one component ("z", "xy", or its number) or "magnitude" (of
    tensors the Frobenius norm). Raises DataError."""
    array = file[field]
    values = array.reshape(len(array), -1).astype(float) if len(array) else np.zeros((0, int(np.prod(array.shape[1:]))))
    n = values.shape[1]
    names = [suffix[1:] for suffix in suffixes(n)]
    if n == 1 and component is None:
        return values[:, 0]
    if component == "magnitude":
        weights = np.array([1, 1, 1, 2, 2, 2]) if n == 6 else np.ones(n)  # xy also represents yx
        return np.sqrt(values**2 @ weights)
    if component in names:
        return values[:, names.index(component)]
    if isinstance(component, int) and 0 <= component < n:
        return values[:, component]
    raise DataError(f"'{file.path}': {field} has {n} components, and 'component' is {component!r}; it may be 'magnitude'"
                    + (f", {', '.join(names)}" if n > 1 else "") + f" or 0 to {n - 1}")


def shown_field(file: ParticleFile, field: str | None = None,
                component: str | int | None = None) -> tuple[str, str | int | None]:
    """The field and component that a picture shows: those given; else the velocity, or the first field that is neither
    position nor id; of vectors and tensors the magnitude. Raises DataError."""
    if field is None:
        others = [name for name in file.fields if name not in ("position", "id")]
        if not others:
            raise DataError(f"'{file.path}' has no field to show: add one to output.fields")
        field = "velocity" if "velocity" in others else others[0]
    if component is None and file[field].ndim > 1:
        component = "magnitude"
    return field, component


def label_of(file: ParticleFile, field: str, component: str | int | None) -> str:
    """Name and unit, for axes."""
    unit = file.units[field]
    name = field.replace("_", " ") + (f", {component}" if component is not None else "")
    return name + (f" [{unit}]" if unit not in ("", "1") else "")
