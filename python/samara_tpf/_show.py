"""How results look in a notebook: a heading, tables, figures. What comes from files is escaped."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

# Colours are the notebook's own, dark or light; what is too wide scrolls.
_SCROLLS = "overflow-x: auto; max-width: 100%"
_NUMBER = "text-align: right; white-space: nowrap; padding: 0.1em 0.5em"
_WORDS = "text-align: left; padding: 0.1em 0.5em"


def shown(heading: str, sentence: str | None, *parts: str) -> str:
    """A result: what it is, what was decided, and the parts below."""
    said = f"<br>{escape(sentence)}" if sentence else ""
    return f"<div><p><strong>{escape(heading)}</strong>{said}</p>{''.join(parts)}</div>"


def facts(rows: Mapping[str, object]) -> str:
    """Quantities below each other, each with its value; what there is not (``None``) is left out."""
    lines = (f"<tr>{_head(name)}{_cell(value, _WORDS)}</tr>" for name, value in rows.items() if value is not None)
    return _table("".join(lines))


def table(columns: Mapping[str, Sequence[Any] | np.ndarray[Any, Any]], caption: str = "", ends: int = 5) -> str:
    """A table of columns; of a long one so many rows of its beginning and of its end."""
    count = min(map(len, columns.values()), default=0)
    is_cut = count > 2 * ends
    rows = [*range(ends), None, *range(count - ends, count)] if is_cut else range(count)
    is_number = [count > 0 and isinstance(column[0], int | float | np.number) for column in columns.values()]
    sides = [_NUMBER if number else _WORDS for number in is_number]

    def line(row: int | None) -> str:
        cells = zip(columns.values(), sides, strict=True)
        return "".join(_cell("..." if row is None else column[row], side) for column, side in cells)

    body = "".join(f"<tr>{line(row)}</tr>" for row in rows)
    head = "".join(map(_head, columns, sides))
    named = f'<caption style="{_WORDS}">{escape(caption)}</caption>' if caption else ""
    return _table(f"{named}<thead><tr>{head}</tr></thead><tbody>{body}</tbody>")


def figure(svg: str | None) -> str:
    """A drawing of the program's, no wider than the notebook; none where there is none."""
    within = '<svg style="max-width: 100%; height: auto" '
    return "" if svg is None else f'<div style="{_SCROLLS}">{svg.replace("<svg ", within, 1)}</div>'


def shares(samples: Mapping[str, np.ndarray[Any, Any]], label: str) -> str:
    """Shares of samples at or below a value, as steps; a line that ends below 1 has values that are not finite.

    The first line is solid, the others are dashed; in the colour of the text.
    """
    finite = {name: np.sort(values[np.isfinite(values)]) for name, values in samples.items()}
    every = np.concatenate([np.empty(0), *finite.values()])
    if not len(every):
        return ""
    low, high = float(every.min()), float(every.max())
    width, height, span = 420.0, 160.0, (high - low) or 1.0

    def path(name: str) -> str:
        values = finite[name]
        across = (values - low) / span * width
        up = height * (1.0 - np.arange(len(values) + 1) / len(samples[name]))
        # At most as many steps as can be seen.
        kept = np.unique(np.linspace(0, len(values) - 1, min(len(values), 500)).astype(int))
        return f"M0 {height:g}" + "".join(f"H{across[i]:.1f}V{up[i + 1]:.1f}" for i in kept) + f"H{width:g}"

    lines = "".join(
        f'<path d="{path(name)}" stroke-dasharray="{"4 3" if i else "none"}"><title>{escape(name)}</title></path>'
        for i, name in enumerate(finite)
        if len(finite[name])
    )
    key = ", ".join(f"{name} {'dashed' if i else 'solid'}" for i, name in enumerate(finite))
    return (
        f'<svg width="480" height="215" viewBox="-40 -12 480 215" fill="none" stroke="currentColor">'
        f'<path d="M0 0V{height:g}H{width:g}" stroke-opacity="0.5"/>{lines}'
        '<g fill="currentColor" stroke="none" font-size="12">'
        f'<text x="-6" y="4" text-anchor="end">1</text><text x="-6" y="{height:g}" text-anchor="end">0</text>'
        f'<text x="0" y="{height + 16:g}">{low:.4g}</text>'
        f'<text x="{width:g}" y="{height + 16:g}" text-anchor="end">{high:.4g}</text>'
        f'<text x="{width / 2:g}" y="{height + 34:g}" text-anchor="middle">share of the trials at or below a '
        f"{escape(label)}: {escape(key)}</text></g></svg>"
    )


def folded(title: str, text: str) -> str:
    """A text as it is, which opens by a click."""
    return f'<details><summary>{escape(title)}</summary><pre style="{_SCROLLS}">{escape(text)}</pre></details>'


def _table(lines: str) -> str:
    return f'<div style="{_SCROLLS}"><table>{lines}</table></div>'


def _head(name: str, side: str = _WORDS) -> str:
    return f'<th style="{side}">{escape(name)}</th>'


def _cell(value: Any, side: str) -> str:
    """A cell: numbers at 6 digits, yes or no; nothing where there is no number."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "<td></td>"
    if isinstance(value, bool):
        value = "yes" if value else "no"
    return f'<td style="{side}">{f"{value:.6g}" if isinstance(value, float) else escape(str(value))}</td>'
