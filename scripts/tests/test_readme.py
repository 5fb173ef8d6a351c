import os
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]


def fortran_of_readme() -> str:
    blocks = re.findall(r"```fortran\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 1
    return blocks[0]


def test_readme_program_runs_from_outside_the_library(tmp_path: Path) -> None:
    # A user's own fpm project that knows taut by its path alone.
    (tmp_path / "app").mkdir()
    (tmp_path / "app" / "main.f90").write_text(fortran_of_readme(), encoding="utf-8")
    path = os.path.relpath(ROOT, tmp_path)  # fpm takes relative paths alone
    (tmp_path / "fpm.toml").write_text(
        f'name = "wire"\n[build]\nlink = ["lapack", "blas"]\n[dependencies]\ntaut = {{ path = "{path}" }}\n',
        encoding="utf-8",
    )
    ran = subprocess.run(
        ["fpm", "run", "--flag", "-g"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        check=False,
    )
    assert ran.returncode == 0, ran.stderr[-2000:]
    said = [line for line in ran.stdout.splitlines() if "phi =" in line][-1]
    assert said.startswith("reached-end")
    assert abs(float(said.split("=")[1])) <= 1e-12
    # The bead stays on its side of the energy it began with: z <= 1 + v^2/2g.
    z = float(said.split()[2])
    assert 0.0 <= z <= 1.0 + 0.05 / (2 * 9.81) + 1e-6


def test_readme_names_every_case() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for case in (ROOT / "cases").glob("*/*.nml"):
        assert f"`{case.stem}`" in readme, f"{case.name} is missing in the table of cases"


def test_readme_shows_existing_pictures() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for path in re.findall(r"!\[[^]]*\]\(([^)]+)\)", readme):
        assert (ROOT / path).is_file()
