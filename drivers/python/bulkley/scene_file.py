"""Scenes that are given as dictionaries, and keys that override them, as the program reads them."""

import json
import math
import numbers
import os
import pathlib
import re
from collections.abc import Mapping

import numpy as np

from bulkley.faults import RunError

FILE_KEYS = ("file", "key_frames_file")  # paths, which the program takes from the scene file's folder


def toml_text(scene: Mapping) -> str:
    """The scene as TOML: tables with headers, lists of tables as [[name]] with one key a line. Raises RunError where a value
    has no form in TOML."""
    lines: list[str] = []
    add_table(lines, scene, [])
    return "\n".join(lines).lstrip("\n") + "\n"


def add_table(lines: list[str], table: Mapping, path: list[str]) -> None:
    """The plain values of a table under its header, then the tables in it."""
    plain = {key: value for key, value in table.items() if not isinstance(value, Mapping) and not is_list_of_tables(value)}
    if path and (plain or not table):
        lines += ["", f"[{'.'.join(path)}]"]
    lines += [f"{key_text(key, path)} = {value_text(value, [*path, str(key)], ', ')}" for key, value in plain.items()]
    for key, value in table.items():
        inner = [*path, key_text(key, path)]
        if isinstance(value, Mapping):
            add_table(lines, value, inner)
        elif is_list_of_tables(value):
            for entry in value:
                lines += ["", f"[[{'.'.join(inner)}]]"]
                lines += [f"{key_text(k, inner)} = {value_text(v, [*inner, str(k)], ', ')}" for k, v in entry.items()]


def is_list_of_tables(value) -> bool:
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(entry, Mapping) for entry in value)


def key_text(key, path: list[str]) -> str:
    if not isinstance(key, str):
        raise RunError(f"the scene's key {key!r} in '{'.'.join(path)}' must be text")
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else string_text(key)


def value_text(value, path: list[str], comma: str = ",") -> str:
    """One value on one line; with commas alone there are no blanks outside strings. Paths of files become absolute."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return number_text(float(value))
    if isinstance(value, (str, os.PathLike)):
        text = os.fspath(value)
        is_path = path[-1] in FILE_KEYS and not text.startswith("builtin:")
        return string_text(str(pathlib.Path(text).absolute()) if is_path else text)
    if isinstance(value, Mapping):
        inside = (f"{key_text(k, path)}={value_text(v, [*path, str(k)], comma)}" for k, v in value.items())
        return "{" + comma.join(inside) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + comma.join(value_text(entry, path, comma) for entry in value) + "]"
    raise RunError(f"'{'.'.join(path)}' is {value!r}; it must be a number, text, boolean, list or dictionary")


def number_text(value: float) -> str:
    """All digits, and a point or exponent; nan and inf as TOML has them, which the program refuses with its sentence."""
    return repr(value) if math.isfinite(value) else str(value)


def string_text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def set_words(sets: Mapping | None) -> list[str]:
    """What follows each `--set`, KEY=VALUE. Raises RunError."""
    if sets is None:
        return []
    if not isinstance(sets, Mapping):
        raise RunError(f"'sets' is {sets!r} and must be a dictionary of keys such as 'materials.cream.yield_stress'")
    for key in sets:
        if not isinstance(key, str) or not re.fullmatch(r"[^\s=#]+", key):
            raise RunError(f"the key {key!r} must be a path of a key, such as 'materials.cream.yield_stress'")
    return [f"{key}={value_text(value, key.split('.'))}" for key, value in sets.items()]
