"""How figures look: colours, and axes that know the style without touching the state all of matplotlib shares."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

from ..files import write_atomic

PATH = Path(__file__).with_name("gough.mplstyle")  # for plt.style.use(PATH)

# Okabe and Ito; the same order as in gough.mplstyle (a test)
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
# small error pale, large error dark: lightness alone tells the order, also in grey and to every colour vision
ERROR_COLOURS = ("#c5d3e0", "#86b2d1", "#e0973f", "#b5402a", "#5e0b18")
# (place in 0..1, colour): closer together at small errors, because most of a path is far below its worst corner
ERROR_SCALE = tuple(((i / 4) ** 2, colour) for i, colour in enumerate(ERROR_COLOURS))
INK = "#2b333b"


@functools.cache
def _style() -> dict[str, Any]:
    from matplotlib import rc_params_from_file

    return dict(rc_params_from_file(PATH, use_default_template=False))


def new_axes(size: tuple[float, float] | None = None) -> Any:
    """Axes of a new figure in the style of gough.  No pyplot and no rcParams: it may run in any thread."""
    return new_panels(1, size)[0]


def new_panels(rows: int, size: tuple[float, float] | None = None) -> list[Any]:
    """Axes of a new figure, one below the other with the same limits; as `new_axes`."""
    return [row[0] for row in new_grid(rows, 1, size)]


def new_grid(rows: int, columns: int, size: tuple[float, float] | None = None, shared: bool = True) -> list[list[Any]]:
    """Axes of a new figure in rows and columns; `shared`: one y for all, one x for each column; as `new_axes`."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    style = _style()
    figure = Figure(figsize=size or style["figure.figsize"], facecolor=style["figure.facecolor"], layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(rows, columns, sharex="col" if shared else False, sharey=shared, squeeze=False)
    for ax in panels.flat:
        ax.set_prop_cycle(style["axes.prop_cycle"])
        for side in ("top", "right"):
            ax.spines[side].set_visible(style[f"axes.spines.{side}"])
        for side in ("bottom", "left"):
            ax.spines[side].set_color(style["axes.edgecolor"])
        for axis in ("x", "y"):
            ax.tick_params(axis, labelsize=style[f"{axis}tick.labelsize"], colors=style[f"{axis}tick.color"])
        ax.grid(style["axes.grid"], color=style["grid.color"], linewidth=style["grid.linewidth"])
        ax.set_axisbelow(True)
    return [list(row) for row in panels]


def label(ax: Any, title: str, x: str, y: str) -> None:
    """Title and axis labels in the style's sizes."""
    style = _style()
    ax.set_title(
        verbatim(title), loc="left", fontsize=style["axes.titlesize"], weight=style["axes.titleweight"], color=INK
    )
    ax.set_xlabel(x, fontsize=style["axes.labelsize"], color=style["axes.labelcolor"])
    ax.set_ylabel(y, fontsize=style["axes.labelsize"], color=style["axes.labelcolor"])


def legend(ax: Any, **options: Any) -> None:
    """A legend in the style's size."""
    style = _style()
    ax.legend(fontsize=style["legend.fontsize"], frameon=style["legend.frameon"], **options)


def legend_above(ax: Any) -> None:
    """A legend in one row over the right end of the axes, where no line is."""
    ncols = max(1, len(ax.get_legend_handles_labels()[1]))
    legend(
        ax,
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=ncols,
        borderaxespad=0.2,
        handlelength=1.2,
        columnspacing=1.2,
    )


def save(ax: Any, path: str | Path) -> Path:
    """Write the figure of some axes as PNG; folders that are missing are made.  The path.

    Raises
    ------
    StorageError
        the file could not be written.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    return write_atomic(path, lambda file: ax.figure.savefig(file, dpi=_style()["savefig.dpi"], format="png"))


def verbatim(text: str) -> str:
    """A text from outside for matplotlib: a dollar is a dollar, not the start of a formula."""
    return text.replace("$", r"\$")
