"""Tables and small curves as HTML, in the colours of the notebook."""

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np

from governor_mechanism.types import FloatArray

CURVE_WIDTH, CURVE_HEIGHT, CURVE_MARGIN = 120, 24, 2
"""Size and margin of a small curve, pixels."""


def format_html_table(
    header: Sequence[str],
    rows: Iterable[Sequence[str]],  # cells, as text; a cell that begins with "<svg" is a picture
    *,
    n_text_columns: int = 1,  # number of first columns that are aligned to the left; the others hold numbers
) -> str:
    """Return a table."""
    head = f"<thead><tr>{_format_cells('th', header, n_text_columns)}</tr></thead>" if header else ""
    body = "".join(f"<tr>{_format_cells('td', row, n_text_columns)}</tr>" for row in rows)
    return f"<table>{head}<tbody>{body}</tbody></table>"


def format_paragraph(text: str, *, is_bold: bool = False) -> str:
    """Return a line of text."""
    content = f"<b>{escape(text)}</b>" if is_bold else escape(text)
    return f'<div style="text-align:left">{content}</div>'


def format_printed(text: str) -> str:
    """Return a printed text, with its columns aligned and a bar to scroll long lines."""
    # JupyterLab shows a plain <pre> of a result in a proportional font.
    style = "white-space:pre;overflow-x:auto;line-height:1.3;font-family:Menlo,'DejaVu Sans Mono',Consolas,'Courier New',monospace"
    return f'<pre style="{style}">{escape(text)}</pre>'


def draw_small_curve(
    values: FloatArray,  # values; shape (n,). Those that are not finite are left out
    noise: float,
) -> str:
    """Return a curve over equal steps without axes.

    Result: a picture as SVG; empty without two finite values.
    """
    finite = np.flatnonzero(np.isfinite(values))
    if len(finite) < 2:
        return ""
    # Extremes of as many groups as there are pixels, so that the curve of a fast oscillation keeps its height.
    groups = np.array_split(finite, min(CURVE_WIDTH, len(finite)))
    extremes = [index for group in groups for index in (group[np.argmin(values[group])], group[np.argmax(values[group])])]
    shown = np.unique([finite[0], *extremes, finite[-1]])
    low, high = float(values[finite].min()), float(values[finite].max())
    half = max(0.5 * (high - low), noise) or 1.0
    height = CURVE_HEIGHT - 2 * CURVE_MARGIN
    x = CURVE_MARGIN + (CURVE_WIDTH - 2 * CURVE_MARGIN) * shown / (len(values) - 1)
    y = CURVE_HEIGHT / 2 - 0.5 * height * (values[shown] - 0.5 * (low + high)) / half
    points = " ".join(f"{px:.1f},{py:.1f}" for px, py in zip(x, y, strict=True))
    line = f'<polyline points="{points}" fill="none" stroke="currentColor" stroke-width="1.2"/>'
    return f'<svg width="{CURVE_WIDTH}" height="{CURVE_HEIGHT}" role="img">{line}</svg>'


def _format_cells(tag: str, cells: Sequence[str], n_text_columns: int) -> str:
    """Return the cells of a row."""
    texts = (cell if cell.startswith("<svg") else escape(cell) for cell in cells)
    sides = ("left" if k < n_text_columns else "right" for k in range(len(cells)))
    return "".join(f'<{tag} style="text-align:{side}">{text}</{tag}>' for side, text in zip(sides, texts, strict=True))
