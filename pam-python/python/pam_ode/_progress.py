"""Progress of long calls."""

from __future__ import annotations

import importlib
from contextlib import contextmanager
from typing import Any, Callable, Iterator, Union

#: ``True`` for a bar (if ``tqdm`` is installed), ``False`` for none, or a function of (what, share from 0 to 1, text).
Progress = Union[bool, Callable[[str, float, str], Any]]


@contextmanager
def shown(progress: Progress) -> Iterator[Callable[[str, float, str], Any] | None]:
    """A function to hand to the extension; a bar is closed in the end."""
    if callable(progress):
        yield progress
        return
    if not progress:
        yield None
        return
    try:
        tqdm = importlib.import_module("tqdm.auto").tqdm
    except ImportError:
        yield None
        return
    bar = tqdm(total=1000, bar_format="{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining} {postfix}")

    def show(what: str, share: float, text: str) -> None:
        bar.set_description(what, refresh=False)
        bar.set_postfix_str(text, refresh=False)
        bar.update(max(0, round(1000 * share) - bar.n))

    try:
        yield show
    finally:
        bar.close()
