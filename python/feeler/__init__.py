"""feeler, a Whitted ray tracer on OpenCL.

    import feeler

    scene = feeler.load("scenes/first.yaml")
    image = scene.render(size=(640, 480), samples=4)
    image.save("first.png")

`scene` may come from a file (`feeler.load`) or from a dict of the same structure, with numpy arrays where they fit:

    scene = feeler.Scene({
        "camera": {"eye": [0, 0, 5], "look_at": [0, 0, 0]},
        "lights": [{"point": [3, 4, 5]}],
        "materials": {"red": {"diffuse": [0.8, 0.1, 0.1]}},
        "objects": [{"sphere": {"radius": 1}, "material": "red"}],
    })

`image.pixels` is a numpy array of the shape (height, width, 4): linear red, green, blue and associated alpha, row 0 at
the top, float32 (float64 at level "reference"). `image.stats` counts the rays and the seconds. In a notebook an image
shows itself.

It renders on the first CPU device by default. `feeler.devices()` lists others, and `scene.render(queue=queue)` takes a
pyopencl queue. `feeler.probe("function", ...)` runs one function of the kernels over arrays.
`print(scene.pixel(x, y))` tells all that the rays of one pixel do.
`feeler.compare(a, b)` measures how far two pictures are apart, be they images, arrays or files.
`feeler.charts`, a module that needs matplotlib, draws what the program's `feeler bench` and `feeler chart` measured;
`feeler.sweep` and `feeler.specialisation` are what the latter measures with.

Coordinates are right-handed, in the scene's own unit of length; angles are degrees; colours are linear RGB. Whatever
goes wrong is a `feeler.Error`, which says where: file, line and column, or the path of a dict's key.
"""

from importlib import import_module
from types import ModuleType

from ._device import devices, kernel_options, kernel_source
from ._library import Error, lib, to_string
from .compare import Difference, compare
from .image import Image
from .pixel import Pixel
from .probe import probe
from .scene import Scene, Verification, load

__version__: str = to_string(lib.feeler_version())


def __getattr__(name: str) -> ModuleType:
    """What measures and draws is loaded when it is first asked for: matplotlib is needed by nothing else."""
    if name in ("accuracy", "charts", "specialisation", "sweep"):
        return import_module(f"feeler.{name}")
    raise AttributeError(f"module 'feeler' has no attribute '{name}'")


__all__ = [
    "Difference", "Error", "Image", "Pixel", "Scene", "Verification", "compare", "devices", "kernel_options",
    "kernel_source", "load", "probe",
]  # fmt: skip
