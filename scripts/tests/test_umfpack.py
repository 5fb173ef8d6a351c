"""UMFPACK, looked up at run time: it factorizes what a band is too wide for; where it is not, bands do."""

import csv
import ctypes.util
import os
import subprocess
from pathlib import Path

import pytest
from debian import NoPackageError, install, nothing_to_test

from taut.programs import release

NAMES = ("libumfpack.so.5", "libumfpack.so.6", "libumfpack.so")
SIDE = 60
K = "stiffness = 1e6"


def need_umfpack() -> None:
    if ctypes.util.find_library("umfpack"):
        return
    try:
        if not os.environ.get("CI"):
            raise NoPackageError("UMFPACK is not installed (Debian: libumfpack5 or libumfpack6)")
        try:
            install("libumfpack5")
        except NoPackageError:
            install("libumfpack6")
    except NoPackageError as why:
        nothing_to_test(why)


def net() -> str:
    """Returns a case of masses in a square, each on springs to its neighbors; the middle one is struck."""
    lines = ["&mechanism planar = .true. /"]
    middle = SIDE // 2
    for i in range(SIDE):
        for j in range(SIDE):
            struck = ", velocity = 0.1, 0.0" * (i == j == middle)
            lines.append(
                f'&point_mass name = "p{i}_{j}", mass = 1.0, position = {0.1 * i}, {0.1 * j}{struck} /'
            )
    for i in range(SIDE):
        for j in range(SIDE):
            lines += [
                f'&spring name = "{k}{i}_{j}", body_1 = "p{i}_{j}", body_2 = "p{i + k}_{j + 1 - k}", {K} /'
                for k in (0, 1)
                if i + k < SIDE and j + 1 - k < SIDE
            ]
    lines.append('&integration t_end = 0.02, rtol = 1e-4, atol = 1e-6, integrator = "radau" /')
    lines.append(f'&output dt = 0.01, columns = "p{middle}_{middle}.*" /')
    return "\n".join(lines) + "\n"


def ran(folder: Path, libraries: str) -> list[list[float]]:
    folder.mkdir()
    (folder / "net.nml").write_text(net(), encoding="utf-8")
    subprocess.run(
        [release("mechanism"), "net.nml", "--quiet"],
        cwd=folder,
        env=os.environ | {"LD_LIBRARY_PATH": libraries},
        check=True,
        timeout=300,
    )
    with (folder / "results/net/present.csv").open(encoding="utf-8") as file:
        return [[float(value) for value in row] for row in list(csv.reader(file))[1:]]


def test_without_it_a_band_that_is_too_wide_is_refused(tmp_path: Path) -> None:
    for name in NAMES:
        (tmp_path / name).write_text("no library\n", encoding="utf-8")
    # All on springs to one: whatever the order, the band is wide.
    number = 12_000
    (tmp_path / "star.nml").write_text(
        f"""&mechanism planar = .true. /
&point_mass name = "hub", mass = 1.0, position = 0.0, 0.0 /
&point_mass name = "p#", mass = 1.0, position = 1.0, 0.0, position_step = 0.1, 0.0, repeat = {number} /
&spring name = "s#", body_1 = "hub", body_2 = "p#", {K}, repeat = {number} /
&integration t_end = 0.02, rtol = 1e-4, atol = 1e-6, integrator = "radau" /
&output dt = 0.01, columns = "hub.*" /
""",
        encoding="utf-8",
    )
    run = subprocess.run(
        [release("mechanism"), "star.nml", "--quiet"],
        cwd=tmp_path,
        env=os.environ | {"LD_LIBRARY_PATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert run.returncode == 1
    assert run.stderr.startswith("star present: integration: the factors of 24002 equations")
    assert "libumfpack" in run.stderr


def test_a_wide_net_moves_as_it_does_by_bands(tmp_path: Path) -> None:
    need_umfpack()
    for name in NAMES:
        (tmp_path / name).write_text("no library\n", encoding="utf-8")
    by_bands = ran(tmp_path / "bands", str(tmp_path))
    by_umfpack = ran(tmp_path / "umfpack", os.environ.get("LD_LIBRARY_PATH", ""))
    assert len(by_bands) == 3
    for one, other in zip(by_umfpack, by_bands, strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-11)
    # Another order of the pivots has other last digits.
    assert by_umfpack != by_bands
