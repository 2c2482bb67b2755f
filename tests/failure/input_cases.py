"""The failure cases of scene files and overrides that are no scenes at all, or of absurd size.

That every key refuses every wrong value is tested in one process, by
tests/unit/config/every_key_test.cpp; here are the files, and a sample of the values."""

import random

from cases import FAILED, RUN, USAGE, Case

CHECK = ["check", "{scene}"]
FINISHED = 0


def content(make):
    """A preparation that writes the bytes `make(text)` as the scene file; `text` is what the case had made of base.toml."""
    def prepare(folder, program, scene):
        text = (folder / scene).read_bytes()
        (folder / scene).write_bytes(make(text))
    return prepare


def hundred_megabytes(folder, program, scene):
    with open(folder / scene, "ab") as file:
        file.write(b"\n")
        for _ in range(100):
            file.write((b"# " + b"x" * 1021 + b"\n") * 1024)


def scene_is_a_folder(folder, program, scene):
    (folder / scene).unlink()
    (folder / scene).mkdir()


def nested_tables(text):
    return text + b"\n[" + b".".join([b"a"] * 10000) + b"]\n"


def many_values(text):
    return text + b"\nmany = [" + b"1," * 2_000_000 + b"]\n"


def long_keys(text):
    return text + b"\n[" + b".".join([b"k" * 10000] * 15) + b"]\n" + b"".join(b"key%d = 1\n" % n for n in range(20000))


def value(name, old, new, sentence, **more):
    return Case("value_" + name, USAGE, sentence, replace={old: new}, arguments=CHECK, ranks=(1,), **more)


def override(name, assignment, sentence, ranks=(1,)):
    return Case("override_" + name, USAGE, sentence, arguments=[*CHECK, "--set", assignment], ranks=ranks)


def file_case(name, make, sentence, code=USAGE, **more):
    return Case("file_" + name, code, sentence, prepare=content(make), arguments=CHECK, ranks=(1,), **more)


def rigid_body(radius, center, more="density = 7800"):
    return (f'at_end = true\n[[rigid_bodies]]\nname = "weight"\nshape = {{ type = "sphere", center = {center}, '
            f"radius = {radius} }}\n{more}")


def guided(name, more, sentence):
    return value(f"rigid_body_{name}", "at_end = true", rigid_body(0.02, [0.03, 0.03, 0.03], "mass = 1\n" + more),
                 PLACE + r"'rigid_bodies\.0\." + sentence)


def inflow(more, position="[0.08, 0.08, 0.12]", radius=0.02, place="position"):
    return (f'at_end = true\n[[inflows]]\nname = "nozzle"\nmaterial = "fluid"\n'
            f'section = {{ type = "disc", radius = {radius} }}\n{place} = {position}\n{more}')


def shaped(shape):
    return inflow("speed = 1").replace('{ type = "disc", radius = 0.02 }', f'{{ type = "shape", shape = {shape} }}')


def inflow_value(name, text, sentence):
    return value("inflow_" + name, "at_end = true", text, PLACE + sentence)


def inflow_warning(name, text, sentence):
    return Case("warning_of_inflow_" + name, 0, "warning: inflow 'nozzle' " + sentence, replace={"at_end = true": text},
                arguments=CHECK, ranks=(1,))


CELL = "cell_size = 0.01"
BALL = "{ type = \"sphere\", center = [0.08, 0.08, 0.05], radius = 0.03 }"
FIELD = "particles_per_cell = 8"
PLACE = r"(?m)^scene\.toml:\d+:\d+: "


def formula(text):
    return f'particles_per_cell = 8\nvelocity_field = ["0", "{text}", "0"]'


