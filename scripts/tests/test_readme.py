"""The documents: what they show exists, what they link to is there, and the examples do what they say."""

import itertools
import math
import os
import re
import subprocess
import tomllib
from collections.abc import Callable
from fnmatch import fnmatch
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from taut.document.reference import DOCUMENTS as DOCUMENTS_OF_ENTRIES
from taut.document.reference import renewed
from taut.programs import release

ROOT = Path(__file__).parents[2]
DOCUMENTS = sorted(
    path
    for path in ROOT.rglob("*.md")
    if not re.search(r"^(build|results)/|(^|/)\.", path.relative_to(ROOT).as_posix())
)
EXAMPLES = {
    example["name"]: ROOT / example["source-dir"] / example["main"]
    for example in tomllib.loads((ROOT / "fpm.toml").read_text(encoding="utf-8"))["example"]
    if example["source-dir"] == "cases/examples"  # the benchmark's program is none
}
each = pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))


def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def prose(path: Path) -> str:
    """Returns a document without its blocks of code."""
    return re.sub(r"(?ms)^```.*?^```$|^    .*?$", "", path.read_text(encoding="utf-8"))


def anchors(path: Path) -> set[str]:
    """Returns the anchors of a document's headings, made as GitHub makes them."""
    titles = re.findall(r"(?m)^#+ (.*)$", prose(path))
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@each
def test_links_lead_somewhere(path: Path) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", prose(path)):
        if re.match(r"\w+:", link):
            continue
        name, _, anchor = link.partition("#")
        target = (path.parent / name).resolve() if name else path
        assert target.exists(), f"{link}: there is no such file"
        if anchor:
            assert anchor in anchors(target), f"{link}: there is no such heading"


def test_front_page_is_short() -> None:
    assert (ROOT / "README.md").stat().st_size <= 12_000


def test_front_page_leads_to_every_document() -> None:
    reached, ahead = set(), [ROOT / "README.md"]
    while ahead:
        path = ahead.pop()
        if path in reached:
            continue
        reached.add(path)
        links = re.findall(r"\]\(([^)#\s]+\.md)[^)]*\)", prose(path))
        ahead += [(path.parent / link).resolve() for link in links]
    assert set(DOCUMENTS) <= reached


def test_readme_names_every_case() -> None:
    # A family is named by a pattern such as `mesh*`.
    named = re.findall(r"`(\w[\w*]*)`", text_of("README.md"))
    for case in (ROOT / "cases").glob("*/*.nml"):
        assert any(fnmatch(case.stem, name) for name in named), (
            f"{case.name} is missing in the table of cases"
        )


ROOMS = "linalg|ode|constrained|model|case"


def places() -> list[tuple[str, str]]:
    """Returns the files that the map of the library names, each with a procedure that is said to be in it."""
    found = []
    named = rf"`((?:{ROOMS})(?:/\w+)+)(?:\.f90)?`(?:: ((?:`\w+`(?:, )?)+))?"
    for path, words in re.findall(named, text_of("src/README.md")):
        found += [(path, word) for word in re.findall(r"\w+", words) or [""]]
    return sorted(set(found))


@pytest.mark.parametrize(("path", "procedure"), places())
def test_map_of_the_library(path: str, procedure: str) -> None:
    file = ROOT / f"src/taut/{path}.f90"
    assert file.is_file() or file.with_suffix("").is_dir()
    if procedure:
        text = file.read_text(encoding="utf-8")
        assert re.search(rf"(?m)^.*(subroutine|function|procedure|::)\b.*\b{procedure}\b", text)


def test_fortran_of_the_readme_is_a_whole_program() -> None:
    [block] = re.findall(r"```fortran\n(.*?)```", text_of("README.md"), re.DOTALL)
    comment, program = EXAMPLES["double_pendulum"].read_text(encoding="utf-8").split("\n", 1)
    assert comment.startswith("!>")
    assert block == program


