"""The Python package: what it adds to the library, not what the library computes."""

from __future__ import annotations

import gc
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import feeler

VERTICES = np.array([[-1, -1, 0], [1, -1, 0], [0, 1.1, 0.3], [0.4, 0.2, 1.7]])
TRIANGLES = np.array([[0, 1, 2], [0, 1, 3], [1, 2, 3]])


def describe(mesh: dict[str, Any]) -> dict[str, Any]:
    """A small scene with a bit of everything that Python translates: numbers, bools, lists and a mesh."""
    return {
        "camera": {"eye": [0.3, 0.7, 6], "look_at": [0, 0, 0], "fov": 40},
        "image": {"size": [32, 24], "samples": 2},
        "background": [0.1, 0.2, 0.4],
        "ambient": 0.2,
        "shadows": True,
        "depth": 3,
        "lights": [{"point": [3, 4, 5]}],
        "materials": {
            "red": {"ambient": 0.5, "diffuse": [0.8, 0.1, 0.1], "specular": 0.3, "shininess": 20},
            "mirror": {"diffuse": 0.1, "reflection": 0.7},
        },
        "objects": [
            {"mesh": mesh, "material": "red"},
            {"sphere": {"centre": [1.2, 0.3, 1], "radius": 0.6}, "material": "mirror"},
        ],
    }


@pytest.fixture(scope="module")
def description() -> dict[str, Any]:
    return describe({"vertices": VERTICES.tolist(), "triangles": TRIANGLES.tolist()})


@pytest.fixture(scope="module")
def scene(description: dict[str, Any]) -> feeler.Scene:
    return feeler.Scene(description)


def same_bits(a: Any, b: Any) -> bool:
    return bool(a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes())


# ---- scenes from dicts and files


