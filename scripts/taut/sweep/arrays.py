"""A sweep on a cluster: its runs as job arrays of Slurm, each task of which works through a few of them."""

import shlex
import shutil
import statistics
import sys
from collections import Counter
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from taut.bootstrap import ROOT
from taut.errors import TautError
from taut.files import read_json, write_json, write_whole
from taut.programs import ONE_THREAD
from taut.sweep import slurm
from taut.sweep.execute import INTERRUPTED
from taut.sweep.plan import Plan
from taut.sweep.store import FINISHED, Store, lock, record_of, state_of

FOLDER = "slurm"
SCRIPT = "array.sh"
TASKS = "tasks"
JOB = "job.json"
# A task is to last about so long, if finished runs tell how long one takes [s]; else there are so many tasks.
TASK_SECONDS = 300
TASKS_AT_FIRST = 100

# The options of the sweep file come after ours, for Slurm takes the last; the command line overrides both.
TEXT = """\
#!/bin/bash
# Written by scripts/sweep run --slurm. Each task works through the runs of one line of the file '{tasks}'.
#SBATCH --job-name={name}
#SBATCH --array=0-{last}
#SBATCH --output={log}
#SBATCH --open-mode=append
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --requeue
#SBATCH --signal=B:USR1@60
{directives}
export {environment}
runs=$(sed -n "$((SLURM_ARRAY_TASK_ID + 1))p" {table})
{work} --runs "$runs" &
worker=$!

# Before the time is over: checkpoints are written, and the task is queued again to go on from them.
again=
trap 'again=yes; kill -USR1 $worker' USR1
# Canceled or preempted: Slurm itself tells every process of the task; this one waits for the others.
trap : TERM
while kill -0 $worker 2>/dev/null; do wait $worker; done
wait $worker
code=$?
if [ "$again" ] && [ $code = {interrupted} ] && [ "${{SLURM_RESTART_COUNT:-0}}" -lt 100 ]; then
  scontrol requeue "$SLURM_JOB_ID"
fi
exit $code
"""


@dataclass(frozen=True)
class Array:
    """An array: its folder, and the first and last run of each task."""

    folder: Path
    tasks: list[tuple[int, int]]

    @property
    def script(self) -> Path:
        """The script; Slurm's queue names the array by it, and no other array ever has the same."""
        return self.folder / SCRIPT

    @property
    def job(self) -> str | None:
        """The job's number; None if it was never submitted."""
        return (read_json(self.folder / JOB) or {}).get("job")


def submit(plan: Plan, store: Store, runs_per_task: int | None, options: list[str]) -> None:
    """Submits the runs that are neither done nor with Slurm already, and says so."""
    slurm.check_there()
    slurm.check_options(options)
    folder = store.root.resolve() / FOLDER
    folder.mkdir(exist_ok=True)
    with lock(folder) as held:
        if held is None:
            raise TautError(f"{plan.sweep.path} is being submitted by another process")
        queued = _queued(_arrays(folder), slurm.queue())
        states = {run.index: state_of(store.folder(run), run) for run in plan.different}
        todo = [index for index, state in states.items() if state not in (*FINISHED, "running")]
        new = [index for index in todo if index not in queued]
        said = {name: list(states.values()).count(name) for name in (*FINISHED, "running")} | {
            "in Slurm's queue": len(todo) - len(new),
            "to submit": len(new),
        }
        print(
            f"{plan.sweep.name}: " + ", ".join(f"{number} {word}" for word, number in said.items() if number)
        )
        if not new:
            return
        tasks = sliced(new, queued, runs_per_task or _runs_per_task(plan, store, len(new)))
        limit = slurm.array_limit()
        for first in range(0, len(tasks), limit):
            array = _new(folder, tasks[first : first + limit])
            _submit(array, _script(plan, store, array), options)


