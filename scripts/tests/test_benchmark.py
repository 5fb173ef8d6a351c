"""The logic of the benchmark; nothing here depends on how fast anything is."""

import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.special import ellipj

from taut.benchmark import command, figures, measure, table
from taut.benchmark.entrant import Array, Entrant, Problem, Run
from taut.benchmark.measure import Measurement, cheapest, exponent
from taut.benchmark.peers import PEERS, program
from taut.benchmark.peers.scipy import SYSTEMS
from taut.benchmark.problems import PROBLEMS, andrews, bricard, chain, four_bar, heavy_top, pendulum
from taut.errors import TautError

GRAVITY = 9.81


def problem(targets: tuple[float, ...] = (1e-3,)) -> Problem:
    """A problem whose state is one number, and whose answer is 1."""
    return Problem(
        name="one",
        title="One",
        t_end=1.0,
        sizes=(1,),
        tolerances=(1e-3, 1e-6),
        atol=lambda rtol: rtol,
        targets=lambda _size: targets,
        reference=lambda _size: np.array([1.0]),
        error=lambda _size, state, reference: float(abs(state - reference)[0]),
        violation=lambda _size, _state: 0.0,
    )


def entrant(label: str, answers: dict[float, float | None], seconds: float = 1.0) -> Entrant:
    """An entrant that answers as told for each setting; None fails."""

    def run(setting: float, _seconds: float) -> Run:
        answer = answers[setting]
        if answer is None:
            raise TautError("no step is small enough")
        return Run(seconds, 10, 60, 0, np.array([answer]))

    return Entrant(label, "made", tuple(answers), run)


def measured(entrants: list[Entrant], monkeypatch: pytest.MonkeyPatch) -> tuple[list[Measurement], list[str]]:
    monkeypatch.setattr(measure, "kept", lambda problem, size: problem.reference(size))
    said: list[str] = []
    return measure.measure(problem(), 1, entrants, 1, said.append), said


def row(
    entrant: str, size: int, setting: float, seconds: float, error: float, name: str = "chain"
) -> Measurement:
    return Measurement(
        name, size, entrant, entrant.split()[0].lower(), setting, 10, 60, 0, seconds, error, 1e-15
    )


def test_cost_over_size_is_at_an_error_that_most_entrants_reach() -> None:
    rows = [row("one", 2, 1e-3, 1.0, 1e-4), row("two", 2, 1e-3, 1.0, 1e-7), row("one", 2, 1e-9, 1.0, 1e-6)]
    assert figures.strictest(rows, (1e-3, 1e-6, 1e-9)) == 1e-6
    assert figures.strictest(rows[:2], (1e-3, 1e-7)) == 1e-3


# References


def test_pendulum_reference_begins_at_the_start() -> None:
    assert pendulum.exact(0.0) == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("t", [0.3, 1.7, 10.0])
def test_pendulum_reference_is_the_motion_of_its_angle(t: float) -> None:
    # The angle from the lowest point, by a method that knows nothing of elliptic functions.
    angle, rate = solve_ivp(
        lambda _t, y: (y[1], -GRAVITY * math.sin(y[0])),
        (0.0, t),
        (math.pi / 2, 0.0),
        method="DOP853",
        rtol=1e-13,
        atol=1e-13,
    ).y[:, -1]
    expected = [math.sin(angle), -math.cos(angle), rate * math.cos(angle), rate * math.sin(angle)]
    assert pendulum.exact(t) == pytest.approx(expected, abs=1e-10)


def test_chain_of_one_rod_is_a_pendulum() -> None:
    assert chain.reference(1) == pytest.approx(pendulum.exact(1.0), abs=1e-10)


def test_chain_reference_keeps_the_energy_and_the_rods() -> None:
    n = 7
    state = chain.reference(n)
    place, speed = state.reshape(2, n, 2)
    assert chain.violation(n, state) <= 1e-14
    assert 0.5 * (speed**2).sum() + GRAVITY * place[:, 1].sum() == pytest.approx(0.0, abs=1e-8)


