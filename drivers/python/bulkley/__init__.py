"""Reads what runs of Bulkley write.

    run = bulkley.open_run("out/ball")
    run.status["state"], run.history["kinetic_energy"], run.frames[-1]["velocity"]

Everything is in SI units. Nothing is written, and a running simulation is not disturbed.
"""

from bulkley._version import __version__
from bulkley.faults import DataError
from bulkley.history import History, read_history
from bulkley.maps import Map, Profile, binned, profile, slab
from bulkley.particles import Checkpoint, Frame, Grid, ParticleFile, is_chosen, open_file
from bulkley.run import Run, Series, open_run
from bulkley.values import values_of

__all__ = ["Checkpoint", "DataError", "Frame", "Grid", "History", "Map", "ParticleFile", "Profile", "Run", "Series",
           "__version__", "binned", "is_chosen", "open_file", "open_run", "profile", "read_history", "slab", "values_of"]
