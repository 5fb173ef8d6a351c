"""Checkpoints: a run that was killed or interrupted continues bit for bit, and damaged files are refused."""

import random
import shutil
import signal
import struct
import subprocess
import time
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from processes import let_run

from taut.programs import release

INTERRUPTED = 75

Start = Callable[..., subprocess.Popen[str]]

# Long enough to be killed in the middle, short enough to be repeated; chaotic behind the event at 0.27 s.
SWING = """&integration t_end = 0.6, rtol = 1e-3, atol = 1e-6, max_step = 1e-5 /
&output dt = 2e-3, columns = "*" /
&method name = "present" /
&method name = "coordinate-projection", label = "eich" /
"""
TIMED = "wall_seconds"


@pytest.fixture(scope="session")
def whole(swing: Path, environment: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that nobody disturbed."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "short.nml").write_text(SWING)
    subprocess.run([swing, "short.nml", "--quiet"], cwd=folder, env=environment, check=True)
    return folder


@pytest.fixture
def case(whole: Path, tmp_path: Path) -> Path:
    shutil.copy(whole / "short.nml", tmp_path)
    return tmp_path


def timeless(folder: Path) -> dict[str, bytes]:
    """Returns the files of a folder, the summary without its times."""
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    rows = [line.split(b",") for line in files["summary.csv"].splitlines()]
    column = rows[0].index(TIMED.encode())
    files["summary.csv"] = b"\n".join(b",".join(row[:column] + row[column + 1 :]) for row in rows)
    return files


def checkpoint_of(case: Path) -> Path:
    return case / "results/short/checkpoint.taut"


@pytest.fixture
def start(swing: Path, environment: dict[str, str]) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts the swing and lets nobody survive the test."""
    running = []

    def start_in(case: Path, *arguments: str | Path) -> subprocess.Popen[str]:
        command = [swing, *arguments]
        process = subprocess.Popen(
            command, cwd=case, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        running.append(process)
        return process

    yield start_in
    for process in running:
        process.kill()
        process.communicate()


@pytest.fixture
def interrupted(case: Path, start: Start) -> Path:
    """A case that was interrupted in its first method."""
    process = start(case, "short.nml")
    let_run(process, 0.3)
    process.terminate()
    process.communicate(timeout=60)
    assert process.returncode == INTERRUPTED
    return case


def test_killed_at_random_moments(case: Path, whole: Path, start: Start) -> None:
    chance = random.Random(1)
    kills = 0
    arguments = ["short.nml", "--checkpoint", "0.02", "--quiet"]
    while kills < 20:
        process = start(case, *arguments)
        try:
            process.communicate(timeout=chance.uniform(0.01, 0.25))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.communicate()
            kills += 1
        else:
            assert process.returncode == 0, "each restart ends well"
            assert timeless(case / "results/short").items() >= timeless(whole / "results/short").items()
            shutil.rmtree(case / "results")
        restart = ["--restart", checkpoint_of(case)] if checkpoint_of(case).exists() else []
        arguments = ["short.nml", "--checkpoint", "0.02", "--quiet", *restart]
    process = start(case, *arguments)
    process.communicate(timeout=60)
    assert process.returncode == 0
    assert timeless(case / "results/short").items() >= timeless(whole / "results/short").items()
    assert not checkpoint_of(case).exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGUSR1])
def test_signals(number: signal.Signals, case: Path, whole: Path, start: Start) -> None:
    arguments: list[str | Path] = ["short.nml"]
    codes = set()
    for pause in (0.3, 0.6, 0.3, None):
        process = start(case, *arguments)
        if pause is not None:
            let_run(process, pause)
            process.send_signal(number)
            if number != signal.SIGINT:
                process.send_signal(number)
        _, error = process.communicate(timeout=60)
        codes.add(process.returncode)
        if process.returncode == 0:
            break
        assert process.returncode == INTERRUPTED
        assert f"continue with: swing --restart {checkpoint_of(case).relative_to(case)}" in error
        last = (case / "results/short/summary.csv").read_text().splitlines()[-1]
        assert ",interrupted," in last
        arguments = ["--restart", checkpoint_of(case).relative_to(case)]
    assert codes == {0, INTERRUPTED}
    assert timeless(case / "results/short") == timeless(whole / "results/short")


def test_moved_folder(interrupted: Path, whole: Path, start: Start) -> None:
    shutil.move(interrupted / "results/short", interrupted / "short")
    process = start(interrupted, "--out", "././", "--restart", ".//short/checkpoint.taut", "--quiet")
    _, error = process.communicate(timeout=60)
    assert (process.returncode, error) == (0, "")
    assert timeless(interrupted / "short") == timeless(whole / "results/short")


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def refused(start: Start, case: Path, *arguments: str | Path, code: int = 1) -> str:
    """Returns the one line with which a restart is refused."""
    before = contents(case)
    process = start(case, *arguments, "--quiet")
    output, error = process.communicate(timeout=60)
    assert process.returncode == code
    assert output == "" and len(error.splitlines()) == 1, error
    assert before == {path: path.read_bytes() for path in case.rglob("*") if path.is_file()}, (
        "nothing is touched"
    )
    return error


def test_damaged_checkpoints(interrupted: Path, start: Start) -> None:
    path = checkpoint_of(interrupted)
    good = path.read_bytes()
    chance = random.Random(2)
    for _ in range(30):
        place = chance.randrange(len(good))
        path.write_bytes(good[:place] + bytes([good[place] ^ (1 << chance.randrange(8))]) + good[place + 1 :])
        assert "checkpoint" in refused(start, interrupted, "--restart", path)
    for length in (0, 5, 16, 30, 40, 100, len(good) - 1):
        path.write_bytes(good[:length])
        assert "checkpoint" in refused(start, interrupted, "--restart", path)
    path.write_bytes(good + b"more")
    assert "longer than it says" in refused(start, interrupted, "--restart", path)
    path.write_bytes(good[:16] + b"\x09\x00\x00\x00" + good[20:])
    assert "has format 9" in refused(start, interrupted, "--restart", path)


def test_foreign_checkpoints(
    interrupted: Path,
    start: Start,
    pendulum: Path,
    environment: dict[str, str],
) -> None:
    path = checkpoint_of(interrupted)
    done = subprocess.run(
        [pendulum, "--restart", path],
        cwd=interrupted,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "belongs to the app swing" in done.stderr
    case = interrupted / "short.nml"
    case.write_text(SWING.replace("0.6", "0.7"))
    assert "was changed since" in refused(start, interrupted, "--restart", path)
    case.write_text(SWING)
    assert "is not in the folder other/short" in refused(
        start, interrupted, "--restart", path, "--out", "other"
    )
    assert "there is no such checkpoint" in refused(start, interrupted, "--restart", "nothing.taut")
    assert "several" in refused(start, interrupted, "a.nml", "b.nml", "--restart", path, code=2)
    (unfinished,) = path.parent.glob("*.part")
    content = unfinished.read_bytes()
    unfinished.write_bytes(content.replace(b"1", b"2", 1))
    assert "is not what the checkpoint says" in refused(start, interrupted, "--restart", path)
    unfinished.write_bytes(content[: len(content) // 2])
    assert "is not what the checkpoint says" in refused(start, interrupted, "--restart", path)
    unfinished.unlink()
    assert "is not what the checkpoint says" in refused(start, interrupted, "--restart", path)


def test_missing_results(case: Path, start: Start) -> None:
    process = start(case, "short.nml")
    while not (case / "results/short/present.csv").exists():
        time.sleep(0.01)
    process.terminate()
    process.communicate(timeout=60)
    assert process.returncode == INTERRUPTED
    (case / "results/short/present.csv").unlink()
    error = refused(start, case, "--restart", checkpoint_of(case))
    assert "present.csv: the file of a finished method is missing" in error


def test_killed_between_two_methods(case: Path, whole: Path, start: Start) -> None:
    # The last checkpoint says that the first method is at work, while its file is finished already.
    process = start(case, "short.nml", "--checkpoint", "0.2")
    while not checkpoint_of(case).exists():
        time.sleep(0.01)
    kept = checkpoint_of(case).read_bytes()
    while not (case / "results/short/present.csv").exists():
        time.sleep(0.01)
    process.kill()
    process.communicate()
    checkpoint_of(case).write_bytes(kept)
    process = start(case, "--restart", checkpoint_of(case), "--quiet")
    _, error = process.communicate(timeout=60)
    assert (process.returncode, error) == (0, "")
    assert timeless(case / "results/short").items() >= timeless(whole / "results/short").items()


def test_another_build(interrupted: Path, start: Start) -> None:
    path = checkpoint_of(interrupted)
    good = path.read_bytes()
    archive = good[40:].replace(b"compiler: GCC", b"compiler: ICC", 1)
    path.write_bytes(good[:32] + zlib.crc32(archive).to_bytes(8, "little") + archive)
    assert "another build: taut" in refused(start, interrupted, "--restart", path)


def test_another_blas(interrupted: Path, start: Start) -> None:
    path = checkpoint_of(interrupted)
    change(path, "blas", lambda value: b"X" * len(value))
    assert "another BLAS or kernel: XXX" in refused(start, interrupted, "--restart", path)
    process = start(interrupted, "--restart", path, "--any-blas", "--quiet")
    process.communicate(timeout=60)
    assert process.returncode == 0


SIZES = {"r": 8, "i": 4, "l": 8, "b": 1, "t": 1}


def change(path: Path, name: str, new: Callable[[bytes], bytes]) -> None:
    """Crafts a checkpoint whose checksum fits: all entries of a name get other values, or another number."""
    data = path.read_bytes()
    archive, made, at = data[40:], b"", 0
    while at < len(archive):
        kind = chr(archive[at])
        (length,) = struct.unpack_from("<i", archive, at + 1)
        found = archive[at + 5 : at + 5 + length]
        (count,) = struct.unpack_from("<q", archive, at + 5 + length)
        at += 13 + length
        values = archive[at : at + max(count, 0) * SIZES[kind]]
        at += len(values)
        if found.decode() == name:
            values = new(values)
            count = len(values) // SIZES[kind]
        made += kind.encode() + struct.pack("<i", length) + found + struct.pack("<q", count) + values
    path.write_bytes(data[:24] + struct.pack("<qq", len(made), zlib.crc32(made)) + made)


CRAFTED = {
    "a file elsewhere": ("unfinished file", lambda _: b"../../victim.csv"),
    "a result elsewhere": ("file", lambda _: b"../../victim.csv"),
    "no program": ("program", lambda _: b""),
    "no app": ("app", lambda _: b""),
    "a method before the first": ("method", lambda _: struct.pack("<i", -1)),
    "a method behind the last": ("method", lambda _: struct.pack("<i", 10**9)),
    "a status that is none": ("status", lambda _: struct.pack("<i", 77)),
    "a billion events": ("events", lambda _: struct.pack("<i", 10**9)),
    "less than no events": ("events", lambda _: struct.pack("<i", -5)),
    "no stop": ("stop", lambda _: struct.pack("<i", 0)),
    "a stop behind the last": ("stop", lambda _: struct.pack("<i", 99)),
    "a stop that is no number": ("stops", lambda values: b"\xff" * len(values)),
    "a direction that is none": ("direction", lambda _: struct.pack("<d", 1e308)),
    "no stops": ("stops", lambda _: b""),
    "a state of another size": ("y", lambda values: values[8:]),
    "a file with fewer than no bytes": ("bytes", lambda _: struct.pack("<q", -1)),
}


@pytest.mark.parametrize("crafted", CRAFTED.values(), ids=CRAFTED)
def test_crafted_checkpoints(
    crafted: tuple[str, Callable[[bytes], bytes]], interrupted: Path, start: Start
) -> None:
    (interrupted / "results/victim.csv").write_text("not to be touched")
    (interrupted / "victim.csv").write_text("not to be touched")
    path = checkpoint_of(interrupted)
    before = path.read_bytes()
    change(path, *crafted)
    assert path.read_bytes() != before
    refused(start, interrupted, "--restart", path)


def test_crafted_checkpoint_that_would_empty_a_file(interrupted: Path, start: Start) -> None:
    # No bytes have the checksum zero: what is cut to them is empty.
    victim = interrupted / "results/victim.csv"
    victim.write_text("not to be touched")
    path = checkpoint_of(interrupted)
    change(path, "unfinished file", lambda _: b"../victim.csv")
    change(path, "bytes", lambda _: bytes(8))
    change(path, "checksum", lambda _: bytes(8))
    refused(start, interrupted, "--restart", path)
    assert victim.read_text() == "not to be touched"


def test_table_belongs_to_the_case(tmp_path: Path, environment: dict[str, str]) -> None:
    app = release("mechanism")
    (tmp_path / "drive.csv").write_text("".join(f"{t},{t * t}\n" for t in range(100)))
    (tmp_path / "case.nml").write_text(
        '&body name = "rod", shape = "rod", mass = 1, from = 0, 0, 0, to = 1, 0, 0 /\n'
        '&function name = "drive", kind = "table", table = "drive.csv" /\n'
        '&joint name = "hinge", type = "revolute", body_2 = "rod", point = 0, 0, 0, axis = 0, 1, 0,\n'
        ' drive_angle = "drive" /\n&integration t_end = 90, max_step = 1e-3 /\n&output dt = 1 /\n'
    )
    settings = {"cwd": tmp_path, "env": environment, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen([app, "case.nml", "--quiet"], **settings)
    let_run(process, 0.5)
    process.terminate()
    _, error = process.communicate(timeout=60)
    assert process.returncode == INTERRUPTED, error
    (tmp_path / "drive.csv").write_text("".join(f"{t},{2 * t * t}\n" for t in range(100)))
    command = [app, "--restart", "results/case/checkpoint.taut", "--quiet"]
    done = subprocess.run(command, check=False, **settings)
    assert done.returncode == 1
    assert "table of it was changed since" in done.stderr


def test_two_at_once(interrupted: Path, whole: Path, start: Start) -> None:
    first = start(interrupted, "--restart", checkpoint_of(interrupted), "--quiet")
    time.sleep(0.1)
    second = start(interrupted, "--restart", checkpoint_of(interrupted), "--quiet")
    _, error = second.communicate(timeout=60)
    assert second.returncode == 1
    assert "another process writes the unfinished file" in error
    first.communicate(timeout=60)
    assert first.returncode == 0
    assert timeless(interrupted / "results/short") == timeless(whole / "results/short")


@pytest.mark.parametrize("value", ["0", "-1", "soon", "nan", ""])
def test_bad_intervals(value: str, case: Path, start: Start) -> None:
    assert "--checkpoint" in refused(start, case, "short.nml", "--checkpoint", value, code=2)


def test_full_disk(
    swing: Path, whole: Path, environment: dict[str, str], tmp_path: Path, small_disk: Path
) -> None:
    shutil.copy(whole / "short.nml", tmp_path)
    command = [swing, "short.nml", "--out", "out", "--checkpoint", "0.02", "--quiet"]
    settings = {"cwd": tmp_path, "env": environment, "capture_output": True, "text": True, "check": False}
    done = subprocess.run(command, **settings)
    assert done.returncode == 1
    assert "make room on the disk" in done.stderr and len(done.stderr.splitlines()) == 1
    subprocess.run(["mount", "-o", "remount,size=10m", small_disk], check=True)
    done = subprocess.run([swing, "--restart", "out/short/checkpoint.taut", "--quiet"], **settings)
    assert (done.returncode, done.stderr) == (0, "")
    assert timeless(small_disk / "short") == timeless(whole / "results/short")
