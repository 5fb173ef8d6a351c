"""Frames of one figure as a GIF."""

from collections.abc import Iterable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

COLORS = 128


def write_gif(frames: Iterable[Figure], path: Path, milliseconds: int) -> None:
    """Writes the frames, which are one figure for all, as a GIF that starts over at its end."""
    pictures: list[Image.Image] = []
    for figure in frames:
        figure.canvas.draw()
        # The layout of the first frame holds for all.
        figure.set_layout_engine("none")
        pictures.append(Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3]))
    plt.close(figure)
    # All frames share the colors of the last, when everything has been drawn: nothing flickers.
    colors = pictures[-1].quantize(COLORS, method=Image.Quantize.MAXCOVERAGE)
    pictures = [picture.quantize(palette=colors, dither=Image.Dither.NONE) for picture in pictures]
    pictures[0].save(
        path, save_all=True, append_images=pictures[1:], duration=milliseconds, loop=0, optimize=True
    )


def cursor(axes: Axes, color: str) -> Line2D:
    """Returns a dot that runs along a curve."""
    (dot,) = axes.plot([], [], marker="o", markersize=6, color=color, markeredgecolor="white", zorder=5)
    return dot
