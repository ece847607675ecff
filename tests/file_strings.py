"""Every place of a file where an attacker can put a text: keys and values of what the package itself has written."""

from __future__ import annotations

import hashlib
import json
import math
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pyarrow as pa
import pyarrow.parquet as pq
from safetensors import safe_open
from safetensors.torch import save_file

Place = tuple[Any, ...]  # keys and indices from the outside inwards; the last is KEY where the key itself is meant
KEY = "the key itself"


def places(content: Any) -> Iterator[tuple[Place, Any]]:
    """Every key and every leaf with what stands there, numbers and flags too; texts that are JSON are opened."""
    opened = _opened(content)
    if isinstance(opened, dict):
        for key, value in opened.items():
            yield (key, KEY), key
            yield from (((key, *rest), leaf) for rest, leaf in places(value))
    elif isinstance(opened, list):
        for index, value in enumerate(opened):
            yield from (((index, *rest), leaf) for rest, leaf in places(value))
    if opened is not content or not isinstance(opened, dict | list):
        yield (), content


def is_number(value: Any) -> bool:
    """Whether it is a number, numbers in a text, or a flag."""
    try:
        return isinstance(value, bool) or all(math.isfinite(float(part)) for part in str(value).split())
    except ValueError:
        return False


def replaced(content: Any, place: Place, text: str) -> Any:
    """The content with a text at that place."""
    if not place:
        return text
    inner, (first, *rest) = _opened(content), place
    if rest == [KEY]:
        changed: Any = {text if key == first else key: value for key, value in inner.items()}
    elif isinstance(inner, dict):
        changed = {key: replaced(value, tuple(rest), text) if key == first else value for key, value in inner.items()}
    else:
        changed = [replaced(value, tuple(rest), text) if i == first else value for i, value in enumerate(inner)]
    return json.dumps(changed) if isinstance(content, str) else changed


def _opened(content: Any) -> Any:
    if isinstance(content, str) and content[:1] in ("{", "["):
        try:
            return json.loads(content)
        except ValueError:
            return content
    return content


def read(file: Path) -> Any:
    """The content of a file as mappings, lists, texts and numbers."""
    match file.suffix:
        case ".json":
            return json.loads(file.read_text())
        case ".toml":
            return tomllib.loads(file.read_text())
        case ".xml":
            return [[one.tag, dict(one.attrib), one.text or ""] for one in ElementTree.parse(file).iter()]
        case ".csv":
            return [line.split(",") for line in file.read_text().splitlines()[:2]]
        case ".parquet":
            table = pq.read_table(file)
            about = {key.decode(): value.decode() for key, value in table.schema.metadata.items()}
            return {"columns": table.column_names, "metadata": about}
        case ".safetensors":
            with safe_open(file, framework="pt") as opened:
                return opened.metadata()
    raise ValueError(f"no reader of {file.name}")


def write(file: Path, content: Any) -> None:
    """Put a changed content into a file, and right the digests that are about it: an attacker can."""
    match file.suffix:
        case ".json":
            file.write_text(json.dumps(content))
        case ".toml":
            file.write_text("\n".join(f"{json.dumps(key)} = {_inline(value)}" for key, value in content.items()))
        case ".xml":
            tree = ElementTree.parse(file)
            for one, (tag, attributes, text) in zip(tree.iter(), content, strict=True):
                one.tag, one.attrib, one.text = tag, attributes, text
            tree.write(file)
        case ".csv":
            lines = file.read_text().splitlines()[2:]
            file.write_text("\n".join([",".join(map(_cell, cells)) for cells in content] + lines))
        case ".parquet":
            table = pq.read_table(file)
            table = pa.table(dict(zip(content["columns"], table.columns, strict=True)))
            pq.write_table(table.replace_schema_metadata(content["metadata"]), file)
        case ".safetensors":
            with safe_open(file, framework="pt") as opened:
                weights = {name: opened.get_tensor(name) for name in opened.keys()}  # noqa: SIM118
            save_file(weights, file, content)
    _sign(file)


def _sign(file: Path) -> None:
    weights, inventory = file.parent / "parameters.safetensors", file.parent / "model.json"
    if file.name == "equations.json" and weights.exists():
        write(weights, {"equations": _digest(file)})
    if inventory.exists() and file != inventory:
        listed = json.loads(inventory.read_text())["files"]
        inventory.write_text(json.dumps({"files": {name: _digest(file.parent / name) for name in listed}}))


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {_inline(one)}" for key, one in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    return json.dumps(value)


def _cell(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\n') else text
