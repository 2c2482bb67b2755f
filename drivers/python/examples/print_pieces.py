#!/usr/bin/env python3
"""Writes G-code that prints a hollow cylinder or a wall: a bead of width times layer height along every layer.

    python3 print_pieces.py cylinder --radius 40 --height 30 --bead 12 --layer 6 --speed 80 > cylinder.gcode
    python3 -m bulkley gcode cylinder.gcode --volume --out cylinder.csv --plot cylinder.png

E is the volume in mm^3 (`--volume`). The nozzle's exit is one layer height above the bead below; between layers it rises
while it extrudes nothing. Lengths in mm, speed in mm/s; the piece is centred on x = y = 0 and stands on z = 0.
"""

import argparse


def cylinder(radius, speed, bead, layer, n_layers):
    """Every layer is a full circle that begins where the one before ended."""
    volume = bead * layer * 2.0 * 3.141592653589793 * radius
    lines = [f"G0 X{radius:g} Y0 Z{layer:g} F{60.0 * speed:g}"]
    for k in range(1, n_layers + 1):
        lines += [f"G0 Z{k * layer:g}", f"G3 I{-radius:g} J0 E{volume:.6f}"]
    return lines


def wall(length, speed, bead, layer, n_layers):
    """Layers go to and fro along x."""
    volume, side = bead * layer * length, -1
    lines = [f"G0 X{-0.5 * length:g} Y0 Z{layer:g} F{60.0 * speed:g}"]
    for k in range(1, n_layers + 1):
        side = -side
        lines += [f"G0 Z{k * layer:g}", f"G1 X{0.5 * side * length:g} E{volume:.6f}"]
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("piece", choices=("cylinder", "wall"))
    parser.add_argument("--radius", type=float, default=40.0, help="of the circle that the head follows; default: %(default)s")
    parser.add_argument("--length", type=float, default=120.0, help="of the wall; default: %(default)s")
    parser.add_argument("--height", type=float, default=30.0, help="rounded to full layers; default: %(default)s")
    parser.add_argument("--bead", type=float, default=12.0, help="its width; default: %(default)s")
    parser.add_argument("--layer", type=float, default=6.0, help="its height; default: %(default)s")
    parser.add_argument("--speed", type=float, default=80.0, help="default: %(default)s")
    options = parser.parse_args()
    n_layers = max(1, round(options.height / options.layer))
    make, size = (cylinder, options.radius) if options.piece == "cylinder" else (wall, options.length)
    print(f"; {options.piece}: {n_layers} layers of {options.layer:g} mm, bead {options.bead:g} mm wide")
    print("G21\nG90\nM83")
    print("\n".join(make(size, options.speed, options.bead, options.layer, n_layers)))


if __name__ == "__main__":
    main()
