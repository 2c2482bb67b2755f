# %% [markdown]
# # Looking at a run
# The cells of this file run one by one in Jupyter or an editor that knows `# %%`, or all at once:
#
#     python3 look_at_a_run.py FOLDER_OF_A_RUN PICTURE.png

# %%
import sys

import matplotlib.pyplot as plt
import numpy as np

import bulkley
from bulkley import plot

folder, picture = (sys.argv[1:3] + ["out/ball", "run.png"][len(sys.argv) - 1:])[:2]
run = bulkley.open_run(folder)
print(run, run.status["state"], f"{len(run.frames)} frames, {len(run.checkpoints)} checkpoints")

# %% [markdown]
# History: arrays by name, with units. `run.history.to_pandas()` gives a table, if pandas is installed.

# %%
history = run.history
loss = history["dissipated_energy"][-1]
print(f"dissipated: {loss:.4g} {history.units['dissipated_energy']} in {history['time'][-1]:.4g} s")

# %% [markdown]
# A frame is a set of particles at one time. Arrays are read on access.

# %%
frame = run.frames[-1]
print(frame.time, frame.n_particles, frame.units)
speed = bulkley.values_of(frame, "velocity", "magnitude")
low = frame.select(region=((None, None), (None, None), (None, float(np.median(frame.positions[:, 2])))))
print(f"mean speed {speed.mean():.4g} m/s, of the lower half {speed[low].mean():.4g} m/s")

# %% [markdown]
# A slice, a map in the plane of the same slice, a profile from below to above, and the energies.

# %%
middle = frame.positions.mean(axis=0)
cell = run.scene["domain"]["cell_size"]
cut = bulkley.slab(frame, "y", middle[1], 2 * cell)
bottom, top = frame.positions[:, 2].min(), frame.positions[:, 2].max()

figure, axes = plt.subplots(2, 2, figsize=(10, 6.5), layout="constrained")
plot.plot_slice(frame, "velocity", "y", middle[1], 2 * cell, component="magnitude", axes=axes[0, 0])
plot.plot_map(bulkley.binned(frame, "velocity", "xz", cell, component="magnitude", chosen=cut), axes=axes[0, 1])
plot.plot_profile(bulkley.profile(frame, "velocity", (middle[0], middle[1], bottom), (middle[0], middle[1], top + cell),
                                  radius=2 * cell, n=10, component="z"), axes=axes[1, 0], marker="o")
plot.plot_history(history, ["kinetic_energy", "elastic_energy", "dissipated_energy"], axes=axes[1, 1])
figure.savefig(picture, dpi=100)
