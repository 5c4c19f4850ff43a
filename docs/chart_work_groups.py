#!/usr/bin/env python3
"""Measures work groups on PoCL and on Intel's CPU runtime, and draws them side by side.

    chart_work_groups.py FEELER FOLDER INTEL SCENE…

FEELER is the program. INTEL is where the PyPI packages intel-opencl-rt and intel-cmplr-lib-rt were installed (pip's
--prefix); without it there PoCL is measured alone. For each scene FOLDER gets NAME-pocl.json, NAME-intel.json and the
chart work-groups-NAME, as PNG and SVG. `make chart-work-groups` runs this.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from feeler import charts

# A grid, so that the map shows where it is flat; and the default of most kernels.
SIZES = [f"{x}x{y}" for y in (1, 4, 16) for x in (1, 4, 16, 64)] + ["8x8"]
SWEEP = ["--size", "96x72", "--repeat", "5", "--work-groups", ",".join(SIZES)]


def find_runtimes(intel: Path, folder: Path) -> dict[str, tuple[str, dict[str, str]]]:
    """What to choose as the device, and the environment to do so, by the runtime's name."""
    runtimes = {"pocl": ("Portable Computing Language", dict(os.environ))}
    driver = intel / "lib" / "libintelocl.so"
    if not driver.is_file():
        print(f"there is no {driver}: PoCL is measured alone", file=sys.stderr)
        return runtimes
    vendors = folder / "intel-vendors"
    vendors.mkdir(exist_ok=True)
    (vendors / "intel.icd").write_text(f"{driver.resolve()}\n")
    # Its libraries first: it needs a newer TBB than the system's.
    libraries = ":".join(filter(None, [str(driver.resolve().parent), os.environ.get("LD_LIBRARY_PATH")]))
    own = {"OCL_ICD_VENDORS": f"{vendors.resolve()}/", "LD_LIBRARY_PATH": libraries}
    return runtimes | {"intel": ("Intel(R) OpenCL", {**os.environ, **own})}


def main() -> None:
    program, folder, intel, *scenes = map(Path, sys.argv[1:])
    folder.mkdir(parents=True, exist_ok=True)
    runtimes = find_runtimes(intel, folder)
    for scene in scenes:
        files = []
        for name, (device, environment) in runtimes.items():
            files.append(folder / f"{scene.stem}-{name}.json")
            command = [program, "bench", scene, *SWEEP, "--device", device, "--json", files[-1]]
            print(*command, flush=True)
            subprocess.run(command, env=environment, check=True)
        charts.work_groups(files, save=folder / f"work-groups-{scene.stem}")


if __name__ == "__main__":
    main()