def test_a_dict_with_numpy_equals_the_yaml_file(description: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(json.dumps(description))  # JSON is YAML
    from_file = feeler.load(path).render()
    assert repr(feeler.load(path)) == f"<feeler.Scene {path}>"
    assert repr(feeler.Scene(description)) == "<feeler.Scene of a dict>"
    from_lists = feeler.Scene(description).render()
    with_arrays = describe({"vertices": VERTICES, "triangles": TRIANGLES})
    with_arrays["camera"]["eye"] = np.array([0.3, 0.7, 6])
    with_arrays["lights"] = ({"point": (3, np.float64(4), np.int32(5))},)
    with_arrays["shadows"] = np.bool_(True)
    from_arrays = feeler.Scene(with_arrays).render()
    assert from_file.pixels[..., 3].mean() > 0.1
    assert same_bits(from_file.pixels, from_lists.pixels)
    assert same_bits(from_file.pixels, from_arrays.pixels)


def test_arrays_of_any_layout_mean_the_same(scene: feeler.Scene) -> None:
    wide = np.zeros((4, 6))
    wide[:, ::2] = VERTICES
    for vertices in (wide[:, ::2], np.asfortranarray(VERTICES), VERTICES.astype(">f8")):
        other = feeler.Scene(describe({"vertices": vertices, "triangles": TRIANGLES.astype(np.uint8)}))
        assert same_bits(other.render().pixels, scene.render().pixels)


def test_none_is_an_absent_key(description: dict[str, Any], scene: feeler.Scene) -> None:
    assert same_bits(feeler.Scene({**description, "cutoff": None}).render().pixels, scene.render().pixels)


@pytest.mark.parametrize(
    ("change", "source", "text"),
    [
        ({"depht": 3}, "depht", "did you mean 'depth'"),
        ({"camera": {"fov": 200}}, "camera.fov", "200"),
        ({"lights": [{"point": [0, 0, float("nan")]}]}, "lights[0].point", ""),
        ({"objects": [{"sphere": {"radius": -1}}]}, "objects[0].sphere.radius", "-1"),
        ({"objects": [{"sphere": {"radius": 1}, "material": "gold"}]}, "objects[0].material", "gold"),
        ({"background": b"black"}, "background", "bytes"),
        ({"background": {3: 4}}, "background", "strings, not 3"),
        ({"background": 1j}, "background", "complex"),
        ({"cutoff": 10**400}, "cutoff", "large"),
        ({"materials": {"a\0b": {}}}, "", "NUL"),
    ],
)
def test_a_wrong_dict_says_where(description: dict[str, Any], change: dict[str, Any], source: str, text: str) -> None:
    with pytest.raises(feeler.Error) as caught:
        feeler.Scene({**description, **change})
    assert caught.value.kind == "bad input"
    assert caught.value.source.startswith(source)
    assert caught.value.path == caught.value.source
    assert text in str(caught.value)


def test_a_dict_that_contains_itself_is_an_error(description: dict[str, Any]) -> None:
    loop: list[Any] = []
    loop.append(loop)
    with pytest.raises(feeler.Error, match="nested"):
        feeler.Scene({**description, "objects": loop})


def test_a_wrong_file_says_line_and_column(tmp_path: Path) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text("depth: 3\nobjects:\n  - sphere: {radios: 1}\n")
    with pytest.raises(feeler.Error) as caught:
        feeler.load(path)
    assert (caught.value.line, caught.value.column) == (3, 14)
    assert caught.value.source.endswith("wrong.yaml")
    assert "did you mean 'radius'" in caught.value.text
    assert str(caught.value) == f"{caught.value.source}:3:14: {caught.value.text}"


def test_a_missing_file_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(feeler.Error, match=r"absent\.yaml") as caught:
        feeler.load(tmp_path / "absent.yaml")
    assert caught.value.kind == "io"


def test_warnings_and_info(description: dict[str, Any]) -> None:
    flat = describe({"vertices": VERTICES, "triangles": np.vstack([TRIANGLES, [[0, 0, 1]]])})
    assert len(feeler.Scene(flat).warnings) == 1
    assert feeler.Scene(description).warnings == []
    assert isinstance(feeler.Scene(description).info(level="reference"), dict)


# ---- images


def test_pixels_are_numpy_without_a_copy(scene: feeler.Scene) -> None:
    image = scene.render(size=(20, 10))
    assert image.pixels.shape == (10, 20, 4)
    assert image.pixels.dtype == np.float32
    assert image.pixels is image.pixels
    assert np.shares_memory(np.asarray(image), image.pixels)
    assert not image.pixels.flags.writeable
    assert (image.width, image.height, image.interrupted) == (20, 10, False)
    assert repr(image) == "<feeler.Image 20x10, float32>"
    assert scene.render(size=(4, 4), level="reference").pixels.dtype == np.float64


def test_pixels_outlive_image_and_scene(description: dict[str, Any]) -> None:
    scene = feeler.Scene(description)
    image = scene.render()
    expected = image.pixels.copy()
    pixels = image.pixels
    del scene
    gc.collect()
    assert image.stats
    del image
    gc.collect()
    feeler.Scene(description).render()  # would reuse freed memory
    assert same_bits(pixels, expected)


def test_region_and_alpha(scene: feeler.Scene) -> None:
    whole = scene.render(size=(32, 24))
    part = scene.render(size=(32, 24), region=(5, 3, 20, 17))
    assert same_bits(part.pixels, whole.pixels[3:17, 5:20].copy())
    clear = scene.render(size=(32, 24), alpha=True).pixels
    assert np.all(clear[clear[..., 3] == 0] == 0)
    assert np.all(clear[..., 3] == whole.pixels[..., 3])


def test_stats_count_the_rays(scene: feeler.Scene) -> None:
    stats = scene.render(size=(16, 8), samples=3).stats
    assert stats["rays"]["eye"] == 16 * 8 * 3
    assert stats["seconds"]["total"] > 0


@pytest.mark.parametrize(
    ("name", "bits"), [("a.png", None), ("a.png", 16), ("a.tif", 8), ("a.exr", None), ("a.hdr", None)]
)
def test_save(scene: feeler.Scene, tmp_path: Path, name: str, bits: int | None) -> None:
    scene.render().save(tmp_path / name, bits=bits)
    assert (tmp_path / name).stat().st_size > 100
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_an_image_shows_itself_in_a_notebook(scene: feeler.Scene) -> None:
    assert scene.render()._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize(("name", "alpha"), [("a.xyz", None), ("a.jpg", True), ("no/folder/a.png", None), (".", None)])
def test_what_cannot_be_saved_is_an_error(scene: feeler.Scene, tmp_path: Path, name: str, alpha: bool | None) -> None:
    image = scene.render(size=(4, 4))
    with pytest.raises(feeler.Error):
        image.save(tmp_path / name, alpha=alpha)
    with pytest.raises(feeler.Error, match="bits"):
        image.save(tmp_path / "a.png", bits=12)
    assert list(tmp_path.iterdir()) == []


# ---- settings and devices


@pytest.mark.parametrize(
    "settings",
    [
        {"size": (0, 0)}, {"size": (4,)}, {"size": 4}, {"size": (4.5, 4)}, {"size": (1 << 40, 4)}, {"samples": 0},
        {"samples": "4"}, {"jitter": -1}, {"jitter": float("nan")}, {"jitter": 2.0}, {"depth": 0}, {"cutoff": 1.5},
        {"level": "best"}, {"region": (3, 3, 3, 5)}, {"region": (0, 0, 0, 0)}, {"region": (0, 0, 99, 99)},
        {"lanes": 3}, {"work_group": (0, 1)}, {"pixels": (3, 1)}, {"pixels": (65536, 65536)},
        {"device": "no such device"}, {"device": 99},
    ],
)  # fmt: skip
def test_wrong_settings_are_errors(scene: feeler.Scene, settings: dict[str, Any]) -> None:
    with pytest.raises(feeler.Error):
        scene.render(**settings)


def test_a_given_queue_gives_the_same_bits(scene: feeler.Scene, queue: Any) -> None:
    expected = scene.render().pixels
    for _ in range(3):
        assert same_bits(scene.render(queue=queue).pixels, expected)
    with pytest.raises(feeler.Error, match="not both"):
        scene.render(queue=queue, device=0)


def test_settings_that_never_change_the_picture(scene: feeler.Scene) -> None:
    expected = scene.render().pixels
    for settings in ({"work_group": (4, 2)}, {"tile": 50}, {"general": True}, {"brute_force": True}, {"device": 0}):
        assert same_bits(scene.render(**settings).pixels, expected), settings


def test_devices_and_kernels(scene: feeler.Scene) -> None:
    default = [device for device in feeler.devices() if device["default"]]
    assert len(default) == 1
    assert default[0]["name"]
    assert default[0]["platform"]
    assert "#line 1" in feeler.kernel_source()
    assert "DOUBLE" in feeler.kernel_options(level="reference")
    assert scene.kernel_options() != feeler.kernel_options()


def test_threads_may_share_scene_and_device(scene: feeler.Scene) -> None:
    expected = scene.render().pixels
    found: list[Any] = []
    threads = [threading.Thread(target=lambda: found.append(scene.render().pixels)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4
    assert all(same_bits(pixels, expected) for pixels in found)


# ---- stopping


def test_progress_rises_and_can_stop(scene: feeler.Scene) -> None:
    seen: list[float] = []
    image = scene.render(size=(64, 64), tile=256, progress=seen.append)
    assert seen == sorted(seen)
    assert 0 <= seen[0] <= seen[-1] <= 1
    assert not image.interrupted
    stopped = scene.render(size=(64, 64), tile=256, progress=lambda done: done > 0.4)
    assert stopped.interrupted
    assert "interrupted" in repr(stopped)
    finished = stopped.pixels[..., :3].sum(axis=2) > 0
    assert 0 < finished.mean() < 1
    assert np.array_equal(stopped.pixels[finished], image.pixels[finished])


def test_a_stop_before_anything_is_compiled(scene: feeler.Scene) -> None:
    seen: list[float] = []
    image = scene.render(size=(64, 64), progress=lambda done: not seen.append(done))
    assert seen == [0]
    assert image.interrupted
    assert not image.pixels.any()
    assert image.stats["seconds"]["compile"] == 0


def test_what_a_progress_function_raises_comes_out(scene: feeler.Scene) -> None:
    def fail(_done: float) -> None:
        raise ValueError("enough")

    with pytest.raises(ValueError, match="enough") as caught:
        scene.render(size=(64, 64), tile=256, progress=fail)
    assert caught.value.image.interrupted  # type: ignore[attr-defined]


def test_keyboard_interrupt_stops_at_once(scene: feeler.Scene) -> None:
    scene.render(size=(8, 8), samples=16)  # compiled
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background ignores it
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    begin = time.monotonic()
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt) as caught:
            scene.render(size=(8000, 8000), samples=16)
    finally:
        timer.cancel()
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - begin < 5
    assert caught.value.image.interrupted  # type: ignore[attr-defined]


def test_a_bar_is_shown_on_stderr(scene: feeler.Scene, capfd: pytest.CaptureFixture[str]) -> None:
    scene.render(progress=True)
    out, err = capfd.readouterr()
    assert "render" in err
    assert out == ""


# ---- the package


def test_objects_free_themselves(description: dict[str, Any]) -> None:
    resource = pytest.importorskip("resource")

    def render_many() -> int:
        for _ in range(8):
            feeler.Scene(description).render(size=(800, 800), samples=1, depth=1).pixels.sum()
        gc.collect()
        return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)

    render_many()
    first = render_many()
    assert render_many() - first < 40_000  # KiB; 8 lost images would be 80 000


def test_help_reads_like_a_manual() -> None:
    code = "import feeler; help(feeler)"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    for words in ("render(", "pixels", "probe(", "devices(", "right-handed"):
        assert words in shown
    for name in feeler.__all__:
        assert getattr(feeler, name).__doc__, name


def test_the_library_may_be_elsewhere_and_its_absence_is_clear(tmp_path: Path) -> None:
    environment = {**os.environ, "FEELER_LIBRARY": str(tmp_path)}
    result = subprocess.run(
        [sys.executable, "-c", "import feeler"], env=environment, capture_output=True, text=True, check=False
    )
    assert result.returncode == 1
    assert "run `make`" in result.stderr


def test_what_is_no_number_and_no_queue_is_told() -> None:
    with pytest.raises(feeler.Error, match=r"^depth: expected a number, not true$"):
        feeler.Scene({"depth": True})
    with pytest.raises(feeler.Error, match="CommandQueue, not 3"):
        feeler.Scene({}).render(queue=3)
