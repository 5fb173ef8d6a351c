"""Bad input: one line that names the place, the fault and a remedy; and nothing half-written."""

import csv
import os
import resource
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from processes import let_run

Run = Callable[..., subprocess.CompletedProcess[str]]

SHORT = "&integration t_end = 0.1 /\n"


def write(path: Path, text: str | bytes) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file()) if folder.is_dir() else []


def assert_refused(done: subprocess.CompletedProcess[str], *parts: str, code: int = 1) -> None:
    """Checks for an exit code and for one line `pendulum: place: fault; remedy` that has all of the parts."""
    assert done.returncode == code, done.stderr
    lines = done.stderr.splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("pendulum: ")
    for part in parts:
        assert part in lines[0]
    fault, _, remedy = lines[0].partition("; ")
    assert fault.count(": ") >= 2, "there is no place before the fault"
    assert remedy.strip(), "there is no remedy"
    assert "  " not in lines[0]


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


VALUES = {
    "unknown entry": ("&pendulum\n\n  masss = 1.0 /", "case.nml:3: &pendulum", "no entry masss", "mass,"),
    "word for a number": ("&pendulum\n  mass = heavy /", "case.nml:2: &pendulum", "mass = heavy", "type"),
    "text for a number": ('&pendulum mass = "1" /', "case.nml:1: &pendulum", 'mass = "1"', "type"),
    "unit after a number": ("&pendulum mass = 1 kg /", "case.nml:1: &pendulum", "mass = 1 kg", "type"),
    "two numbers for one": ("&pendulum mass = 1.0 2.0 /", "case.nml:1: &pendulum", "mass = 1.0 2.0"),
    "three coordinates": ("&pendulum position = 1, 2, 3 /", "&pendulum", "position = 1, 2, 3"),
    "a third coordinate": ("&pendulum position(3) = 1 /", "&pendulum", "position(3) = 1"),
    "fraction for an integer": (
        "&pendulum constraint_copies = 1.5 /",
        "&pendulum",
        "constraint_copies = 1.5",
    ),
    "column that does not exist": (
        '\n&output columns = "x", "y" /',
        "case.nml:2: &output",
        'no column "y"',
        "first line",
    ),
    "extreme that does not exist": (
        '\n&extreme column = "y", name = "top" /',
        'case.nml:2: &extreme "top"',
        'no column "y"',
        "first line",
    ),
    "extreme named as another": (
        '&extreme column = "x" /\n&extreme column = "z", name = "x" /',
        "case.nml:2: &extreme",
        'two extremes are called "x"',
    ),
    "text without quotes": ("&method name = present /", "&method", "name = present", "quotation"),
    "negative mass": ("\n&pendulum mass = -1 /", "case.nml:2: &pendulum", "mass = -1", "kg"),
    "zero mass": ("&pendulum mass = 0 /", "&pendulum", "mass = 0", "kg"),
    "zero length": ("\n\n&pendulum length = 0.0 /", "case.nml:3: &pendulum", "length = 0", "in m"),
    "no copies": ("&pendulum constraint_copies = 0 /", "&pendulum", "constraint_copies = 0"),
    "mass not a number": ("&pendulum mass = nan /", "&pendulum", "mass = nan"),
    "gravity not a number": ("&pendulum gravity = nan /", "&pendulum", "gravity"),
    "position not a number": ("&pendulum position = nan, 0 /", "&pendulum", "position"),
    "mass not finite": ("&pendulum mass = inf /", "&pendulum", "mass = inf"),
    "length too large": ("&pendulum length = 1e400 /", "&pendulum", "length"),
    "end not a number": ("&integration t_end = nan /", "&integration", "t_end"),
    "tolerance not a number": ("&integration rtol = nan /", "&integration", "rtol = nan"),
    "spacing not a number": ("&output dt = nan /", "&output", "dt = nan"),
    "zero tolerance": ("\n&integration rtol = 0 /", "case.nml:2: &integration", "rtol = 0", "1e-6"),
    "negative tolerance": ("&integration atol = -1e-6 /", "&integration", "atol = -1", "1e-9"),
    "negative step": ("&integration max_step = -1 /", "&integration", "max_step = -1"),
    "unknown step control": ('&integration step_control = "odd" /', "&integration", '"odd"', "odepkg-2009"),
    "unknown method": ('\n&method name = "newmark" /', "case.nml:2: &method", '"newmark"', '"present"'),
    "unknown weight": ('&method name = "present", weight = "w" /', "&method", 'weight = "w"', '"mass"'),
    "penalty without stiffness": ('&method name = "penalty" /', "&method", "stiffness = 0"),
    "label with a slash": ('&method name = "present", label = "a/b" /', "&method", '"a/b"', "letters"),
    "label of a parent": ('&method name = "present", label = ".." /', "&method", '".."'),
    "label of the summary": ('&method name = "present", label = "summary" /', "&method", '"summary"'),
    "label of the places": ('&method name = "present", label = "geometry" /', "&method", '"geometry"'),
    "label in capitals": ('&method name = "present", label = "Events" /', "&method", '"Events"'),
    "label of endless length": (f'&method label = "{"a" * 201}" /', "&method", "longer than 200"),
    "labels in capitals": (
        '&method label = "A" /\n&method label = "a" /',
        "case.nml:2: &method",
        "two methods",
    ),
    "too many rows": ("&output dt = 1e-12 /", "case.nml:1: &output", "dt = 1", "too many rows"),
    "misspelt column": ('&output columns = "lamda" /', '"lamda"', 'did you mean "lambda"?'),
    "label of the events": ('&method name = "present", label = "events" /', "&method", '"events"'),
    "end before the start": ("\n&integration t_end = -1 /", "case.nml:2: &integration", "before t_start"),
    "one coordinate": ("&pendulum position = 1 /", "&pendulum", "position = 1", "2 numbers"),
    "value left out": ("&pendulum position = ,1.0 /", "&pendulum", "position = ,1.0", "left out"),
    "repetition of nothing": ("&pendulum position = 2* /", "&pendulum", "position = 2*", "left out"),
    "text too long": (
        '&method solver = "pivoted-choleskyX" /',
        "&method",
        '"pivoted-choleskyX"',
        'did you mean "pivoted-cholesky"?',
    ),
    "infinite tolerance": ("&integration atol = inf /", "&integration", "atol = inf", "finite"),
    "absurd tolerance": (
        "&method projection_tolerance = 1e9 /",
        "&method",
        "projection_tolerance = 1e9",
        "1000",
    ),
    "misspelt entry": ("&pendulum lenght = 1 /", "&pendulum", "did you mean length?"),
    "misspelt group": ("&methd /", "case.nml:1", "did you mean &method?"),
    "duplicate labels": ('&method name = "present" /\n' * 2, "case.nml:2: &method", '"present"', "another"),
    "no value": ("&pendulum\n mass = , length = 1 /", "case.nml:2: &pendulum", "mass has no value"),
    "no last value": ("&pendulum mass = /", "case.nml:1: &pendulum", "mass has no value"),
    "no equals sign": ("&pendulum mass 1 /", "case.nml:1: &pendulum", '"mass"', "name = value"),
    "duplicate entry": ("&pendulum mass = 1\n mass = 2 /", "case.nml:2: &pendulum", "mass is given twice"),
    "duplicate group": ("&pendulum mass = 1 /\n&pendulum mass = 2 /", "case.nml:2: &pendulum", "twice"),
    "unknown group": ("\n&pendulums mass = 1 /", "case.nml:2:", "&pendulums", "&pendulum,"),
    "unnamed group": ("& mass = 1 /", "case.nml:1:", "&pendulum,"),
    "open group": ("&pendulum\n mass = 1\n", "case.nml:1:", "&pendulum", "end it with /"),
    "open quotation": ('&method name = "present /\n', "case.nml:1:", "&method", "quotation"),
    "text outside": ("&pendulum /\nmass = 1\n", "case.nml:2:", '"mass"'),
    "binary garbage": (b"\x7fELF\x02\x01\x00\xff\xfe\n\x00\x01\n", "case.nml:1:", "outside a group"),
    "empty file": ("", "case.nml:", "no group", "&pendulum"),
    "nothing but a comment": ("! mass = 1\n", "case.nml:", "no group", "&pendulum"),
    "start at the pivot": (
        "&pendulum position = 0, 0 /",
        "case.nml:",
        "initial state",
        "constraint 1",
        "closer",
    ),
}