def test_four_bar_reference_keeps_the_energy_and_the_rods() -> None:
    n = 3
    state = four_bar.reference(n)
    place, speed = state.reshape(2, n + 1, 2)
    assert four_bar.violation(n, state) <= 1e-14
    # A crank has a third of the kinetic energy of a rod that moves as its tip does.
    kinetic = 0.5 * float((speed[0] ** 2).sum()) * ((n + 1) / 3 + n)
    height = float(place[0, 1]) * ((n + 1) / 2 + n)
    start = 0.5 * ((n + 1) / 3 + n) + GRAVITY * ((n + 1) / 2 + n)
    assert kinetic + GRAVITY * height == pytest.approx(start, rel=1e-10)


def test_heavy_top_reference_begins_at_the_start_and_keeps_the_energy() -> None:
    assert heavy_top.exact(0.0) == pytest.approx([0.0, 1.0, 0.0, 4.61538, 0.0, 0.0], abs=1e-12)
    # Of the axis alone: the spin keeps its share.
    for t in (0.3, 2.0):
        state = heavy_top.exact(t)
        kinetic = 0.5 * heavy_top.ACROSS * float(state[3:] @ state[3:])
        potential = heavy_top.MASS * heavy_top.GRAVITY * state[2]
        assert kinetic + potential == pytest.approx(0.5 * heavy_top.ACROSS * 4.61538**2, rel=1e-12)
        assert heavy_top.PROBLEM.violation(1, state) <= 1e-15


@pytest.mark.parametrize("n", [-50.0, 0.4])
def test_elliptic_integral_of_the_third_kind(n: float) -> None:
    expected = quad(lambda x: 1 / (1 - n * ellipj(x, 0.3)[0] ** 2), 0.0, 4.0, epsabs=1e-12, epsrel=1e-12)[0]
    assert heavy_top.pi(n, 4.0, 0.3) == pytest.approx(expected, abs=1e-11)


def test_bricard_reference_keeps_the_loop_closed_and_the_energy() -> None:
    state = bricard.reference(1)
    assert bricard.violation(1, state) <= 1e-12
    # Slender rods: a sixth of v1^2 + v1 v2 + v2^2 each, and thickness adds next to nothing.
    ends = np.vstack((np.zeros(3), state[12:].reshape(4, 3), np.zeros(3)))
    first, second = ends[:-1], ends[1:]
    kinetic = float((first * first + first * second + second * second).sum()) / 6
    height = np.array([0.0, *state[1:12:3], 0.0])
    start = np.array([0.0, 0.0, -1.0, -1.0, -1.0, 0.0])
    fallen = float((start[:-1] + start[1:] - height[:-1] - height[1:]).sum()) / 2
    assert kinetic == pytest.approx(GRAVITY * fallen, abs=1e-5)


def test_andrews_reference_is_the_published_end() -> None:
    assert andrews.loops(np.array(andrews.START)) == pytest.approx(np.zeros(6), abs=1e-16)
    state = andrews.reference(1)
    assert state[:7] == pytest.approx(andrews.END, abs=2e-9)
    assert state[7:] == pytest.approx(andrews.END_RATES, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "size"),
    [("pendulum", 1), ("chain", 3), ("four-bar", 2), ("heavy_top", 1), ("bricard", 1), ("car-axis", 1)],
)
def test_equations_in_points_agree_with_the_reference(name: str, size: int) -> None:
    # Constraints and multipliers on one side; elliptic functions and angles without constraints on the other.
    start, rates, project = SYSTEMS[name](size)
    assert PROBLEMS[name].violation(size, project(start)) <= 1e-12
    done = solve_ivp(
        rates, (0.0, PROBLEMS[name].t_end), start, method="DOP853", rtol=1e-10, atol=1e-10, max_step=0.1
    )
    last = project(done.y[:, -1])
    assert PROBLEMS[name].error(size, last, PROBLEMS[name].reference(size)) <= 2e-6
    assert PROBLEMS[name].violation(size, last) <= 1e-12


