"""Tables for notebooks."""

from __future__ import annotations

from html import escape
from typing import Any, Iterable, Sequence


def number(value: Any) -> str:
    """A value in few digits."""
    if value is None:
        return "–"
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value)
    return f"{value:.4g}"


def table(head: Sequence[str], rows: Iterable[Sequence[Any]], title: str = "") -> str:
    """A table; numbers stand right."""
    cells = "".join(f"<th>{escape(h)}</th>" for h in head)
    body = "".join(
        "<tr>"
        + "".join(
            f'<td style="text-align:{"right" if isinstance(c, (int, float)) else "left"}">{escape(number(c))}</td>'
            for c in row
        )
        + "</tr>"
        for row in rows
    )
    caption = f"<caption>{escape(title)}</caption>" if title else ""
    return f"<table>{caption}<thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table>"


def sparkline(values: Sequence[float], width: int = 240, height: int = 40) -> str:
    """A small line figure."""
    step = max(1, len(values) // width)
    points = [float(v) for v in values[::step]]
    low, high = min(points), max(points)
    span = (high - low) or 1.0
    scale = width / max(1, len(points) - 1)
    path = " ".join(f"{k * scale:.1f},{height - 2 - (v - low) / span * (height - 4):.1f}" for k, v in enumerate(points))
    return (
        f'<svg width="{width}" height="{height}"><polyline points="{path}" fill="none" stroke="#1f77b4"/></svg>'
    )
