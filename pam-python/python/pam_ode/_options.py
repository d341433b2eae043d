"""Options that several functions share."""

from __future__ import annotations

import os
from typing import Any, Mapping, Union

Path = Union[str, "os.PathLike[str]"]

#: A change of one setting, like ``{"search.max_causes": 4}``.
Changes = Mapping[str, Any]


def steps(
    step_ms: float | None, rtol: float | None, atol: float | None, input: str
) -> dict[str, Any]:
    """Steps and reading of the force, as the extension takes them."""
    return {"step_ms": step_ms, "rtol": rtol, "atol": atol, "input": input}


def optional_path(path: Path | None) -> str | None:
    """A path as text, if there is one."""
    return None if path is None else os.fspath(path)


def toml_value(value: Any) -> str:
    """A value in TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{k} = {toml_value(v)}" for k, v in value.items()) + " }"
    if hasattr(value, "__fspath__"):
        return toml_value(os.fspath(value))
    if hasattr(value, "tolist"):
        return toml_value(value.tolist())
    return "[" + ", ".join(toml_value(v) for v in value) + "]"


def changes(settings: Changes | None) -> list[str]:
    """Changes as the extension takes them."""
    return [f"{key}={toml_value(value)}" for key, value in (settings or {}).items()]