@pytest.mark.parametrize("name", list(PROBLEMS))
def test_error_and_violation_see_a_wrong_state(name: str) -> None:
    size = PROBLEMS[name].sizes[0]
    reference = PROBLEMS[name].reference(size)
    wrong = reference.copy()
    # A point away from the support by a millimeter, or an angle by a thousandth.
    moved = {"bricard": slice(6, 9), "andrews": slice(0, 1)}.get(name, slice(0, 2))
    wrong[moved] += 1e-3 * wrong[moved] / np.linalg.norm(wrong[moved])
    assert PROBLEMS[name].error(size, reference, reference) == 0.0
    assert PROBLEMS[name].error(size, wrong, reference) == pytest.approx(1e-3)
    assert PROBLEMS[name].violation(size, wrong) > 5e-6
    assert math.isnan(PROBLEMS[name].error(size, np.full_like(reference, math.nan), reference))


def test_reference_is_kept_until_its_module_changes(tmp_path: Path) -> None:
    calls = []

    def reference(size: int) -> Array:
        calls.append(size)
        return np.array([float(size)])

    made = Problem(**{**problem().__dict__, "reference": reference})
    for _ in range(2):
        assert measure.kept(made, 3, tmp_path) == [3.0]
    assert calls == [3]


# Judgment


def test_entrant_that_misses_the_error_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    good = entrant("taut", {1e-3: 1.01, 1e-6: 1.0001}, seconds=2.0)
    fast_and_wrong = entrant("wrong", {1e-3: 1.5, 1e-6: 1.1}, seconds=1e-3)
    rows, _ = measured([good, fast_and_wrong], monkeypatch)
    best = cheapest(rows, 1e-3)
    assert best["wrong"] is None
    assert best["taut"] is not None
    assert best["taut"].setting == 1e-6
    text = "\n".join(table.comparison(problem(), 1, 1e-3, rows))
    assert "| wrong | refused: | | | | | | 1.0e-01 at best | | |" in text


def test_state_that_is_no_number_reaches_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    rows, _ = measured([entrant("none", {1e-3: math.nan})], monkeypatch)
    assert cheapest(rows, 1e9) == {"none": None}
    assert "refused" in "\n".join(table.comparison(problem(), 1, 1e-3, rows))


def test_entrant_that_fails_is_told_and_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    rows, said = measured([entrant("half", {1e-3: None, 1e-6: 1.0})], monkeypatch)
    assert [row.setting for row in rows] == [1e-6]
    assert any("half at 1e-03 failed: no step is small enough" in line for line in said)


def test_state_of_another_size_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    two = Entrant("two", "made", (1e-3,), lambda _setting, _seconds: Run(1.0, 1, 1, 0, np.ones(2)))
    rows, said = measured([two], monkeypatch)
    assert rows == []
    assert any("failed" in line for line in said)


def test_cheapest_is_not_the_most_accurate() -> None:
    rows = [
        row("taut", 10, 1e-6, 2.0, 1e-9),
        row("taut", 10, 1e-5, 1.0, 1e-6),
        row("taut", 10, 1e-3, 0.5, 1.0),
    ]
    best = cheapest(rows, 1e-5)["taut"]
    assert best is not None
    assert best.setting == 1e-5


def test_taut_that_misses_its_error_is_an_error() -> None:
    one = {"chain": PROBLEMS["chain"]}
    assert table.missed([row("taut", 10, 1e-6, 1.0, 1e-6)], one) == []
    assert (
        "taut misses the error 1e-05 of chain 10" in table.missed([row("taut", 10, 1e-6, 1.0, 1e-3)], one)[0]
    )
    assert table.missed([row("taut", 10, 1e-6, 1.0, math.nan)], one) != []


