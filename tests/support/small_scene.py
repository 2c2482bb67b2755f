"""A scene of a few hundred particles as a dictionary, for tests of the Python package."""


def small_scene(end=0.02):
    """A ball of cream falls on the floor, with a frame every quarter of the run, a front and a gauge."""
    return {
        "title": "small ball",
        "domain": {"lower": [0.0, 0.0, 0.0], "upper": [0.2, 0.2, 0.15], "cell_size": 0.0125},
        "time": {"end": end},
        "materials": {"fluid": {"law": "herschel_bulkley", "density": 200.0, "bulk_modulus": 1e5, "shear_modulus": 290.0,
                                "yield_stress": 30.0, "consistency": 10.0, "flow_index": 0.5}},
        "bodies": [{"name": "ball", "material": "fluid", "velocity": [0.0, 0.0, -2.0], "particles_per_cell": 8,
                    "shape": {"type": "sphere", "center": (0.1, 0.1, 0.05), "radius": 0.03}}],
        "boundaries": {"z_lower": {"type": "separating", "friction": 0.5}},
        "output": {"frame_interval": end / 4, "history_interval": 5, "fields": ["id", "velocity", "material"],
                   "front": [{"name": "reach", "axis": [0, 0, 1], "origin": [0.1, 0.1, 0.0]}],
                   "gauge": [{"name": "sensor", "face": "z_lower", "lower": [0.05, 0.05, 0.0], "upper": [0.15, 0.15, 0.0]}]},
        "checkpoint": {"at_end": True},
    }
