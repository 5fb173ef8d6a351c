"""Sweep files: what they mean, and one line for each way to get them wrong."""

import math
from pathlib import Path

import f90nml
import pytest

from taut.errors import TautError
from taut.sweep import sweep_file
from taut.sweep.plan import Plan

ROOT = Path(__file__).parents[2]

CASE = """! A comment.
&swing
   model = "beam"              ! text
   force = 2.0, 0.0, 0.0
   times(2) = 0.128
   planar = .true.
   elements = 4
/
&integration rtol = 1d-3 /
&method name = "present" /
&method name = "baumgarte", label = "soft", alpha = 2.0 /
"""

START = 'case = "base.nml"\napp = "swing"\n'
ONE = '[[parameter]]\nentry = "integration.rtol"\n'


def load(folder: Path, text: str, case: str = CASE) -> sweep_file.Sweep:
    (folder / "base.nml").write_text(case)
    path = folder / "sweep.toml"
    path.write_text(START + text)
    return sweep_file.read(path)


def values(folder: Path, kind: str) -> list[object]:
    (parameter,) = load(folder, ONE + kind).parameters
    return [row[0] for row in parameter.rows]


def cases(folder: Path, text: str, case: str = CASE) -> list[f90nml.Namelist]:
    plan = Plan(load(folder, text, case), "taut")
    return [f90nml.reads(plan.text(run)) for run in plan.runs]


def test_ranges_have_the_numbers_that_one_would_write(tmp_path: Path) -> None:
    assert values(tmp_path, "range = { start = 0, stop = 0.3, step = 0.1 }") == [0.0, 0.1, 0.2, 0.3]
    assert values(tmp_path, "range = { start = 1, stop = -1, count = 5 }") == [1.0, 0.5, 0.0, -0.5, -1.0]
    assert values(tmp_path, "log_range = { start = 1e-2, stop = 1e-12, count = 11 }") == [
        float(f"1e-{i}") for i in range(2, 13)
    ]
    steps = values(tmp_path, "range = { start = 2, stop = 8, step = 3 }")
    assert steps == [2, 5, 8] and all(isinstance(step, int) for step in steps)


def test_samples_are_inside_their_distributions_and_the_same_each_time(tmp_path: Path) -> None:
    spec = "random = { count = 200, seed = 3, log_uniform = [1e-4, 1e-2] }"
    first = values(tmp_path, spec)
    assert first == values(tmp_path, spec) != values(tmp_path, spec.replace("3", "4", 1))
    assert all(1e-4 <= value <= 1e-2 for value in first)
    # Half of a log-uniform sample is below the geometric mean; 200 draws stray by some 7.
    assert abs(sum(value < 1e-3 for value in first) - 100) < 35
    normal = values(tmp_path, "random = { count = 400, seed = 1, normal = [10.0, 2.0] }")
    assert abs(sum(normal) / 400 - 10) < 0.5
    assert abs(math.sqrt(sum((v - 10) ** 2 for v in normal) / 400) - 2) < 0.4


def test_a_latin_hypercube_has_one_sample_in_each_share(tmp_path: Path) -> None:
    sweep = load(
        tmp_path,
        '[[parameter]]\nentries = ["integration.rtol", "swing.force(2)"]\nnames = ["a", "b"]\n'
        "latin_hypercube = { count = 20, seed = 5, of = [{ uniform = [0, 20] }, { uniform = [-10, 10] }] }\n",
    )
    rows = sweep.parameters[0].rows
    assert sorted(math.floor(a) for a, _ in rows) == list(range(20))
    assert sorted(math.floor(b) for _, b in rows) == list(range(-10, 10))


