"""A small scene for tests of the program."""

from pathlib import Path

SPHERES = """\
b 0.2 0.3 0.4
v
from 0 0.5 5
at 0 0 0
up 0 1 0
angle 40
hither 0.01
resolution 64 48
l 3 4 5
f 0.9 0.4 0.2 0.7 0.3 20 0 1
s 0 0 0 0.9
f 0.2 0.5 0.9 0.6 0.4 40 0 1
s 1.2 0.4 0.3 0.5
s -1.2 0.4 -0.3 0.5
"""


def write_spheres(path: Path, size: tuple[int, int] = (64, 48)) -> Path:
    """Writes the scene at a size in pixels; gives the path back."""
    path.write_text(SPHERES.replace("resolution 64 48", f"resolution {size[0]} {size[1]}"))
    return path