@pytest.mark.parametrize("case", VALUES.values(), ids=VALUES)
def test_case_file_is_refused(run: Run, tmp_path: Path, case: tuple[str | bytes, ...]) -> None:
    text, *parts = case
    write(tmp_path / "case.nml", text)
    assert_refused(run("case.nml", "--out", "out"), *parts)
    assert not (tmp_path / "out").exists()


def test_second_case_file_is_read_before_the_first_is_run(run: Run, tmp_path: Path) -> None:
    write(tmp_path / "good.nml", SHORT)
    write(tmp_path / "bad.nml", "&pendulum mass = -1 /")
    done = run("good.nml", "bad.nml", "--out", "out")
    assert_refused(done, "bad.nml:1: &pendulum")
    assert done.stdout == ""
    assert not (tmp_path / "out").exists()


def test_missing_case_file(run: Run, tmp_path: Path) -> None:
    assert_refused(run("nowhere/case.nml", "--out", "out"), "nowhere/case.nml", "no such case file", "path")
    assert not (tmp_path / "out").exists()


def test_list_of_runs_tells_which_did_not_end(run: Run, tmp_path: Path) -> None:
    case = write(
        tmp_path / "case.nml", "&pendulum mass = @1@ /\n&integration t_end = 0.1, max_steps = @2@ /\n"
    )
    runs = write(tmp_path / "runs.tsv", "good\t1\t1000\n")
    assert run(case, "--runs", runs).returncode == 0
    for values, status in (("-1\t1000", "failed"), ("1\t2", "too-many-steps")):
        write(runs, f"good\t1\t1000\nbad\t{values}\nalso good\t2\t1000\n")
        done = run(case, "--runs", runs)
        assert done.returncode == 1 and "there are runs that did not reach their end" in done.stderr
        rows = list(csv.DictReader(done.stdout.splitlines()))
        assert [row["status"] for row in rows] == ["reached-end", status, "reached-end"]
    write(runs, "\n\n")
    assert_refused(run(case, "--runs", runs), "runs.tsv: the list has no run", "a line for each")
    for line, fault in (("good\t2\t1000", '"good" is there already, in line 1'), ("\t2\t1000", "no name")):
        write(runs, f"good\t1\t1000\n{line}\n")
        assert_refused(run(case, "--runs", runs), "runs.tsv:2", fault)