INPUT_CASES = [
    # Files
    file_case("of_brackets", lambda text: text + b"\na = " + b"[" * 100_000,
              PLACE + "brackets are nested more than 32 deep"),
    file_case("of_inline_tables", lambda text: text + b"\na = " + b"{ a = " * 10_000,
              PLACE + "brackets are nested more than 32"),
    file_case("of_nested_tables", nested_tables, PLACE + "a key has more than 16 parts"),
    file_case("of_many_values", many_values, PLACE + "the text holds more than 500000 values"),
    file_case("of_long_keys", long_keys, r"unknown table 'kkkk.* \.\.\. "),
    file_case("of_noise", lambda text: random.Random(1).randbytes(5000), r"(?m)^scene\.toml:\d+:\d+: "),
    file_case("of_zeros", lambda text: bytes(5000), PLACE + "this is not valid TOML"),
    file_case("with_a_zero", lambda text: text.replace(b"ball", b"ba\0ll", 1), PLACE + "this is not valid TOML"),
    file_case("not_utf8", lambda text: text.replace(b'"ball"', b'"b\xff\xfell"', 1),
              PLACE + "this is not valid TOML: .*utf-8"),
    file_case("utf16", lambda text: text.decode().encode("utf-16"), PLACE),
    file_case("with_a_number_as_table", lambda text: text + b"\n[time.end]\nx = 1\n",
              PLACE + "key 'time.end' is given twice"),
    file_case("with_a_dotted_number", lambda text: b"a = 1\na.b = 2\n" + text, r"(?m)^scene\.toml:2:1: a key is given twice"),
    file_case("empty", lambda text: b"", PLACE + r"required table \[domain\] is missing"),
    file_case("with_byte_order_mark", lambda text: b"\xef\xbb\xbf" + text, "(?m)^memory ", FINISHED),
    file_case("with_crlf", lambda text: text.replace(b"\n", b"\r\n"), "(?m)^memory ", FINISHED),
    Case("file_of_100_megabytes", USAGE, r"(?m)^scene\.toml: is larger than 16 MiB", prepare=hundred_megabytes, ranks=(1,
         3)),
    Case("file_is_a_folder", USAGE, r"(?m)^scene\.toml: is a folder", prepare=scene_is_a_folder),
    Case("file_without_end", USAGE, r"(?m)^/dev/zero: is larger than 16 MiB", arguments=["check", "/dev/zero"], ranks=(1,
         3)),
    Case("file_that_fails", USAGE, r"(?m)^/proc/self/mem: cannot be (read|opened)", arguments=["check", "/proc/self/mem"],
         ranks=(1, 3)),

    # Overrides
    override("magnetic_material_without_field", "materials.fluid.magnetic={{law=\"linear\",susceptibility=1}}",
             r"\[materials\.fluid\.magnetic\] needs \[magnetics\]"),
    override("empty", "", r"(?m)^--set : an override has the form"),
    override("without_value", "time.end", r"(?m)^--set time\.end: an override has the form"),
    override("of_nothing", "=3", r"(?m)^--set =3: an override has the form"),
    override("with_bad_path", "time..end=3", "an override has the form"),
    override("nested", "a=" + "[" * 1000, "nested too deeply"),
    override("of_10000_tables", ".".join(["a"] * 10000) + "=1", r"nested too deeply"),
    override("of_an_entry_beyond", "bodies.7.velocity=[0,0,0]", r"'bodies' has no entry '7'; it has 1 entry \('ball'\)",
             ranks=(1, 3)),
    override("within_a_number", "time.end.x=3", r"'time\.end' is the number 0\.01, it has no entry 'x'"),
    override("of_a_list", "bodies=3", r"'bodies' must be a list of tables, not the integer 3"),
    override("line_break", "time.end=a\nb = 1\x1b[31m",
             r"(?m)^--set time\.end=a\\nb = 1\?\[31m: 'time\.end' must be a number"),

    # Values, a sample
    value("with_unit", CELL, "cell_size = 1 cm", PLACE + "this is not valid TOML"),
    value("date", CELL, "cell_size = 1979-05-27", PLACE + "'domain.cell_size' must be a number, not a date or time"),
    value("beyond_64_bits", "end = 0.01", "end = 99999999999999999999", PLACE + "this is not valid TOML"),
    value("huge", "end = 0.01", "end = 1e308", PLACE + r"'time\.end' is 1e\+308; it must be no larger than 1e\+100"),
    value("cells_beyond_count", CELL, "cell_size = 1e-9",
          PLACE + r"'domain\.cell_size' = 1e-09 gives 1\.6e\+08 cells along x; .*at most"),
    value("cells_huge", CELL, "cell_size = 1000000000000000000",
          PLACE + r"'domain\.cell_size' is .*; it must be .* at most 1000000000000"),
    value("far_domain", "upper = [0.16, 0.16, 0.16]", "upper = [1e99, 0.16, 0.16]", PLACE + r"'domain' reaches from 0 to 1e\+99 along x; it must lie within"),
    value("body_huge", "radius = 0.03", "radius = 1e90", r"body 'ball' reaches from .* outside the domain"),
    value("body_huge_and_turned", BALL,
          '{ type = "box", lower = [0, 0, 0], upper = [1e20, 1e20, 1e20], rotation = { angle = 30 } }',
          r"body 'ball' reaches from .* outside the domain"),
    value("body_of_too_many_particles", CELL, "cell_size = 1e-6", "would be filled with some .* particles|2\\^31 tiles"),
    value("endless_frames", "at_end = true", "at_end = true\n[output]\nframe_interval = 1e-99",
          PLACE + r"'output\.frame_interval' is 1e-99; it must be at least 1e-08, or there are more than 1e\+06 frames"),
    value("endless_steps", "end = 0.01", 'end = 0.01\nmode = "fixed"\ndt = 1e-99',
          PLACE + r"'time\.dt' is 1e-99; .* steps"),
    value("flat_collider", "at_end = true", 'at_end = true\n[[colliders]]\nname = "sheet"\nshape = { type = "box", '
          "lower = [0, 0, 0], upper = [0.1, 0.1, 1e-30] }", r"collider 'sheet' is .* thick"),
    value("needle_collider", "at_end = true", 'at_end = true\n[[colliders]]\nname = "needle"\nshape = { type = "box", '
          "lower = [0, 0, 0], upper = [1e50, 1e-30, 1e-30] }", r"collider 'needle' is .* thick"),

    value("rigid_body_thin", "at_end = true", rigid_body(0.008, [0.03, 0.03, 0.03]),
          r"rigid body 'weight' is 0.016 m thick, 1.6 cells; it must be at least 2 cells thick"),
    value("rigid_body_in_material", "at_end = true", rigid_body(0.02, [0.08, 0.08, 0.08]),
          r"rigid body 'weight' holds material of body 'ball' deeper than half a cell"),
    value("rigid_body_outside", "at_end = true", rigid_body(0.02, [0.01, 0.03, 0.03]),
          r"rigid body 'weight' reaches into face x_lower by more than half a cell"),
    value("rigid_body_without_mass", "at_end = true", rigid_body(0.02, [0.03, 0.03, 0.03], ""),
          PLACE + "rigid body 'weight' needs a 'density' or a 'mass', one of the two"),
    value("rigid_body_implicit_viscosity", "end = 0.01\n", 'end = 0.01\nintegrator = "imex"\nviscosity = "implicit"\n'
          + rigid_body(0.02, [0.03, 0.03, 0.03]).removeprefix("at_end = true") + "\n", PLACE + "'rigid_bodies' needs explicit viscosity"),
    value("rigid_body_petsc", "end = 0.01\n", 'end = 0.01\nintegrator = "imex"\npressure = { solver = "petsc" }\n'
          + rigid_body(0.02, [0.03, 0.03, 0.03]).removeprefix("at_end = true") + "\n",
          PLACE + r"'rigid_bodies' needs time\.pressure\.solver = \"cg\""),
    value("rigid_body_friction_that_slips", "at_end = true",
          rigid_body(0.02, [0.03, 0.03, 0.03], 'mass = 1\ncontact = "slip"\nmaterial_friction = 0.3'),
          PLACE + r"'rigid_bodies\.0\.material_friction'.*contact = \"separating\""),
    guided("negative_friction", 'contact = "separating"\nmaterial_friction = -0.1',
           r"material_friction' is -0.1; it must be at least 0"),
    guided("axis_and_line", "axis = [0, 0, 1]\nline = [1, 0, 0]", "line' is given beside 'axis'"),
    guided("point_alone", "axis_point = [0, 0, 1]", "axis_point' has no 'axis' through it"),
    guided("no_direction", "axis = [0, 0, 0]", r"axis' has no length; it must not be \[0, 0, 0\]"),
    guided("moving_off_line", "line = [1, 0, 0]\nvelocity = [1, 1, 0]", "velocity' is not along 'line'"),
    guided("moving_on_axis", "axis = [1, 0, 0]\nvelocity = [1, 0, 0]", "velocity' is given with an 'axis'"),
    guided("spinning_off_axis", "axis = [1, 0, 0]\nangular_velocity = [1, 1, 0]", "angular_velocity' is not along 'axis'"),
    guided("spinning_on_line", "line = [1, 0, 0]\nangular_velocity = [1, 0, 0]", "angular_velocity' is given with a 'line'"),
    guided("torque_on_line", 'line = [1, 0, 0]\ntorque = ["0", "0", "1"]', "torque' is given with a 'line'"),
    guided("soft_spring", "spring = -1", "spring' is -1; it must be at least 0"),
    guided("force_of_place", 'force = ["x", "0", "0"]', "force"),

    inflow_value("without_rate", inflow(""), "inflow 'nozzle' needs exactly one of 'flow_rate', 'speed', .*; it has 0"),
    inflow_value("backwards", inflow("flow_rate = -1e-3"), r"'inflows\.0\.flow_rate' is -0\.001; it must be at least 0"),
    inflow_value("backwards_later", inflow('flow_rate = "1e-4 * cos(1000*t)"'),
                 r"inflow 'nozzle' has the rate -.* at t = 0\.001.* s; it must be a number >= 0"),
    inflow_value("backwards_by_frames", inflow("", "[[0, 0.08, 0.08, 0.12, 0], [1, 0.08, 0.08, 0.12, 1e-6], [2, 0.08, 0.08, 0.12, 0]]",
                                               place="key_frames"),
                 r"'inflows\.0\.key_frames' has e = 0 in key frame 3 after 1e-06; the volume that has entered must not decrease"),
    inflow_value("outside", inflow("speed = 1", "[0.01, 0.08, 0.12]"), "inflow 'nozzle' reaches outside the domain at"),
    inflow_value("outside_behind", inflow("speed = 1", "[0.08, 0.08, 0.14]"),
                 r"inflow 'nozzle' reaches outside the domain at .*: its feed takes 0\.03 m behind the exit"),
    inflow_value("outside_later", inflow("", "[[0, 0.08, 0.08, 0.12, 0], [0.005, 0.28, 0.08, 0.12, 1e-6]]", place="key_frames"),
                 r"inflow 'nozzle' reaches outside the domain at .* at t = 0\.001"),
    inflow_value("narrow", inflow("speed = 1", radius=0.0099),
                 r"inflow 'nozzle' has a section 0\.0198 m wide; it must be at least 4 particles wide, 0\.02 m"),
    inflow_value("at_a_wall", inflow("speed = 1\ndirection = [-1, 0, 0]", "[0.019, 0.08, 0.12]"),
                 r"inflow 'nozzle' has its exit 0\.019 m from a face of the domain; it must be at least 2 cells, 0\.02 m"),
    inflow_value("at_a_plate", inflow('speed = 1\n[[colliders]]\nname = "plate"\nshape = { type = "box", '
                                      'lower = [0.04, 0.04, 0.08], upper = [0.12, 0.12, 0.101] }'),
                 r"inflow 'nozzle' has collider 'plate' in front of its exit; there must be at least 2 cells, 0\.02 m, between"),
    inflow_value("in_a_collider", inflow('speed = 1\n[[colliders]]\nname = "plate"\nshape = { type = "box", '
                                         'lower = [0.08, 0.04, 0.08], upper = [0.12, 0.12, 0.13] }'),
                 "inflow 'nozzle' has its exit inside collider 'plate'"),
    inflow_value("in_material", inflow("speed = 1", "[0.08, 0.08, 0.05]"), "inflow 'nozzle' has its feed inside body 'ball'"),
    inflow_value("twice", inflow("speed = 1") + inflow("speed = 1", "[0.08, 0.09, 0.12]").replace("at_end = true", "").replace(
        '"nozzle"', '"second"'), "inflow 'second' overlaps inflow 'nozzle'"),
    inflow_value("named_like_a_collider", inflow('speed = 1\n[[colliders]]\nname = "nozzle"\nshape = { type = "box", '
                                                 'lower = [0, 0, 0], upper = [0.04, 0.04, 0.04] }'),
                 r"'inflows\.0\.name' is \"nozzle\", which a collider or a rigid body has already"),
    inflow_value("of_nothing_known", inflow("speed = 1").replace('"fluid"', '"fluit"'),
                 "inflow 'nozzle' is made of 'fluit', which is not in .materials.; did you mean 'fluid'"),
    inflow_value("with_nothing", inflow('speed = 1\nmoves_with = "arm"'), r"'inflows\.0\.moves_with' is \"arm\", which is no collider"),
    value("inflow_of_too_many_ids", "at_end = true", inflow("speed = 1") + "".join(
        inflow("speed = 1").replace("at_end = true", "").replace('"nozzle"', f'"n{n}"') for n in range(128)),
        "129 inflows, 1 bodies and 4096 cells need more particle ids than 2.63"),
    inflow_value("without_its_file", inflow("", '"head.csv"', place="key_frames_file"),
                 "inflow 'nozzle': key_frames_file '.*head.csv' cannot be opened"),
    inflow_value("in_rigid_body", inflow('speed = 1\n[[rigid_bodies]]\nname = "weight"\ndensity = 1000\nshape = { type = "sphere", '
                                         'center = [0.08, 0.08, 0.13], radius = 0.015 }'),
                 "inflow 'nozzle' has its feed inside rigid body 'weight'"),
    inflow_warning("narrow", inflow("speed = 1", radius=0.015), "is 6 particles wide: with fewer than 8 its section is coarse"),
    inflow_warning("near_a_wall", inflow("speed = 1\ndirection = [-1, 0, 0]", "[0.03, 0.08, 0.12]"),
                   "has a wall 3 cells in front of its exit; with fewer than 4"),
    inflow_warning("drawn", inflow("", "[[0, 0.05, 0.08, 0.12, 0], [0.01, 0.08, 0.08, 0.12, 1.25663706e-6]]", place="key_frames"),
                   "moves 30 times as fast as the material in its exit: from 2 on"),
    inflow_value("profile_of_a_shape", shaped('{ type = "sphere", center = [0, 0, 0], radius = 0.03 }') + '\nprofile = "poiseuille"',
                 r"'inflows\.0\.profile' is \"poiseuille\", which sections of type \"disc\" and \"rectangle\" have and those of type "
                 r"\"shape\" do not; it must be \"plug\""),
    inflow_value("unknown_profile", inflow('speed = 1\nprofile = "parabola"'),
                 r"'inflows\.0\.profile' is \"parabola\"; it must be one of \"plug\", \"poiseuille\""),
    inflow_value("of_no_section", shaped('{ type = "sphere", center = [0, 0, 0.03], radius = 0.02 }'),
                 "inflow 'nozzle' has an empty section: its shape does not reach the plane z = 0"),
    inflow_value("of_an_endless_shape", shaped('{ type = "plane", point = [0, 0, 0], normal = [0, 0, 1] }'),
                 "inflow 'nozzle' has a section without end: its shape must have finite bounds"),
    inflow_value("of_a_thin_ring", shaped('{ type = "difference", parts = [{ type = "sphere", center = [0, 0, 0], radius = 0.03 }, '
                                          '{ type = "sphere", center = [0, 0, 0], radius = 0.0296 }] }'),
                 r"inflow 'nozzle' has a section of .* m\^2, of which its \d+ particles 0\.005 m apart fill .*: too few to show its shape"),
    inflow_value("at_no_pressure", inflow('speed = 1\npressure = "guessed"'),
                 r"'inflows\.0\.pressure' is \"guessed\"; it must be a number of Pa or \"measured\""),
    inflow_value("measured_in_rubber", inflow('speed = 1\npressure = "measured"').replace('"fluid"', '"grit"')
                 + '\n[materials.grit]\nlaw = "fixed_corotated"\ndensity = 1600\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\n',
                 r"'inflows\.0\.pressure' needs a law that keeps the pressure apart, and that of 'grit' does not"),
    Case("value_inflow_frames_of_words", USAGE, "key_frames_file '.*head.csv' line 2 is not five numbers t, x, y, z, e",
         replace={"at_end = true": inflow("", '"head.csv"', place="key_frames_file")}, arguments=CHECK, ranks=(1,),
         prepare=lambda folder, program, scene: (folder / "head.csv").write_text("t,x,y,z,e\n0,1,2\n")),
    Case("value_inflow_faster_than_the_step", USAGE, "the fixed time step of 0.0001 s is above the speed limit of 5e-05 s",
         replace={"at_end = true": inflow("speed = 100"), "end = 0.01": 'end = 0.01\nmode = "fixed"\ndt = 1e-4'}, ranks=(1,)),
    Case("inflow_too_fast_later", FAILED, "the fixed time step of 0.0001 s is above the collider limit of",
         replace={"at_end = true": inflow('speed = "1e4 * t"'), "end = 0.01": 'end = 0.01\nmode = "fixed"\ndt = 1e-4'}),

    value("gauge_on_nothing", "at_end = true", 'at_end = true\n[[output.gauge]]\nname = "p"\nface = "x_upper"\n'
          "center = [0, 0.08, 0.08]\nradius = 0.02", PLACE + "gauge 'p' covers nothing of face 'x_upper': the ball"),
    value("gauge_on_no_wall", "at_end = true", 'at_end = true\n[boundaries]\nx_upper = "open"\n[[output.gauge]]\nname = "p"\n'
          'face = "x_upper"', PLACE + r"'output\.gauge\.0\.face' is \"x_upper\", which is open: there is no wall"),

    # Formulas
    value("formula_open", FIELD, formula("sin(" * 500), PLACE + r"'bodies\.0\.velocity_field\.1' is no formula"),
    value("formula_of_words", FIELD, formula("drop table"), PLACE + r"'bodies\.0\.velocity_field\.1' is no formula"),
    value("formula_of_100000_letters", FIELD, formula("x" * 100_000 + " = 1"),
          PLACE + "'bodies.0.velocity_field.1' is no formula.* 100004 characters"),
    value("formula_empty", FIELD, formula(""), PLACE + r"'bodies\.0\.velocity_field\.1' is no formula"),
    Case("run_with_huge_value", USAGE, PLACE + r"'time\.end' is 1e\+308", replace={"end = 0.01": "end = 1e308"},
         arguments=RUN,
         ranks=(4,)),
]