@pytest.mark.parametrize("path", EXAMPLES.values(), ids=EXAMPLES)
def test_examples_know_public_names_alone(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    own = re.findall(r"(?m)^module (\w+)", text)
    assert set(re.findall(r"(?m)^ *use (?:, *intrinsic *:: *)?(\w+)", text)) <= {
        "taut",
        "iso_c_binding",
        "iso_fortran_env",
        *own,
    }


def test_every_example_is_built_and_listed() -> None:
    folder = ROOT / "cases/examples"
    assert set(EXAMPLES.values()) == set(folder.glob("*.f90"))
    listed = re.findall(r"(?m)^\| \[(\w+)\]\((\w+\.f90)\)", text_of("cases/examples/README.md"))
    assert {name: folder / file for name, file in listed} == EXAMPLES


@pytest.mark.parametrize("path", DOCUMENTS_OF_ENTRIES, ids=str)
def test_references_are_what_the_apps_say(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert "<!-- reference: " in text
    assert renewed(text) == text, "run scripts/reference"


def said_by(*command: str | Path, folder: Path = ROOT) -> str:
    ran = subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        timeout=600,
        check=False,
    )
    assert ran.returncode == 0, (ran.stdout + ran.stderr)[-2000:]
    return ran.stdout


def test_bead_runs_from_outside_the_library(tmp_path: Path) -> None:
    # A user's own fpm project that knows taut by its path alone.
    (tmp_path / "app").mkdir()
    (tmp_path / "app/main.f90").write_text(EXAMPLES["bead"].read_text(encoding="utf-8"), encoding="utf-8")
    path = os.path.relpath(ROOT, tmp_path)  # fpm takes relative paths alone
    (tmp_path / "fpm.toml").write_text(
        f'name = "wire"\n[build]\nlink = ["lapack", "blas"]\n[dependencies]\ntaut = {{ path = "{path}" }}\n',
        encoding="utf-8",
    )
    output = said_by("fpm", "run", "--flag", "-g", folder=tmp_path)
    said = [line for line in output.splitlines() if "phi =" in line][-1]
    assert said.startswith("reached-end")
    assert abs(float(said.split("=")[1])) <= 1e-12
    # Without drag the height of its energy stays z + v^2/2g.
    assert float(output.split()[-1]) == pytest.approx(1.0 + 0.05 / (2 * 9.81), abs=3e-6)


@pytest.fixture(scope="module")
def said() -> Callable[[str], list[str]]:
    def lines(name: str) -> list[str]:
        return said_by(release(name)).splitlines()

    return lines


def pairs(lines: list[str], beginning: str) -> tuple[float, float]:
    """Returns the two numbers at the end of a line: what was computed, and its closed form."""
    [line] = [line for line in lines if line.startswith(beginning)]
    computed, closed = line.split()[-2:]
    return float(computed), float(closed)


@pytest.mark.parametrize(
    ("name", "beginning", "closed", "tolerance"),
    [
        ("turning_tube", "reached-end, radius", 0.5 * math.cos(15.0), 2e-8),
        ("sleigh", "reached-end, how far", 0.5 * 9.81 / (2 * 1.5**2) * math.sin(7.5) ** 2, 2e-8),
        ("large", "reached-end, force", 0.1 * 0.01 * 1000 * 1001 / 2, 1e-5),
        ("wind", "reached-end, rate", 0.774049, 1e-6),
        ("actuator", "reached-end, x", 0.8 * (1.0 - 0.25 * (1 - math.exp(-4.0))), 2e-8),
        ("actuator", "reached-end, w", math.exp(-4.0), 2e-8),
        ("events", "time", math.gamma(0.25) ** 2 / (4 * math.sqrt(math.pi * 9.81)), 2e-6),
        ("events", "tension", 3 * 9.81, 2e-6),
    ],
)
def test_examples_meet_closed_forms(
    said: Callable[[str], list[str]], name: str, beginning: str, closed: float, tolerance: float
) -> None:
    computed, printed = pairs(said(name), beginning)
    assert printed == pytest.approx(closed, abs=1e-6)
    assert computed == pytest.approx(closed, abs=tolerance)


def test_example_of_shapes_leaves_half_of_what_they_cannot_meet(said: Callable[[str], list[str]]) -> None:
    alike, apart = (line.split() for line in said("shapes")[-2:])
    assert alike[1:3] == apart[1:3] == ["2", "1"]
    assert float(alike[3]) <= 1e-12
    assert float(apart[3]) == pytest.approx(0.5 * float(apart[0]), rel=1e-6)


def test_example_of_a_chain_keeps_its_energy(said: Callable[[str], list[str]]) -> None:
    lines = [line for line in said("hanging_chain") if "reached-end" in line]
    assert [line.split()[0] for line in lines] == ["5", "20"]
    assert all(abs(float(line.split()[-1])) < 1e-4 for line in lines)
    assert all(float(line.split("phi ")[1].split(",")[0]) <= 1e-12 for line in lines)


def test_example_of_an_arm_has_the_smallest_rates(said: Callable[[str], list[str]]) -> None:
    def rates(t: float, q: np.ndarray) -> np.ndarray:
        a = 0.3 * np.array([-np.sin(q), np.cos(q)])
        return np.linalg.pinv(a) @ np.array([-0.2 * np.sin(t), 0.2 * np.cos(t)])

    turns = [line for line in said("inverse_kinematics") if line.startswith("reached-end")]
    angles = [np.array([float(word) for word in line.split()[-5:]]) for line in turns]
    assert len(angles) == 3
    # From where one turn ends to where the next one does: the smallest rates do not lead back.
    for begin, end in itertools.pairwise(angles):
        found = solve_ivp(rates, (0.0, 2 * math.pi), begin, rtol=1e-10, atol=1e-12)
        assert end == pytest.approx(found.y[:, -1], abs=5e-4)
        assert np.abs(end - begin).max() > 0.05


def test_example_of_a_body_that_leaves_a_sphere(said: Callable[[str], list[str]]) -> None:
    without, ground, rough, _ = [line for line in said("leaving") if "friction" in line or "ground" in line]
    computed, closed = float(without.split()[6].rstrip(",")), float(without.split()[-1])
    assert closed == pytest.approx(2 / 3 + 1 / (3 * 9.81), abs=1e-6)
    assert computed == pytest.approx(closed, abs=1e-6)
    # From there as a stone flies: height h, speed v^2 = 1 + 2 g (1 - h), along the tangent.
    h, v2 = closed, 1 + 2 * 9.81 * (1 - closed)
    down = math.sqrt(v2) * math.sqrt(1 - h**2)
    seconds = (math.sqrt(down**2 + 2 * 9.81 * h) - down) / 9.81
    far = math.sqrt(1 - h**2) + math.sqrt(v2) * h * seconds
    assert float(ground.split()[4]) == pytest.approx(far, abs=2e-6)
    # Friction takes speed, so that it leaves lower down.
    assert float(rough.split()[6].rstrip(",")) < computed - 0.01


def test_example_of_the_builder_swings_as_two_angles_do(said: Callable[[str], list[str]]) -> None:
    energy, center = said("double_pendulum")[-2:]
    assert "0 at the start" in energy
    assert abs(float(energy.split()[-2])) < 1e-4
    # Thin rods in their two angles, by SciPy's DOP853 at 1e-12.
    assert [float(word) for word in center.split()[-3:-1]] == pytest.approx([-1.29846, -0.69831], abs=5e-5)


def test_example_of_a_checkpoint_goes_on_bit_for_bit(said: Callable[[str], list[str]]) -> None:
    before, after = said("checkpoint")[-2:]
    assert before.startswith("interrupted at") and after.startswith("reached-end at")
    assert float(after.split()[-1]) == 0.0
