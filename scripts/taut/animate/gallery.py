"""A still of each shipped case of `mechanism`, and a sheet of all of them."""

from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from PIL import Image

from taut import style
from taut.animate.geometry import FILE, read_geometry
from taut.animate.motion import of_mode, of_run
from taut.animate.pictures import Shown, draw_still, still
from taut.animate.scene import Look
from taut.results import REPRODUCE, Results

CELL, COLUMNS = (4.0, 3.1), 4


@dataclass(frozen=True)
class Recipe:
    """When a case is shown and how; a time without a strobe is a moment after nothing but traces."""

    case: str
    title: str
    time: float
    strobe: int = 0
    look: Look = Look()
    mode: int = 0


RECIPES = (
    Recipe("simple_pendulum", "simple pendulum", 0.6, 6),
    Recipe("double_pendulum", "double pendulum", 1.9, 5),
    Recipe("chain", "chain of twenty rods", 0.74, 5),
    Recipe("pendulum_modes", "second mode of a double pendulum", 1.0, 4, mode=2),
    Recipe("slider_crank", "slider-crank", 0.45, 5),
    Recipe("spatial_slider_crank", "spatial slider-crank", 0.6, 4, Look(traces=("ball",))),
    Recipe("four_bar", "four-bar linkage", 1.8, 4),
    Recipe("andrews", "Andrews' squeezing mechanism", 0.0125, 0, Look(traces=("E3", "H", "G"), names=True)),
    Recipe("bricard", "Bricard's mechanism", 1.1, 3, Look(traces=("P3",))),
    Recipe("bricard_box", "Bricard's mechanism, thick rods", 1.1, 0, Look(traces=("P3",))),
    Recipe("n_four_bar2", "two four-bars", 0.95, 3),
    Recipe("n_four_bar40", "forty four-bars, the first six", 0.8, 3, Look(window=(-1.2, 6.2, -1.4, 1.8))),
    Recipe("governor", "flyball governor", 1.0, 0, Look(traces=("ball1", "ball2"))),
    Recipe("heavy_top", "heavy top", 1.2, 0, Look(traces=("top",))),
    Recipe("rolling_disc", "rolling disc", 2.6, 4),
    Recipe("swing", "swing on a flexible beam", 0.6, 4, Look(traces=("n1", "n3", "n5"))),
)


def shown(recipe: Recipe, results: Results) -> Shown:
    """Reads the results of a case."""
    mechanism = read_geometry(results.root / recipe.case / FILE, REPRODUCE)
    if mechanism.static:
        motion = of_mode(mechanism, results.root / recipe.case, recipe.mode)
    else:
        case = results.case(recipe.case)
        motion = of_run(mechanism, case.run(case.methods[0]))
    # Of a mode its frequency is told.
    frequency = motion.about.partition(", ")[2]
    return Shown(mechanism, motion, recipe.look, ", ".join(filter(None, (recipe.title, frequency))))


def make(results: Results) -> list[Path]:
    """Writes a picture of each case and the sheet."""
    style.use()
    folder = results.root / "figures" / "gallery"
    folder.mkdir(parents=True, exist_ok=True)
    rows = -(-len(RECIPES) // COLUMNS)
    size = (COLUMNS * CELL[0], rows * CELL[1])
    sheet = plt.figure(figsize=size)
    paths = []
    for i, recipe in enumerate(RECIPES):
        one = shown(recipe, results)
        figure = still(one, recipe.time, recipe.strobe)
        paths.append(save(figure, folder / f"{recipe.case}.png", 200))
        row, column = divmod(i, COLUMNS)
        axes = sheet.add_axes(
            (
                (column + 0.05) / COLUMNS,
                (rows - 1 - row + 0.04) / rows,
                0.90 / COLUMNS,
                0.83 / rows,
            )
        )
        draw_still(axes, one, recipe.time, recipe.strobe)
    paths.append(save(sheet, folder / "gallery.png", 160, 256))
    return paths


def save(figure: Figure, path: Path, dots: int, colors: int | None = None) -> Path:
    """Writes a picture without dates, so that it is the same each time; few colors make it small."""
    style.save(figure, path, dpi=dots, pil_kwargs={"optimize": True})
    if colors:
        with Image.open(path) as picture:
            few = picture.convert("RGB").quantize(colors, Image.Quantize.MEDIANCUT, kmeans=2)
        few.save(path, optimize=True)
    return path
