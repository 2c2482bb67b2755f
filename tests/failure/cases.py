"""The failure cases: what is wrong, and the exit code and sentence that must follow.

A case edits the text of base.toml (`replace`: old -> new, `append`: lines at the end), or runs other arguments, or damages
files first (`prepare`). In arguments {scene} is the scene file; `sentence` is a regular expression for the output.
"""

import struct
import zlib
from dataclasses import dataclass, field
from typing import Callable, Optional

RUN = ["run", "{scene}", "--out", "out"]
USAGE, FAILED = 2, 3


@dataclass
class Case:
    name: str
    code: int
    sentence: str
    replace: dict = field(default_factory=dict)
    append: str = ""
    arguments: list = field(default_factory=lambda: RUN)
    prepare: Optional[Callable] = None  # prepare(folder, program, scene): before the run that must fail
    ranks: tuple = (1, 4)
    limit: float = 20.0  # s; a run that takes longer counts as hanging


def petsc(options, solver="petsc"):
    return {"end = 0.01": f'end = 0.01\nintegrator = "imex"\npressure = {{ solver = "{solver}", petsc_options = {options} }}'}


def field(settings, source='kind = "uniform", field = ["1e4", "0", "0"]', law='law = "linear"'):
    return (f'\n[materials.fluid.magnetic]\n{law}\nsusceptibility = 1\n[magnetics]\n{settings}\n'
            f'sources = [{{ {source} }}]\n')


def petsc_field(options):
    return field(f'solver = "petsc"\npetsc_options = "{options}"')


def whole_run(folder, program, scene):
    """A run to step 5 that leaves a good checkpoint in out/."""
    outcome = program.run(["run", scene, "--out", "out", "--max-steps", "5"], 2, folder, 60)
    assert outcome.code == 0, outcome.text
    return folder / "out" / "checkpoint_000000005.h5"


