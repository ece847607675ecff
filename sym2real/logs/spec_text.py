"""A log specification as a TOML text, with room for comments that explain a proposal."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from sym2real.logs.parts import ATTITUDES, Source

if TYPE_CHECKING:
    from sym2real.logs.specification import LogSpec

TABLES = ("time", "columns", *ATTITUDES)


def text(value: object) -> str:
    """A TOML value: JSON's strings, numbers and lists are TOML's too."""
    if isinstance(value, Source):
        entries = _entries(value)
        return f"{{ {', '.join(entries)} }}" if len(entries) > 1 else text(value.column)
    return json.dumps(list(value) if isinstance(value, tuple) else value, ensure_ascii=False)


def specification(spec: LogSpec, comments: Mapping[str, Sequence[str]] | None = None) -> str:
    """The TOML text of a specification.

    Args:
        spec: the specification; what has its default value is left out.
        comments: lines, without ``#``, that follow the key they are filed under: "" (the top), a top-level key,
            a table's name or a standard column.
    """
    notes = comments or {}
    lines = [*_commented(notes, "")]
    for name in (field.name for field in fields(spec) if field.name not in TABLES):
        if name == "name" or _changed(spec, name):
            lines.append(f"{name} = {text(getattr(spec, name))}")
        lines += _commented(notes, name)
    lines += ["", "[time]", *_entries(spec.time), *_commented(notes, "time")]
    lines += ["", "[columns]"]
    for column, source in spec.columns.items():
        key = column if column.isascii() and column.replace("_", "").isalnum() else text(column)
        lines += [f"{key} = {text(source)}", *_commented(notes, column)]
    lines += _commented(notes, "columns")
    for name in ATTITUDES:
        if getattr(spec, name).sources:
            lines += ["", f"[{name}]", *_entries(getattr(spec, name)), *_commented(notes, name)]
    return "\n".join(lines) + "\n"


def _changed(value: Any, name: str) -> bool:
    return bool(getattr(value, name) != getattr(type(value), name))  # the class has the defaults


def _entries(part: Any) -> list[str]:
    return [
        f"{field.name} = {text(getattr(part, field.name))}"
        for field in fields(part)
        if getattr(part, field.name) not in (None, "", ()) and (field.name == "column" or _changed(part, field.name))
    ]


def _commented(notes: Mapping[str, Sequence[str]], key: str) -> list[str]:
    return [f"# {line}" if line else "#" for line in notes.get(key, ())]