def test_exponent() -> None:
    assert exponent([10, 100, 1000], [2.0, 2 * 10**1.5, 2 * 10**3]) == pytest.approx(1.5)
    assert math.isnan(exponent([10], [1.0]))


# Table and figures


def made_rows() -> list[Measurement]:
    return [
        row(name, size, setting, factor * size / setting**0.2, setting)
        for name, factor in (("taut", 1e-6), ("SciPy RK45", 1e-4), ("Newcomer", 3e-5))
        for size in (10, 100, 1000)
        for setting in (1e-3, 1e-6)
    ]


def test_table_comes_back_as_it_was_written(tmp_path: Path) -> None:
    rows = [*made_rows(), row("odd, name", 10, 1e-3, 1.0, math.inf)]
    table.write_csv(rows, tmp_path / "new" / "benchmark.csv")
    assert table.read_csv(tmp_path / "new" / "benchmark.csv") == rows


def test_other_tables_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "benchmark.csv"
    path.write_text("a,b\n1,2\n", encoding="utf-8")
    with pytest.raises(TautError, match="does not have the columns"):
        table.read_csv(path)
    path.write_text(",".join(table.COLUMNS) + "\nchain,ten" + ",1" * 9 + "\n", encoding="utf-8")
    with pytest.raises(TautError, match="ten"):
        table.read_csv(path)


def test_page_compares_with_taut() -> None:
    page = table.markdown(made_rows(), PROBLEMS, {"taut": "1", "scipy": "2"})
    assert "taut 1, scipy 2" in page
    assert "| taut | 1e-06 | 10 |" in page
    line = next(line for line in page.splitlines() if line.startswith("| SciPy RK45 | 1e-06"))
    assert line.endswith("| 100 |")
    growth = next(
        line for line in page.splitlines() if line.startswith("| taut | ") and line.endswith("| 1.00 |")
    )
    assert growth.count("|") == 6


@pytest.mark.parametrize(
    ("seconds", "text"), [(1.234567e-6, "0.00123"), (0.0123456, "12.3"), (0.5, "500"), (12.0, "12000")]
)
def test_milliseconds(seconds: float, text: str) -> None:
    assert table.milliseconds(seconds) == text


def test_figures_come_from_the_table_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table.write_csv(made_rows(), tmp_path / "benchmark.csv")
    paths = figures.save(table.read_csv(tmp_path / "benchmark.csv"), tmp_path)
    assert [path.name for path in paths] == [
        f"{name}.{kind}" for name in ("work_precision", "cost_size") for kind in ("pdf", "png")
    ]
    assert all(path.stat().st_size > 5000 for path in paths)
    assert capsys.readouterr().err == ""


def test_both_pairs_are_set_side_by_side() -> None:
    names = ("taut", "taut, dop853", "SciPy DOP853", "taut, Eq. (8)")
    rows = [
        row(name, size, setting, 1e-3, setting, problem)
        for name in names
        for problem, size in (("bricard", 1), ("chain", 100), ("chain", 10))
        for setting in (1e-3, 1e-6, 1e-9)
    ]
    figure = figures.pairs(rows, "right-hand sides", lambda row: row.rhs)
    assert figure is not None
    # Bricard's mechanism and the chain of 100; Eq. (8) has no pair.
    assert [len(panel.lines) for panel in figure.axes] == [3, 3, 0, 0, 0, 0, 0, 0]
    assert list(figure.axes[0].lines[0].get_ydata()) == [60, 60, 60]
    assert figures.pairs([row for row in rows if row.entrant != "taut, dop853"], "", lambda _row: 1.0) is None


def test_peer_that_is_not_installed_has_rows_that_say_so() -> None:
    page = table.markdown(made_rows(), PROBLEMS, {"taut": "1"}, [PEERS["sundials"]])
    assert "| SUNDIALS ARKODE, order 8 | not installed: `--install sundials` |" in page
    assert "not installed" not in table.markdown(made_rows(), PROBLEMS, {"taut": "1"})