def test_folder_as_case_file(run: Run, tmp_path: Path) -> None:
    (tmp_path / "case.nml").mkdir()
    assert_refused(run("case.nml", "--out", "out"), "case.nml", "cannot be")
    assert not (tmp_path / "out").exists()


def test_case_files_of_one_name(run: Run, tmp_path: Path) -> None:
    write(tmp_path / "a" / "case.nml", SHORT)
    write(tmp_path / "b" / "case.nml", SHORT)
    assert_refused(run("a/case.nml", "b/case.nml", "--out", "out"), "b/case.nml", "a/case.nml")
    assert_refused(run("a/case.nml", "./a/case.nml", "--out", "out"), "./a/case.nml", "a/case.nml")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["case.nml", "--bogus"], "--bogus"),
        (["case.nml", "-q"], "-q"),
        (["case.nml", "--out"], "--out"),
        (["case.nml", "--out", ""], "--out"),
        (["case.nml", "--out", "--quiet"], "--out"),
        (["case.nml", "case.nml"], "case.nml"),
        (["case.nml", ""], "empty argument"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_command_line_is_refused(run: Run, tmp_path: Path, arguments: list[str], part: str) -> None:
    write(tmp_path / "case.nml", SHORT)
    assert_refused(run(*arguments), "command line", part, code=2)
    assert [path.name for path in tmp_path.iterdir()] == ["case.nml"]


@pytest.mark.parametrize("out", ["taken", "taken/below", "/dev/null/x", "/proc/x"])
def test_folder_that_cannot_be_written(run: Run, tmp_path: Path, out: str) -> None:
    write(tmp_path / "case.nml", SHORT)
    write(tmp_path / "taken", "a file in the place of the folder")
    done = run("case.nml", "--out", out)
    assert_refused(done, out, "cannot be written", "--out")
    assert done.stdout == ""
    assert (tmp_path / "taken").read_text() == "a file in the place of the folder"


@pytest.mark.parametrize("name", ["present.csv", "summary.csv"])
def test_folder_in_the_place_of_a_result(run: Run, tmp_path: Path, name: str) -> None:
    write(tmp_path / "case.nml", SHORT)
    (tmp_path / "out" / "case" / name).mkdir(parents=True)
    assert_refused(run("case.nml", "--out", "out", "--quiet"), f"out/case/{name}", "place")
    assert [path.name for path in files(tmp_path / "out")] == (
        ["present.csv"] if name == "summary.csv" else []
    )


def older_results(tmp_path: Path) -> Path:
    """Results of an earlier run, which a failed one must leave as they are."""
    folder = tmp_path / "out" / "case"
    write(folder / "present.csv", "older run")
    write(folder / "summary.csv", "older summary")
    return folder


def assert_older_results(folder: Path) -> None:
    named = [path.name for path in files(folder) if path.suffix != ".part"]
    assert named == ["present.csv", "summary.csv"]
    assert (folder / "present.csv").read_text() == "older run"
    assert (folder / "summary.csv").read_text() == "older summary"


def test_file_size_limit(run: Run, tmp_path: Path) -> None:
    folder = older_results(tmp_path)
    write(tmp_path / "case.nml", "&integration t_end = 100 /")

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    # The system would end the process by a signal; it is a failed output like any other.
    done = run("case.nml", "--out", "out", "--quiet", preexec_fn=limit)
    assert_refused(done, "out/case/present.csv", "room on the disk")
    assert_older_results(folder)
    assert len(files(folder)) == 2


@pytest.mark.parametrize(
    "arguments", [["case.nml"], ["--help"], ["--help-case"], ["--version"]], ids=" ".join
)
def test_lost_output_is_no_success(pendulum: Path, tmp_path: Path, arguments: list[str]) -> None:
    write(tmp_path / "case.nml", SHORT)
    for where in (">/dev/full", ">&-"):
        command = ["bash", "-c", f'"$0" "$@" {where}', pendulum, *arguments]
        done = subprocess.run(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, check=False)
        assert_refused(done, "standard output", "--quiet")


def test_closed_outputs_are_not_taken_by_results(pendulum: Path, tmp_path: Path) -> None:
    write(tmp_path / "case.nml", SHORT)
    command = ["bash", "-c", '"$0" case.nml --quiet >&- 2>&- <&-', pendulum]
    assert subprocess.run(command, cwd=tmp_path, check=False).returncode == 0
    assert (tmp_path / "results/case/present.csv").read_text().startswith("t,h,x,z,")


@pytest.mark.parametrize("name", ["...nml", "..toml"])
def test_case_named_as_another_folder(run: Run, tmp_path: Path, name: str) -> None:
    write(tmp_path / name, SHORT)
    assert_refused(run(name, "--out", "out"), name, "another folder", "rename")
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("name", ["a,b", 'a"b', "a\nb"])
def test_case_name_that_a_table_must_quote(run: Run, tmp_path: Path, name: str) -> None:
    write(tmp_path / f"{name}.nml", SHORT)
    done = run(f"{name}.nml", "--out", "out", "--quiet")
    assert (done.returncode, done.stderr) == (0, "")
    (summary,) = rows(tmp_path / "out" / name / "summary.csv")
    assert (summary["case"], summary["method"], summary["status"]) == (name, "present", "reached-end")


def test_case_file_that_is_a_pipe(run: Run, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "case.nml")
    assert_refused(run("case.nml", "--out", "out"), "case.nml", "no pipe")


def test_byte_order_mark(run: Run, tmp_path: Path) -> None:
    write(tmp_path / "case.nml", b"\xef\xbb\xbf" + SHORT.encode())
    assert run("case.nml", "--out", "out", "--quiet").returncode == 0


def test_pattern_of_many_stars_ends(run: Run, tmp_path: Path) -> None:
    write(tmp_path / "case.nml", SHORT + f'&output columns = "{"*p" * 20}*x" /')
    assert_refused(run("case.nml", "--out", "out"), "there is no column")


def test_blas_runs_with_one_thread(run: Run, tmp_path: Path, environment: dict[str, str]) -> None:
    write(tmp_path / "case.nml", SHORT)
    environment["OPENBLAS_NUM_THREADS"] = "4"
    run("case.nml", "--out", "out", "--quiet")
    (summary,) = rows(tmp_path / "out/case/summary.csv")
    assert summary["blas"].endswith("1 thread")


def test_full_disk(run: Run, tmp_path: Path, small_disk: Path) -> None:
    folder = older_results(tmp_path)
    write(tmp_path / "case.nml", "&integration t_end = 100 /")
    assert_refused(run("case.nml", "--out", "out", "--quiet"), "out/case/present.csv", "room on the disk")
    assert_older_results(folder)
    assert len(files(folder)) == 2, "a temporary file is left and fills the disk"


def test_full_disk_at_the_end(run: Run, tmp_path: Path, small_disk: Path) -> None:
    # Few rows stay in a buffer until the file is closed: a failure that only the close can report.
    folder = older_results(tmp_path)
    write(tmp_path / "case.nml", "&integration t_end = 0.2 /")
    filler = small_disk / "filler"
    with pytest.raises(OSError, match="No space left"), filler.open("wb", buffering=0) as file:
        while True:
            file.write(bytes(4096))
    assert_refused(run("case.nml", "--out", "out", "--quiet"), "out/case/present.csv", "room on the disk")
    filler.unlink()
    assert_older_results(folder)
    assert len(files(folder)) == 2


def test_killed_run(pendulum: Path, tmp_path: Path) -> None:
    write(tmp_path / "case.nml", "&integration t_end = 1e6 /")
    process = subprocess.Popen([pendulum, "case.nml", "--out", "out", "--quiet"], cwd=tmp_path)
    try:
        deadline = time.monotonic() + 180
        while not any(path.stat().st_size > 100_000 for path in files(tmp_path / "out")):
            assert time.monotonic() < deadline and process.poll() is None
            time.sleep(0.02)
        process.kill()
        assert process.wait(timeout=60) != 0
    finally:
        process.kill()
        process.wait()
    assert all(path.suffix == ".part" for path in files(tmp_path / "out"))
    # The next run in the folder does away with what nobody writes any more.
    write(tmp_path / "case.nml", SHORT)
    subprocess.run([pendulum, "case.nml", "--out", "out", "--quiet"], cwd=tmp_path, check=True)
    assert [path.name for path in files(tmp_path / "out")] == ["present.csv", "summary.csv"]


def no_locks(folder: Path) -> dict[str, str]:
    """Returns an environment in which files cannot be locked."""
    source = folder / "no_locks.c"
    source.write_text("#include <errno.h>\nint flock(int f, int o) { errno = ENOLCK; return -1; }\n")
    library = folder / "no_locks.so"
    subprocess.run(["gcc", "-shared", "-fPIC", "-o", library, source], check=True)
    return os.environ | {"LD_PRELOAD": str(library), "OPENBLAS_NUM_THREADS": "1"}


def test_file_system_without_locks(pendulum: Path, tmp_path: Path) -> None:
    write(tmp_path / "case.nml", "&integration t_end = 1e6 /")
    settings = {"cwd": tmp_path, "env": no_locks(tmp_path), "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen([pendulum, "case.nml", "--out", "out", "--quiet"], **settings)
    let_run(process, 0.5)
    process.terminate()
    process.communicate(timeout=60)
    assert process.returncode == 75
    assert len(list((tmp_path / "out/case").glob("*.part"))) == 1
    process = subprocess.Popen([pendulum, "--restart", "out/case/checkpoint.taut", "--quiet"], **settings)
    let_run(process, 0.5)
    process.terminate()
    _, error = process.communicate(timeout=60)
    assert process.returncode == 75
    assert "note: the file system has no locks" in error


def test_run_that_ends_early(run: Run, tmp_path: Path) -> None:
    write(tmp_path / "case.nml", "&integration max_steps = 10 /")
    done = run("case.nml", "--out", "out", "--quiet")
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    for part in ("case", "present", "max_steps = 10", "; "):
        assert part in done.stderr
    folder = tmp_path / "out" / "case"
    assert [path.name for path in files(folder)] == ["present.csv", "summary.csv"]
    (summary,) = rows(folder / "summary.csv")
    points = rows(folder / "present.csv")
    assert summary["status"] == "too-many-steps"
    assert int(summary["steps"]) + int(summary["rejected"]) == 10
    assert len(points) == int(summary["steps"]) + 1
    assert float(points[-1]["t"]) == float(summary["t_end"]) > 0.0


def test_other_methods_run_when_one_ends_early(run: Run, tmp_path: Path) -> None:
    # Stiffness bounds the steps of the penalty method, so that it alone runs out of them.
    text = "&integration t_end = 1, max_steps = 500 /\n"
    text += '&method name = "penalty", stiffness = 1e10, damping = 1e4 /\n&method name = "present" /\n'
    write(tmp_path / "case.nml", text)
    done = run("case.nml", "--out", "out", "--quiet")
    assert done.returncode == 1
    summary = rows(tmp_path / "out" / "case" / "summary.csv")
    assert {row["method"]: row["status"] for row in summary} == {
        "penalty": "too-many-steps",
        "present": "reached-end",
    }


def test_good_input(run: Run, tmp_path: Path) -> None:
    # What the tests above look for must be missing here, or they would pass with any program.
    write(tmp_path / "case.nml", "&pendulum /\n" + SHORT)
    done = run("case.nml", "--out", "out")
    assert done.returncode == 0
    assert done.stderr == ""
    assert "present" in done.stdout
    assert [path.name for path in files(tmp_path / "out" / "case")] == ["present.csv", "summary.csv"]
    quiet = run("case.nml", "--out", "out", "--quiet")
    assert (quiet.returncode, quiet.stdout, quiet.stderr) == (0, "", "")