def told(plan: Plan, store: Store) -> list[str]:
    """Returns what Slurm says of a sweep's tasks: lines, if it was submitted and there is a Slurm to ask."""
    arrays = _arrays(store.root.resolve() / FOLDER)
    lines = []
    if arrays and shutil.which("squeue"):
        try:
            queue = slurm.queue()
        except TautError as error:
            return [f"slurm: {error}"]
        queued = _queued(arrays, queue)
        waiting = sum(
            run.index in queued and state_of(store.folder(run), run) not in (*FINISHED, "running")
            for run in plan.different
        )
        tasks = Counter(state for array in arrays for state in queue.get(array.script, {}).values())
        lines.append(f"slurm: tasks in the queue: {_counted(tasks)}; {waiting} runs wait in them")
    if ended := slurm.ended([array.job for array in arrays if array.job]):
        lines.append(f"slurm: tasks that ended: {_counted(ended)}")
    return lines


def sliced(runs: list[int], queued: set[int], size: int) -> list[tuple[int, int]]:
    """Returns the first and last of so many runs at a time; none that is queued elsewhere lies between."""
    parts: list[list[int]] = []
    for run in runs:
        if parts and len(parts[-1]) < size and queued.isdisjoint(range(parts[-1][-1], run)):
            parts[-1].append(run)
        else:
            parts.append([run])
    return [(part[0], part[-1]) for part in parts]


def _runs_per_task(plan: Plan, store: Store, number: int) -> int:
    """Returns how many runs a task is to have: by the time that finished ones took, or a guess."""
    records = (record_of(store.folder(run), run) for run in plan.runs)
    times = [
        (datetime.fromisoformat(one["end"]) - datetime.fromisoformat(one["start"])).total_seconds()
        for one in records
        if one and one["state"] in FINISHED
    ]
    if times:
        return max(1, min(number, int(TASK_SECONDS / max(statistics.median(times), 0.01))))
    return -(-number // TASKS_AT_FIRST)


def _submit(array: Array, script: str, options: list[str]) -> None:
    """Writes an array's files and submits it; one that is refused leaves nothing behind."""
    try:
        write_whole(array.folder / TASKS, "".join(f"{first}:{last}\n" for first, last in array.tasks))
        write_whole(array.script, script)
        job = slurm.submit(array.script, options)
    except (TautError, OSError) as error:
        # Slurm may have taken what it had no time to confirm.
        if "timed out" not in str(error):
            shutil.rmtree(array.folder)
        raise
    write_json(array.folder / JOB, {"job": job})
    print(f"submitted job {job} with {len(array.tasks)} tasks; what they say is in {array.folder}")


def _script(plan: Plan, store: Store, array: Array) -> str:
    """Returns an array's script. It may be submitted from anywhere: all its paths are absolute."""
    work = [sys.executable, ROOT / "scripts" / "sweep", "work", plan.sweep.path.resolve()]
    work += ["--results", store.root.resolve().parents[1]]
    return TEXT.format(
        name=shlex.quote(f"taut-{plan.sweep.name}"),
        last=len(array.tasks) - 1,
        log=shlex.quote(f"{str(array.folder).replace('%', '%%')}/%a.log"),
        tasks=TASKS,
        table=shlex.quote(str(array.folder / TASKS)),
        directives=slurm.directives(plan.sweep.slurm),
        environment=" ".join(f"{name}={value}" for name, value in ONE_THREAD.items()),
        work=shlex.join(map(str, work)),
        interrupted=INTERRUPTED,
    )


def _new(folder: Path, tasks: list[tuple[int, int]]) -> Array:
    """Makes the folder of an array, numbered after the last one."""
    number = max((int(path.name) for path in folder.glob("[0-9]*")), default=0) + 1
    array = Array(folder / f"{number:04}", tasks)
    array.folder.mkdir()
    return array


def _arrays(folder: Path) -> list[Array]:
    """Returns the arrays that were written, submitted or not."""
    arrays = []
    for path in sorted(folder.glob(f"[0-9]*/{TASKS}")):
        slices = (line.split(":") for line in path.read_text(encoding="utf-8").split())
        arrays.append(Array(path.parent, [(int(first), int(last)) for first, last in slices]))
    return arrays


def _queued(arrays: list[Array], queue: dict[Path, dict[int, str]]) -> set[int]:
    """Returns the runs of the tasks that wait or run."""
    found: set[int] = set()
    for array in arrays:
        for number in queue.get(array.script, {}):
            if number < len(array.tasks):
                first, last = array.tasks[number]
                found.update(range(first, last + 1))
    return found


def _counted(states: Counter[str]) -> str:
    return ", ".join(f"{number} {state}" for state, number in sorted(states.items())) or "none"