def flip_byte(folder, program, scene):
    file = whole_run(folder, program, scene)
    data = bytearray(file.read_bytes())
    # In the middle of a particle field: the largest datasets make up most of the file.
    data[len(data) // 2] ^= 0x10
    file.write_bytes(data)


def truncate(folder, program, scene):
    file = whole_run(folder, program, scene)
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def replace_by_text(folder, program, scene):
    whole_run(folder, program, scene).write_text("not a checkpoint\n", encoding="utf-8")


def foreign_hdf5(folder, program, scene):
    import h5py
    with h5py.File(whole_run(folder, program, scene), "w") as file:
        file["x"] = [1.0, 2.0]


def too_new(folder, program, scene):
    import h5py
    with h5py.File(whole_run(folder, program, scene), "r+") as file:
        file.attrs["format_version"] = file.attrs["format_version"] + 1


def text_of(value):
    return value.encode() if isinstance(value, str) else bytes(value)


def header_crc(file):
    """The checksum of a checkpoint's header, as src/io/header.cpp packs it."""
    def number(value):
        return struct.pack("<d", value) if isinstance(value, float) else struct.pack("<q", value)

    def text(value):
        return number(len(text_of(value))) + text_of(value)

    root = file.attrs
    packed = number(int(root["step"])) + number(float(root["time"])) + text(root["scene"]) + text(root["code_version"])
    packed += number(int(root["n_ranks"])) + number(int(root["n_particles"]))
    for group, kind in (("reals", float), ("integers", int)):
        state = file["state"][group].attrs
        packed += number(len(state)) + b"".join(text(name) + number(kind(state[name])) for name in sorted(state))
    names = text_of(root["materials"]).split(b"\n")
    return zlib.crc32(packed + number(len(names)) + b"".join(text(name) for name in names))


def six_billion_particles(folder, program, scene):
    """A checkpoint of more particles than one rank, or either of two, can number; its arrays occupy no room on the disk."""
    import h5py
    with h5py.File(whole_run(folder, program, scene), "r+") as file:
        assert header_crc(file) == file.attrs["header_crc32"], "the header is packed in another way"
        file.attrs["n_particles"] = file.attrs["n_particles"].dtype.type(6_000_000_000)
        file.attrs["header_crc32"] = file.attrs["header_crc32"].dtype.type(header_crc(file))
        particles = file["particles"]
        for name in list(particles):
            old = particles[name]
            attributes = dict(old.attrs)
            kind, row = old.dtype, old.shape[1:]
            del particles[name]
            particles.create_dataset(name, shape=(6_000_000_000, *row), dtype=kind).attrs.update(attributes)


def out_is_a_file(folder, program, scene):
    (folder / "out").write_text("", encoding="utf-8")


def other_material(folder, program, scene):
    """A good checkpoint of a scene whose material has another name."""
    text = (folder / scene).read_text(encoding="utf-8")
    (folder / "other.toml").write_text(text.replace("fluid", "honey"), encoding="utf-8")
    whole_run(folder, program, "other.toml")


def escape(folder, program, scene):
    outcome = program.run(["run", scene, "--out", "out"], 3, folder, 60)
    assert outcome.code == FAILED, outcome.text


FEW_TILES = {"cell_size = 0.01": "cell_size = 0.02"}
FIXED_STEP = {"end = 0.01": 'end = 0.01\nmode = "fixed"\ndt = 0.005'}
RESTART = ["run", "{scene}", "--out", "out", "--restart"]
RESTART_FILE = ["run", "{scene}", "--out", "out", "--restart", "out/checkpoint_000000005.h5"]
INFO = ["info", "out/checkpoint_000000005.h5"]

CASES = [
    # The scene file
    Case("unknown_key", USAGE, r"scene\.toml:14:1: .*density_.*did you mean 'density'",
         replace={"density = 200.0": "density_ = 200.0"}),
    Case("unknown_table", USAGE, r"scene\.toml:\d+:\d+: .*gravty.*did you mean 'gravity'",
         replace={'title = "ball"': "gravty = [0, 0, -9.81]"}),
    Case("old_name_of_a_key", 0, r"warning: scene\.toml:11:1: 'time\.largest_step' is now called 'time\.dt_max'; the old name is "
         r"accepted in this version only", replace={"end = 0.01": "end = 0.01\nlargest_step = 1"}),
    Case("old_name_in_check", 0, r"warning: --set time\.largest_step=1: 'time\.largest_step' is now called 'time\.dt_max'",
         arguments=["check", "{scene}", "--set", "time.largest_step=1"]),
    Case("both_names_of_a_key", USAGE, r"scene\.toml:11:1: 'time\.largest_step' and 'time\.dt_max' are both given",
         replace={"end = 0.01": "end = 0.01\nlargest_step = 1\ndt_max = 1"}),
    Case("repeated_key", USAGE, r"scene\.toml:15:\d+: .*density.*twice",
         replace={"density = 200.0": "density = 200.0\ndensity = 300.0"}),
    Case("missing_key", USAGE, r"scene\.toml:\d+:\d+: .*cell_size.*missing", replace={"cell_size = 0.01": ""}),
    Case("mistyped_value", USAGE, r"scene\.toml:7:\d+: .*cell_size.*number",
         replace={"cell_size = 0.01": 'cell_size = "small"'}),
    Case("out_of_range", USAGE, r"scene\.toml:14:\d+: .*density.*-200.*greater than 0",
         replace={"density = 200.0": "density = -200.0"}),
    Case("thin_collider", USAGE, r"scene\.toml:\d+:\d+: collider 'blade' is 0\.005 m thick, 0\.5 cells.* make it 0\.02 m thick",
         append='[[colliders]]\nname = "blade"\nvelocity = [0, 0, 1]\n'
                'shape = { type = "box", lower = [0.02, 0.02, 0.01], upper = [0.14, 0.14, 0.015] }\n'),
    Case("key_frames_out_of_order", USAGE, r"scene\.toml:\d+:\d+: 'colliders\.0\.key_frames\.1\.time' is 0\.1 and must be later",
         append='[[colliders]]\nname = "rod"\nkey_frames = [{ time = 0.2 }, { time = 0.1 }]\n'
                'shape = { type = "sphere", center = [0.1, 0.1, 0.1], radius = 0.03 }\n'),
    Case("not_a_number", USAGE, r"scene\.toml:14:\d+: .*density.*nan", replace={"density = 200.0": "density = nan"}),
    Case("broken_toml", USAGE, r"scene\.toml:6:\d+: .*not valid TOML",
         replace={"lower = [0.0, 0.0, 0.0]": "lower = [0.0, 0.0"}),
    Case("two_conventions", USAGE, r"scene\.toml:\d+:\d+: .*yield_stress",
         replace={"sigma_Y = 31.9": "yield_stress = 18.4"}),
    Case("unknown_material", USAGE, r"scene\.toml:\d+:\d+: .*fluit.*'fluid'",
         replace={'material = "fluid"': 'material = "fluit"'}),
    Case("body_outside", USAGE, r"ball.*outside",
         replace={"center = [0.08, 0.08, 0.05]": "center = [0.08, 0.08, 0.02]"}),
    Case("bodies_overlap", USAGE, r"(?s)ball.*overlap|overlap.*ball", append="""
[[bodies]]
name = "second"
material = "fluid"
shape = { type = "box", lower = [0.05, 0.05, 0.07], upper = [0.1, 0.1, 0.1] }
particles_per_cell = 8
"""),
    Case("fixed_step_above_limit", USAGE, r"fixed time step of 0\.005 s is above the elastic limit",
         replace=FIXED_STEP),
    Case("check_fixed_step_above_limit", USAGE, r"fixed time step of 0\.005 s is above the elastic limit",
         replace=FIXED_STEP, arguments=["check", "{scene}"]),

    Case("bad_formula", USAGE, r'scene\.toml:\d+:\d+: .*velocity_field\.1.*"sin\(q\)".*token "q"',
         replace={"particles_per_cell = 8": 'particles_per_cell = 8\nvelocity_field = ["0", "sin(q)", "0"]'}),
    Case("velocity_without_value", USAGE, r"scene\.toml:\d+:\d+: body 'ball' has a velocity_field without a finite value",
         replace={"particles_per_cell = 8": 'particles_per_cell = 8\nvelocity_field = ["0", "log(x - 0.1)", "0"]'}),

    # The command line
    Case("unknown_subcommand", USAGE, r"bend", arguments=["bend", "{scene}"]),
    Case("no_subcommand", USAGE, r"subcommand", arguments=[]),
    Case("unknown_option", USAGE, r"--outt", arguments=["run", "{scene}", "--outt", "out"]),
    Case("missing_scene", USAGE, r"absent\.toml", arguments=["run", "absent.toml", "--out", "out"]),
    Case("override_of_unknown_key", USAGE, r"time\.ent.*did you mean 'end'", arguments=[*RUN, "--set", "time.ent=1"]),
    Case("bench_unknown_material", USAGE, r"--material creme: .*neo_hookean, .*cream", arguments=["bench", "--material", "creme"]),
    Case("bench_too_few_particles", USAGE, r"--particles.*11500", arguments=["bench", "--particles", "100"]),
    Case("bench_unknown_scheme", USAGE, r"--scheme.*apci.*apic", arguments=["bench", "--scheme", "apci"]),
    Case("bench_unknown_part", USAGE, r"--only.*speed.*cases", arguments=["bench", "--suite", "--only", "speed"]),
    Case("bench_small_without_suite", USAGE, r"--small requires --suite", arguments=["bench", "--small"]),
    Case("bench_suite_of_one_case", USAGE, r"--material excludes --suite",
         arguments=["bench", "--suite", "--material", "pie"]),
    Case("bench_suite_on_several_ranks", USAGE, r"--suite: .*one process", ranks=(2,), arguments=["bench", "--suite"]),
    # 3 x 3 x 3 tiles make a box for each of 6 or 8 ranks, not of 5 or 7
    Case("method_without_boxes", USAGE, r"the grid has 3 x 3 x 3 tiles .* too few .* 5 ranks .* partition\.method", ranks=(5,),
         arguments=[*RUN, "--set", "partition.method=ranges"], replace=FEW_TILES),
    Case("check_method_without_boxes", USAGE, r"too few .* 7 ranks .* partition\.method", ranks=(1,),
         arguments=["check", "{scene}", "-n", "7", "--set", "partition.method=uniform"], replace=FEW_TILES),
    Case("out_is_a_file", USAGE, r"out: the output folder cannot be made", prepare=out_is_a_file),

    Case("out_is_in_use", USAGE, r"out: .*--overwrite", prepare=whole_run),

    # Restart
    Case("restart_without_checkpoint", USAGE, r"no whole checkpoint", arguments=RESTART),
    Case("restart_flipped_byte", FAILED, r"checkpoint_000000005\.h5.*checksum", prepare=flip_byte, arguments=RESTART_FILE),
    Case("restart_truncated", FAILED, r"checkpoint_000000005\.h5", prepare=truncate, arguments=RESTART_FILE),
    Case("restart_text_file", FAILED, r"checkpoint_000000005\.h5.*HDF5", prepare=replace_by_text, arguments=RESTART_FILE),
    Case("restart_foreign_hdf5", FAILED, r"checkpoint_000000005\.h5", prepare=foreign_hdf5, arguments=RESTART_FILE),
    Case("restart_too_new", FAILED, r"checkpoint_000000005\.h5.*format version is 2", prepare=too_new,
         arguments=RESTART_FILE),
    Case("restart_on_too_few_ranks", FAILED,
         r"rank 0: \d+ particles are more than the 2147418111 that one rank can number; use more ranks",
         prepare=six_billion_particles, arguments=RESTART_FILE, ranks=(1, 2)),
    Case("restart_of_another_scene", USAGE, r"honey.*fluid.*another scene", prepare=other_material,
         arguments=RESTART),
    Case("restart_and_overwrite", USAGE, r"--restart.*--overwrite", arguments=[*RESTART, "--overwrite"]),
    Case("info_flipped_byte", FAILED, r"checkpoint_000000005\.h5.*checksum", prepare=flip_byte, arguments=INFO),

    # The run itself: on four ranks the particle leaves from one of them
    Case("acceleration_without_value", FAILED, r"t = 0\.00\d+ s: the acceleration_field is NaN or infinite on \d+ nodes?, "
         r"first at \(.*\) m", replace={'title = "ball"': 'acceleration_field = ["0", "0", "x < 0.08 ? sqrt(0.002 - t) : 0"]'}),
    Case("escaping_particle", FAILED, r"particles? left the domain .* is particle \d+ .* at \(.*\) m with speed 20 m/s and J = "
         r".*; let this face .*; what is around is saved in out/failure_\d+\.h5; there is no checkpoint yet",
         replace={"velocity = [0.0, 0.0, -1.0]": "velocity = [20.0, 0.0, 0.0]"}, append='[boundaries]\nx_upper = "open"\n'),
    Case("crushed", FAILED, r"crushed to less than 0\.995 of its volume .*: particle \d+ of material 'fluid' at \(.*\) m .*; try a "
         r"larger bulk_modulus.*saved in out/failure_\d+\.h5",
         replace={"end = 0.01": "end = 0.1\nsmallest_volume_ratio = 0.995", "[0.0, 0.0, -1.0]": "[0.0, 0.0, -5.0]"}),
    Case("grown", FAILED, r"grown to more than 1\.001 times its volume .*: particle \d+ of material 'fluid' at \(.*\) m .*; try more "
         r"particles per cell.*saved in out/failure_\d+\.h5",
         replace={"end = 0.01": "end = 0.1\nlargest_volume_ratio = 1.001", "[0.0, 0.0, -1.0]": "[0.0, 0.0, -5.0]"}),
    Case("more_than_a_cell_a_step", FAILED, r"a particle moves 1\.25 cells in a step of 0\.0005 s: particle \d+ of material 'fluid' "
         r"at \(.*\) m with speed 25\.0\d+ m/s .*saved in out/failure_000000001\.h5",
         replace={"end = 0.01": 'end = 0.01\nmode = "fixed"\ndt = 0.0005\nallow_unstable = true',
                  "[0.0, 0.0, -1.0]": "[0.0, 0.0, -25.0]"}),
    Case("inverted", FAILED, r"\d+ particles inverted .* the first is particle \d+ of material 'fluid' at \(.*\) m "
         r".*; try smaller factors of the time step .*saved in out/failure_000000001\.h5",
         replace={"end = 0.01": 'end = 0.01\nmode = "fixed"\ndt = 0.002\nallow_unstable = true',
                  "velocity = [0.0, 0.0, -1.0]": 'velocity_field = ["-700 * (x - 0.08)", "0", "0"]'}),
    Case("time_step_too_small", FAILED, r"the elastic limit of .* s \(particle \d+\) is below the smallest time step of 0\.0005 s: "
         r"particle \d+ of material 'fluid' at \(.*\) m .*; see what drives it there.*saved in out/failure_000000001\.h5",
         replace={"end = 0.01": "end = 0.01\ndt_min = 5e-4"}),
    Case("pressure_not_found", FAILED, r"the pressure of a step of 0\.002 s is not found in 2 iterations.*; choose a smaller time\.dt",
         replace={"end = 0.01": 'end = 0.1\nintegrator = "imex"\nmode = "fixed"\ndt = 0.002\nallow_unstable = true\n'
                                'pressure = { max_iterations = 2, tolerance = 1e-9 }'}),
    Case("pressure_of_no_step_found", FAILED, r"the time step would fall below its smallest value of .* s: even in that step the pressure "
         r"is not found in 2 iterations",
         replace={"end = 0.01": 'end = 0.1\nintegrator = "imex"\ndt_min = 1e-4\n'
                                'pressure = { max_iterations = 2, tolerance = 1e-9 }'}),
    Case("pressure_not_found_by_petsc", FAILED, r"the pressure of a step of 0\.002 s is not found by PETSc after 2 iterations: DIVERGED_ITS; "
         r"choose a smaller time\.dt",
         replace={"end = 0.01": 'end = 0.1\nintegrator = "imex"\nmode = "fixed"\ndt = 0.002\nallow_unstable = true\n'
                                'pressure = { max_iterations = 2, tolerance = 1e-9, solver = "petsc" }'}),
    Case("petsc_option_unknown", USAGE, r"time\.pressure\.petsc_options: PETSc's solver knows no option -bulkley_pressure_pc_typ\b",
         replace=petsc('"-bulkley_pressure_pc_typ hypre"')),
    Case("petsc_solver_unknown", USAGE, r"time\.pressure\.petsc_options: Unable to find requested PC type multigird",
         replace=petsc('"-bulkley_pressure_pc_type multigird"')),
    Case("petsc_option_without_prefix", USAGE, r"scene\.toml:12:\d+: 'time\.pressure\.petsc_options': '-pc_type' does not begin with "
         r"-bulkley_pressure_", replace=petsc('"-pc_type hypre"')),
    Case("petsc_option_without_effect", USAGE, r"'-bulkley_pressure_ksp_rtol' has no effect: time\.pressure\.tolerance and",
         replace=petsc('"-bulkley_pressure_ksp_rtol 1e-9"')),
    Case("petsc_option_after_dashes", USAGE, r"-bulkley_pressure_pc_type: options of the pressure's solver stand in the scene",
         arguments=["run", "{scene}", "--out", "out", "--", "-bulkley_pressure_pc_type", "hypre"]),
    Case("petsc_options_of_cg", USAGE, r"'time\.pressure\.petsc_options' is given but applies only with solver = ",
         replace=petsc('"-bulkley_pressure_pc_type hypre"', "cg")),
    Case("petsc_option_of_field_unknown", USAGE, r"magnetics\.petsc_options: PETSc's solver knows no option -magnetics_pc_typ\b",
         append=petsc_field("-magnetics_pc_typ hypre")),
    Case("petsc_solver_of_field_unknown", USAGE, r"magnetics\.petsc_options: Unable to find requested PC type multigird",
         append=petsc_field("-magnetics_mg_levels_pc_type multigird")),
    Case("petsc_option_of_field_without_effect", USAGE, r"'-magnetics_ksp_rtol' has no effect: magnetics\.tolerance says",
         append=petsc_field("-magnetics_ksp_rtol 1e-9")),
    Case("petsc_option_of_field_after_dashes", USAGE, r"-magnetics_pc_type: options of the magnetic field's solver stand in the scene",
         arguments=["run", "{scene}", "--out", "out", "--", "-magnetics_pc_type", "hypre"]),
    Case("field_not_found", FAILED, r"the magnetic field at t = 0 s is not found in 100 iterations: the residual is .*; choose a larger "
         r"magnetics\.tolerance", append=field("tolerance = 1e-300")),
    Case("permeability_not_settled", FAILED, r"the magnetic field at t = 0 s is not found in 1 sweeps: a permeability still changes by .*; "
         r"choose a larger magnetics\.picard_limit", append=field("picard_limit = 1", law='law = "langevin"\nsaturation = 1e4')),
    Case("magnet_in_material", USAGE, r"the source is inside body 'ball' at the start",
         append=field("air = 1", 'kind = "coil", center = [0.08, 0.08, 0.05], radius = 0.01, current = 1')),
    Case("field_with_divergence", USAGE, r"the formula is no field of magnets outside of the material: its divergence at .* is 1.* \|H\|/L",
         append=field("air = 1", 'kind = "formula", field = ["1e4*x", "0", "0"]')),
    Case("field_not_found_by_petsc", FAILED, r"the magnetic field at t = 0 s is not found in 100 iterations: the residual is ",
         append=petsc_field("-magnetics_ksp_type richardson -magnetics_pc_type none")),
    Case("pressure_without_imex", USAGE, r"scene\.toml:11:1: 'time\.pressure' is given but applies only with integrator = ",
         replace={"end = 0.01": "end = 0.01\npressure = { tolerance = 1e-4 }"}),
    Case("viscous_motion_not_found", FAILED, r"the viscous motion of a step of 0\.002 s is not found in 1 iterations.*; choose a smaller "
         r"time\.dt.* or a larger time\.viscous\.max_iterations",
         replace={"end = 0.01": 'end = 0.1\nintegrator = "imex"\nviscosity = "implicit"\nmode = "fixed"\ndt = 0.002\n'
                                'allow_unstable = true\nviscous = { max_iterations = 1, tolerance = 1e-9 }',
                  "h = 0.22": "h = 0.22\nbackground_viscosity = 5.0"}),
    Case("viscosity_without_imex", USAGE, r"scene\.toml:11:1: 'time\.viscosity' is given but applies only with integrator = ",
         replace={"end = 0.01": 'end = 0.01\nviscosity = "implicit"'}),
    Case("viscous_settings_of_explicit_viscosity", USAGE, r"'time\.viscous' is given but applies only with viscosity = ",
         replace={"end = 0.01": 'end = 0.01\nintegrator = "imex"\nviscous = { tolerance = 1e-4 }'}),
    Case("info_of_what_was_around", 0, r"frame 0 of step 1, .*\n912 particles(.|\n)*checksums are right", prepare=escape, arguments=["info", "out/failure_000000001.h5"],
         replace={"velocity = [0.0, 0.0, -1.0]": "velocity = [20.0, 0.0, 0.0]",
                  "end = 0.01": 'end = 0.01\nmode = "fixed"\ndt = 0.05\nallow_unstable = true'},
         append='[boundaries]\nx_upper = "open"\n'),
]
