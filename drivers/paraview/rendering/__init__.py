"""The parts of render.py."""