def test_figures_show_every_entrant_at_the_size_that_most_have() -> None:
    rows = [*made_rows(), row("taut", 10000, 1e-6, 1.0, 1e-6)]
    assert figures.shown_size(rows) == 100
    panel = figures.work_precision(rows).axes[0]
    assert [len(line.get_xdata()) for line in panel.lines] == [2, 2, 2]
    assert figures.order(rows) == ["taut", "SciPy RK45", "Newcomer"]
    figure = figures.cost_size(rows)
    assert figure is not None
    assert [len(line.get_xdata()) for line in figure.axes[0].lines] == [4, 3, 3]


def test_one_size_makes_no_figure_of_sizes() -> None:
    assert figures.cost_size([row("taut", 1, 1e-6, 1.0, 1e-6, "pendulum")]) is None


# Peers


def test_names_are_keys() -> None:
    assert all(name == peer.name for name, peer in PEERS.items())
    assert all(name == problem.name for name, problem in PROBLEMS.items())


@pytest.mark.parametrize("name", list(PROBLEMS))
def test_peers_give_entrants_with_names_of_their_own(name: str) -> None:
    entrants = [
        entrant
        for peer in PEERS.values()
        for entrant in peer.entrants(PROBLEMS[name], PROBLEMS[name].sizes[0])
    ]
    labels = [entrant.label for entrant in entrants]
    assert len(set(labels)) == len(labels)
    assert {entrant.label for entrant in entrants} <= set(figures.ENTRANTS)
    assert all(entrant.peer in PEERS and entrant.settings for entrant in entrants)


def test_peers_without_the_problem_stay_away() -> None:
    assert [entrant for peer in PEERS.values() for entrant in peer.entrants(problem(), 1)] == []


def test_pinned_packages() -> None:
    assert all("==" in package for peer in PEERS.values() for package in peer.pypi)


def test_unknown_and_missing_peers_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(TautError, match="there is no peer 'fortran'; there are taut"):
        command.present("scipy,fortran")
    absent = PEERS["sundials"].__class__("sundials", lambda: None, lambda _problem, _size: [])
    monkeypatch.setitem(PEERS, "sundials", absent)
    with pytest.raises(TautError, match="sundials: not installed"):
        command.present("sundials")
    assert list(command.present("scipy")) == ["taut", "scipy"]


def test_what_a_program_prints() -> None:
    names = "steps,rhs,jacobians,seconds"
    run = program.read_run("steps,rhs,jacobians,seconds\n12,84,3,1.5E-03\n 1.0E+00\n-2.0E+00\n")
    assert (run.steps, run.rhs, run.jacobians, run.seconds) == (12, 84, 3, 1.5e-3)
    assert list(run.state) == [1.0, -2.0]
    for text in ("", f"{names}\n12,84\n", "error\n1,2,3,4\n", f"{names}\n1,2,3,4\nx\n"):
        with pytest.raises(TautError, match="not a run"):
            program.read_run(text)


def test_last_line_of_a_program_that_fails() -> None:
    with pytest.raises(TautError, match="sh: the reason"):
        program.call(["sh", "-c", "echo first >&2; echo the reason >&2; exit 3"])
    with pytest.raises(TautError, match="no-such-program is not installed"):
        program.call(["no-such-program"])


def test_program_is_compiled_again_when_its_source_is_newer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if shutil.which("cc") is None:
        pytest.skip("there is no cc")
    monkeypatch.setattr(program, "WORK", tmp_path)
    source = tmp_path / "answer.c"
    for answer in ("one", "two"):
        source.write_text(f'#include <stdio.h>\nint main(void) {{ puts("{answer}"); return 0; }}\n', "utf-8")
        (tmp_path / "answer").unlink(missing_ok=True)
        assert program.call([program.build([source], ())]).strip() == answer


def test_help_of_the_scripts(root: Path) -> None:
    for name in ("benchmark", "instructions"):
        done = subprocess.run(
            [root / "scripts" / name, "--help"], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0
        assert "usage: " + name in done.stdout