def test_a_table_gives_numbers_logicals_and_texts(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("rtol, note, flag\n1e-3, a, true\n2, b, false\n")
    sweep = load(
        tmp_path,
        '[[parameter]]\nentries = ["integration.rtol", "swing.planar", "swing.model"]\n'
        'table = { file = "t.csv", columns = ["rtol", "flag", "note"] }\n',
    )
    assert sweep.parameters[0].rows == [[1e-3, True, "a"], [2, False, "b"]]


def test_a_grid_has_all_combinations_and_a_zip_goes_along(tmp_path: Path) -> None:
    two = ONE + 'list = [1, 2]\n[[parameter]]\nentry = "swing.elements"\nlist = [3, 4]\n'
    assert [run.values for run in Plan(load(tmp_path, two), "").runs] == [(1, 3), (1, 4), (2, 3), (2, 4)]
    zipped = Plan(load(tmp_path, 'combine = "zip"\n' + two), "")
    assert [run.values for run in zipped.runs] == [(1, 3), (2, 4)]


def test_entries_of_every_shape_are_replaced(tmp_path: Path) -> None:
    (case,) = cases(
        tmp_path,
        '[fixed]\n"swing.force(2)" = 0.1\n"swing.times(2)" = 0.2\n"swing.gravity(3)" = -9.81\n'
        '"swing.model" = "it\'s"\n"swing.planar" = false\n"swing.mid_mass" = 3\n"method[1].alpha" = 7.0\n'
        '"method[soft].alpha" = 8.0\n' + ONE + "list = [0.30000000000000004]\n",
    )
    assert case["swing"]["force"] == [2.0, 0.1, 0.0]
    assert case["swing"]["times"] == [0.2] and case["swing"].start_index["times"] == [2]
    assert case["swing"]["gravity"] == [-9.81] and case["swing"].start_index["gravity"] == [3]
    assert case["swing"]["model"] == "it's" and case["swing"]["planar"] is False
    assert case["swing"]["mid_mass"] == 3 and case["swing"]["elements"] == 4
    assert [method["alpha"] for method in case["method"]] == [7.0, 8.0]
    assert case["integration"]["rtol"] == 0.1 + 0.2


def test_whole_arrays_and_entries_that_move_along(tmp_path: Path) -> None:
    text = '[[parameter]]\nentry = "swing.force"\nlist = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]\n'
    assert [case["swing"]["force"] for case in cases(tmp_path, text)] == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    text = ONE + "also = { integration.atol = 1e-3 }\nlist = [1e-3, 0.7]\n"
    assert [case["integration"]["atol"] for case in cases(tmp_path, text)] == [1e-6, 7e-4]


def test_a_group_that_the_case_leaves_out_is_added(tmp_path: Path) -> None:
    text = '[fixed]\n"output.dt" = 0.5\n[[parameter]]\nentry = "output.columns"\nlist = ["x", "z"]\n'
    found = cases(tmp_path, text)
    assert [case["output"] for case in found] == [{"dt": 0.5, "columns": name} for name in ("x", "z")]


def test_doubles_are_exact(tmp_path: Path) -> None:
    odd = [0.1, 1 / 3, 5e-324, 1.7976931348623157e308, 1e22, 123456789.12345679]
    texts = ", ".join(map(repr, odd))
    plan = Plan(load(tmp_path, ONE + f"list = [{texts}]"), "")
    assert [float(plan.text(run).split("rtol = ")[1].split()[0]) for run in plan.runs] == odd


def test_the_hash_is_of_what_a_run_depends_on_alone(tmp_path: Path) -> None:
    def hashes(text: str, case: str = CASE, version: str = "taut 1") -> set[str]:
        return {run.hash for run in Plan(load(tmp_path, ONE + text, case), version).runs}

    first = hashes("list = [1, 2, 3]")
    assert hashes("list = [3, 2, 1]") == first
    assert hashes("list = [1, 2, 3]", CASE.replace("A comment", "Another")) == first
    assert hashes("list = [2, 3, 4]") & first == hashes("list = [2, 3]")
    assert not hashes("list = [1, 2, 3]", CASE.replace("0.128", "0.129")) & first
    assert not hashes("list = [1, 2, 3]", version="taut 2") & first


WRONG = {
    "no case": ('case = "none.nml"\n' + ONE + "list = [1]", "none.nml"),
    "misspelt key": (START + "checkpont = 3\n" + ONE + "list = [1]", "checkpont", "checkpoint"),
    "misspelt key of a parameter": (START + ONE + "lst = [1]", "[[parameter]] 1", "lst", "list"),
    "misspelt key of a range": (START + ONE + "range = { start = 1, stop = 2, cnt = 3 }", "cnt", "count"),
    "no parameter": (START, "[[parameter]]"),
    "no kind": (START + ONE, "log_range"),
    "two kinds": (START + ONE + "list = [1]\nrange = { start = 1, stop = 2, count = 2 }", "one of"),
    "empty list": (START + ONE + "list = []", "empty"),
    "no seed": (START + ONE + "random = { count = 3, uniform = [0, 1] }", "seed"),
    "no distribution": (START + ONE + "random = { count = 3, seed = 1 }", "uniform"),
    "step away": (START + ONE + "range = { start = 1, stop = 2, step = -0.5 }", "1 to 2"),
    "log of zero": (START + ONE + "log_range = { start = 0, stop = 2, count = 3 }", "positive"),
    "unequal zip": (
        START
        + 'combine = "zip"\n'
        + ONE
        + 'list = [1]\n[[parameter]]\nentry = "swing.elements"\nlist = [1, 2]',
        "integration.rtol 1",
        "swing.elements 2",
    ),
    "unknown combination": (START + 'combine = "mesh"\n' + ONE + "list = [1]", "mesh", "zip"),
    "unknown group of several": (
        START + '[[parameter]]\nentry = "swinge[1].force"\nlist = [1]',
        "swinge",
        "&swing",
    ),
    "no list": (START + ONE + "list = 1.0", "list = [1.0]"),
    "list and range": (
        START + ONE + "list = [1]\nrange = { start = 1, stop = 2, count = 2 }",
        "list and range",
    ),
    "step and count": (START + ONE + "range = { start = 1, stop = 2, step = 1, count = 2 }", "not both"),
    "too long a range": (
        START + ONE + "range = { start = 0, stop = 1, step = 1e-12 }",
        "1000000000001",
        "1000000 ",
    ),
    "too many samples": (START + ONE + "log_range = { start = 1, stop = 2, count = 1000001 }", "1000001"),
    "too large a grid": (
        START
        + ONE
        + "range = { start = 1, stop = 1001, step = 1 }\n"
        + '[[parameter]]\nentry = "swing.elements"\nrange = { start = 1, stop = 1000, step = 1 }',
        "1001000 runs",
    ),
    "stop left out": (START + ONE + "range = { start = 0, stop = 1, step = 0.3 }", "stop = 1", "0.9"),
    "stop left out of one": (START + ONE + "range = { start = 0, stop = 1, count = 1 }", "count = 1"),
    "interval turned round": (
        START + ONE + "random = { count = 3, seed = 1, uniform = [1, 0] }",
        "uniform = [1, 0]",
    ),
    "negative deviation": (START + ONE + "random = { count = 3, seed = 1, normal = [1, -1] }", "deviation"),
    "window turned round": (
        START + ONE + 'list = [1]\n[collect]\nq = { column = "x", take = "max", from = 2, to = 1 }',
        "[collect] q",
        "later",
    ),
    "quantity named like a parameter": (
        START + ONE + 'name = "a"\nlist = [1]\n[collect]\na = { column = "x", take = "max" }',
        "[collect] a",
        "another column",
    ),
    "quantity named like a column": (
        START + ONE + 'list = [1]\n[collect]\nsteps = { column = "x", take = "max" }',
        "[collect] steps",
        "another column",
    ),
    "parameter named like a column": (START + ONE + 'name = "t_end"\nlist = [1]', "'t_end'", "taken"),
    "trajectory named like a parameter": (
        START + ONE + 'name = "x"\nlist = [1]\n[collect]\ntrajectories = ["x"]',
        "another column 'x'",
    ),
    "numbers as labels": (START + '[[parameter]]\nentry = "method[1].label"\nlist = [1]', "quotation marks"),
    "contours of lines": (
        START + ONE + 'list = [1]\n[[plot]]\nname = "p"\nx = "x"\ny = "y"\ncontours = [1]',
        "[[plot]] 1",
        "map",
    ),
    "no index": (START + '[[parameter]]\nentry = "method.alpha"\nlist = [1]', "2 groups", "method[present]"),
    "unknown label": (START + '[[parameter]]\nentry = "method[hard].alpha"\nlist = [1]', "hard", "2 soft"),
    "no entry": (START + '[[parameter]]\nentry = "rtol"\nlist = [1]', "'rtol'", "group.entry"),
    "the same entry twice": (START + ONE + 'list = [1]\n[fixed]\n"integration.rtol" = 1', "same entry"),
    "array and element": (
        START + '[fixed]\n"swing.force" = [1, 2, 3]\n[[parameter]]\nentry = "swing.force(2)"\nlist = [1]',
        "same entry",
    ),
    "infinite": (START + ONE + "list = [inf]", "finite"),
    "no table": (START + ONE + 'table = { file = "none.csv", columns = ["a"] }', "none.csv"),
    "no column": (START + ONE + 'table = { file = "t.csv", columns = ["b"] }', "t.csv", "'b'", "it has a"),
    "unknown take": (
        START + ONE + 'list = [1]\n[collect]\nq = { column = "x", take = "most" }',
        "most",
        "max",
    ),
    "unknown axis": (
        START + ONE + 'list = [1]\n[[plot]]\nname = "p"\nx = "x"\ny = "y"\nlog = ["a"]',
        "[[plot]] 1",
        "'a'",
        "x, y, z",
    ),
    "no TOML": (START + ONE + "list = [1", "sweep.toml"),
}


@pytest.mark.parametrize("case", WRONG.values(), ids=WRONG)
def test_a_wrong_sweep_file_is_told_in_one_line(tmp_path: Path, case: tuple[str, ...]) -> None:
    text, *parts = case
    (tmp_path / "base.nml").write_text(CASE)
    (tmp_path / "t.csv").write_text("a\n1\n")
    path = tmp_path / "sweep.toml"
    path.write_text(text)
    with pytest.raises(TautError) as caught:
        Plan(sweep_file.read(path), "")
    said = str(caught.value)
    assert said.startswith(str(path)) and "\n" not in said
    for part in parts:
        assert part in said


@pytest.mark.parametrize("path", sorted((ROOT / "cases").glob("*/*.toml")), ids=lambda path: path.stem)
def test_the_programs_take_the_examples(path: Path) -> None:
    from taut.programs import check_case, release

    sweep = sweep_file.read(path)
    plan = Plan(sweep, "")
    built = release(sweep.app)
    assert check_case(built, plan.text(plan.runs[0])) is None
    assert check_case(built, plan.text(plan.runs[0]) + "&nonsense /\n") is not None
