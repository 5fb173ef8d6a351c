import shutil
from pathlib import Path

import pytest

from taut.benchmark import instructions
from taut.errors import TautError

ANNOTATED = """\
--------------------------------------------------------------------------------
Ir
--------------------------------------------------------------------------------
1,000 (100.0%)  PROGRAM TOTALS

--------------------------------------------------------------------------------
Ir            file:function
--------------------------------------------------------------------------------
500 (50.00%)  ???:__taut_linalg_banded_factor_MOD_factorize.isra.0 [/some/where/example/taut_benchmark]
250 (25.00%)  ???:sum_groups.0.isra.0 [/some/where/example/taut_benchmark]
 70 ( 7.00%)  ./math/../sysdeps/e_sqrt.c:sqrt [/usr/lib/libm.so.6]
  1 ( 0.10%)  ???:__taut_ode_integrate_MOD_run [/some/where/example/taut_benchmark]
"""


def test_growth_above_the_threshold_is_told() -> None:
    baseline = {"a": (1000, "gfortran 12"), "b": (1000, "gfortran 12"), "c": (1000, "gfortran 12")}
    counts = {"a": 1030, "b": 1031, "c": 500}
    lines, complaints = instructions.compare(counts, baseline, "gfortran 12", 3.0)
    assert lines[2:] == [
        "| a | 1,030 | 1,000 | +3.00 % |",
        "| b | 1,031 | 1,000 | +3.10 % |",
        "| c | 500 | 1,000 | -50.00 % |",
    ]
    assert complaints == ["b takes 3.10 % more instructions than its baseline"]


def test_another_compiler_is_named() -> None:
    _, complaints = instructions.compare({"a": 2000}, {"a": (1000, "gfortran 12")}, "gfortran 13", 3.0)
    assert complaints[0].endswith("(the baseline is of gfortran 12, this is gfortran 13)")


def test_run_without_a_baseline_is_told() -> None:
    _, complaints = instructions.compare({"new": 1}, {}, "gfortran 12", 3.0)
    assert complaints == ["new has no baseline; scripts/instructions --update stores one"]


def test_baseline_comes_back_as_it_was_written(tmp_path: Path) -> None:
    path = tmp_path / "instructions.csv"
    instructions.write_baseline({"a": 12, "b": 13}, "GNU Fortran (Debian, 12) 12.2", path)
    assert instructions.read_baseline(path) == {
        "a": (12, "GNU Fortran (Debian, 12) 12.2"),
        "b": (13, "GNU Fortran (Debian, 12) 12.2"),
    }
    path.write_text("run,instructions,compiler\na,many,x\n", encoding="utf-8")
    with pytest.raises(TautError, match="is not a table of"):
        instructions.read_baseline(path)


def test_every_run_has_a_baseline() -> None:
    assert set(instructions.read_baseline()) == set(instructions.RUNS)


def test_functions_have_their_names_in_the_source() -> None:
    assert instructions.functions(ANNOTATED, 3) == [
        (50.0, "taut_linalg_banded_factor: factorize"),
        (25.0, "sum_groups"),
        (7.0, "sqrt"),
    ]


def test_a_case_is_cut_short(tmp_path: Path) -> None:
    arguments = instructions.RUNS["swing-1b"].arguments(tmp_path)
    assert "t_end = 0.002\n" in Path(arguments[0]).read_text(encoding="utf-8")


def test_runs_of_a_sweep_are_listed(tmp_path: Path) -> None:
    case, *rest = instructions.RUNS["sweep"].arguments(tmp_path)
    assert "@1@" in Path(case).read_text(encoding="utf-8")
    assert rest == ["--runs", str(tmp_path / "runs.tsv"), "--quiet"]
    lines = (tmp_path / "runs.tsv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 20
    assert lines[5] == "5\t1.0"


def test_program_without_an_integration_counts_nothing(tmp_path: Path) -> None:
    if shutil.which("valgrind") is None:
        pytest.skip("valgrind is not installed")
    with pytest.raises(TautError, match="counted nothing"):
        instructions.count(Path("/bin/true"), [], tmp_path / "true.callgrind")
