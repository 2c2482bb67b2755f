"""Makes runs of Bulkley, reads what they write, and measures and draws it.

    run = bulkley.run("scene.toml", ranks=2)          # or bulkley.open_run("out/ball")
    run.status["state"], run.history["kinetic_energy"], run.frames[-1]["velocity"]

Everything is in SI units. A run that is only read is not disturbed.
"""

from bulkley._version import __version__
from bulkley.faults import DataError, RunError
from bulkley.history import History, Table, read_history
from bulkley.launch import run
from bulkley.maps import Map, Profile, binned, profile, slab
from bulkley.particles import Checkpoint, Frame, Grid, ParticleFile, is_chosen, open_file
from bulkley.run_folder import Run, Series, open_run
from bulkley.studies import Case, Study, open_study, study
from bulkley.values import values_of
from bulkley.viewing import view

__all__ = ["Case", "Checkpoint", "DataError", "Frame", "Grid", "History", "Map", "ParticleFile", "Profile", "Run", "RunError",
           "Series", "Study", "Table", "__version__", "binned", "is_chosen", "open_file", "open_run", "open_study", "profile",
           "read_history", "run", "slab", "study", "values_of", "view"]
