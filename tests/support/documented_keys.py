"""Which keys of the JSON of `bulkley bench` its documentation leaves out."""

import pathlib

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "performance.md"


def keys_of(value):
    if isinstance(value, dict):
        for key, inner in value.items():
            yield key
            yield from keys_of(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from keys_of(inner)


def undocumented(value):
    """Keys, at any depth, that are not code on the page; in alphabetical order."""
    text = PAGE.read_text(encoding="utf-8")
    return sorted({key for key in keys_of(value) if f"`{key}`" not in text})
