#!/usr/bin/env python3
"""All XDMF files of a run keep to the forms that VisIt documents and both of ParaView's readers understand
(docs/convert.md), and every array that they name is in its file with that type and shape."""

import pathlib
import sys
import xml.etree.ElementTree as ElementTree

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from bulkley_program import parse_arguments, start  # noqa: E402
from sample_run import expect, make_run  # noqa: E402

TYPES = {"float32": ("Float", "4"), "float64": ("Float", "8"), "int32": ("Int", "4"), "int64": ("Int", "8"),
         "uint8": ("UChar", "1")}
ELEMENTS = {"Xdmf", "Domain", "Grid", "Time", "Topology", "Geometry", "Attribute", "DataItem"}
COMPONENTS = {"Scalar": 1, "Vector": 3, "Tensor": 9, "Matrix": 6}  # VisIt does not document Matrix


def check_item(item, folder, what):
    """Returns the shape."""
    shape = [int(word) for word in item.get("Dimensions").split()]
    if item.get("Format") == "XML":
        expect(len(item.text.split()) == shape[0], f"{what}: numbers in the XML")
        return shape
    file, _, path = item.text.strip().partition(":")
    expect(item.get("Format") == "HDF" and "/" not in file and path.startswith("/"), f"{what}: '{item.text}'")
    with h5py.File(folder / file) as data:
        array = data[path]
        expect(list(array.shape) == shape, f"{what}: {path} is {array.shape}, not {shape}")
        expect((item.get("NumberType"), item.get("Precision")) == TYPES[array.dtype.name], f"{what}: the type of {path}")
    return shape


def check_uniform(grid, folder, what):
    expect([len(grid.findall(part)) for part in ("Time", "Topology", "Geometry")] == [1, 1, 1], f"{what}: parts")
    topology, geometry = grid.find("Topology"), grid.find("Geometry")
    kind = topology.get("TopologyType")
    items = [check_item(item, folder, what) for item in geometry]
    if kind == "3DCoRectMesh":
        nodes = [int(word) for word in topology.get("Dimensions").split()]
        expect(geometry.get("GeometryType") == "ORIGIN_DXDYDZ" and len(items) == 2, f"{what}: geometry")
        entries = {"Node": nodes, "Cell": [n - 1 for n in nodes]}
    else:
        connectivity = check_item(topology.find("DataItem"), folder, what)
        n = int(topology.get("NumberOfElements"))
        expect(kind in ("Polyvertex", "Triangle") and geometry.get("GeometryType") == "XYZ", f"{what}: {kind}")
        expect(connectivity[0] == n, f"{what}: {connectivity} connects {n} elements")
        expect(kind == "Triangle" or topology.get("NodesPerElement") == "1", f"{what}: NodesPerElement")
        entries = {"Node": items[0][:1], "Cell": [n]}
    for attribute in grid.findall("Attribute"):
        shape = check_item(attribute.find("DataItem"), folder, what)
        counted = entries[attribute.get("Center")]
        rest = 1
        for extent in shape[len(counted):]:
            rest *= extent
        name = f"{what}, {attribute.get('Name')}"
        expect(shape[:len(counted)] == counted and rest == COMPONENTS[attribute.get("AttributeType")], f"{name}: {shape}")
        expect(attribute.get("AttributeType") != "Matrix" or what.startswith("checkpoint_"), f"{name}: Matrix")


def main():
    program, work = start(parse_arguments(__doc__))
    collider = '[[colliders]]\nname = "stone"\nshape = { type = "sphere", center = [0.05, 0.05, 0.05], radius = 0.03 }\n'
    scene = pathlib.Path(__file__).resolve().with_name("sample.toml").read_text(encoding="utf-8")
    (work / "scene.toml").write_text(scene + collider, encoding="utf-8")
    run = make_run(program, work, "output.tiles=true", scene=work / "scene.toml")
    paths = sorted(run.glob("*.xdmf"))
    series = {"frames.xdmf", "grid.xdmf", "tiles.xdmf", "colliders.xdmf"}
    expect(series <= {path.name for path in paths}, f"a series is missing: {[path.name for path in paths]}")
    for path in paths:
        root = ElementTree.parse(path).getroot()
        expect(root.get("Version") == "3.0" and {e.tag for e in root.iter()} <= ELEMENTS, f"{path.name}: elements")
        (domain,) = root
        (collection,) = domain
        kind = (collection.get("GridType"), collection.get("CollectionType"))
        expect(kind == ("Collection", "Temporal"), f"{path.name}: collection")
        names = {grid.get("Name") for grid in collection}
        uniform = all(grid.get("GridType") == "Uniform" for grid in collection)
        expect(names == {collection.get("Name")} and uniform, f"{path.name}: grids")
        for grid in collection:
            check_uniform(grid, run, path.name)
    checkpoints = sorted(run.glob("checkpoint_*.h5"))
    expect(checkpoints and all(path.with_suffix(".xdmf") in paths for path in checkpoints), "a checkpoint has no XDMF file")


if __name__ == "__main__":
    main()
