"""Builds libfeeler with make and ships it, with the header that cffi reads, inside the package.

An editable install ships nothing: the package then finds the checkout's own build folder.
"""

import shutil
import subprocess
from pathlib import Path

from setuptools import setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py

SHIPPED = ("libfeeler.so", "libfeeler-image.so", "feeler_cdef.h")


class BuildWithLibrary(build_py):
    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return
        subprocess.run(["make", *(f"build/{name}" for name in SHIPPED)], cwd=Path(__file__).parent, check=True)
        for name in SHIPPED:
            shutil.copy2(Path(__file__).parent / "build" / name, Path(self.build_lib) / "feeler" / name)


class PlatformWheel(bdist_wheel):
    """The library is the platform's, but no extension module: any Python 3 may use it."""

    def finalize_options(self) -> None:
        super().finalize_options()
        self.root_is_pure = False

    def get_tag(self) -> tuple[str, str, str]:
        return "py3", "none", super().get_tag()[2]


setup(
    cmdclass={"build_py": BuildWithLibrary, "bdist_wheel": PlatformWheel},
    options={"build": {"build_base": "build/python"}},
)
