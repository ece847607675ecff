"""Name, version and licence of every package that an installation brings; fails where a needed one is not permissive.

What an extra brings may have any licence (cflib is GPL): nobody gets it without asking. ``tools/licences`` runs this.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from importlib.metadata import Distribution, PackageNotFoundError, distribution

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PROJECT = "sym2real"
LONGEST_NAME = 60  # some packages put the whole text of their licence into the field for its name
# SPDX identifiers, and the words for them that packages without an SPDX expression use.
PERMISSIVE = {
    *("0BSD", "Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "CC0-1.0", "ISC", "MIT", "MIT-CMU"),
    *("PSF-2.0", "Python-2.0", "Unlicense", "Zlib", "LLVM-exception"),
    *("Apache Software License", "BSD", "BSD License", "ISC License (ISCL)", "MIT License"),
    *("Python Software Foundation License", "The Unlicense (Unlicense)"),
}


def licence(package: Distribution) -> str:
    """The licence as the package states it: its SPDX expression, else a field of a few words, else its classifiers."""
    about = package.metadata
    if expression := about.get("License-Expression"):
        return str(expression)
    field = about.get("License") or ""
    if field and len(field) < LONGEST_NAME and "\n" not in field:
        return field
    classifiers = [line.split(" :: ")[-1] for line in about.get_all("Classifier", []) if line.startswith("License ::")]
    return " AND ".join(classifiers) or "not stated"


def permissive(text: str) -> bool:
    """Whether one of the alternatives asks for nothing but notices: in an expression, OR offers, AND and WITH add."""
    return any(
        all(part.strip(" ()") in PERMISSIVE for part in re.split(r" AND | WITH ", offered))
        for offered in text.split(" OR ")
    )


def required(name: str, extras: Iterable[str] = ()) -> set[str]:
    """Names of what a package needs here, directly or through others; of an extra only what is installed."""
    names: set[str] = set()
    waiting = [(name, frozenset(extras))]
    while waiting:
        current, chosen = waiting.pop()
        for text in distribution(current).requires or []:
            needed = Requirement(text)
            wanted = needed.marker is None or any(needed.marker.evaluate({"extra": e}) for e in {"", *chosen})
            key = canonicalize_name(needed.name)
            if wanted and key not in names and installed(key):
                names.add(key)
                waiting.append((key, frozenset(needed.extras)))
    return names


def installed(name: str) -> bool:
    """Whether the package is in this environment."""
    try:
        distribution(name)
    except PackageNotFoundError:
        return False
    return True


def main() -> None:
    """Print the table; exit with 1 and the names of what is not permissive outside the extras."""
    needed = required(PROJECT)
    extras = distribution(PROJECT).metadata.get_all("Provides-Extra", [])
    optional = {name: extra for extra in extras for name in required(PROJECT, [extra]) - needed}
    refused = []
    for name in sorted({*needed, *optional}):
        package = distribution(name)
        stated = licence(package)
        if name in needed and not permissive(stated):
            refused.append(f"{name} ({stated})")
        print(
            f"{package.name:28}{package.version:18}{'extra ' + optional[name] if name in optional else '':20}{stated}"
        )
    print(f"{len(needed)} packages needed, {len(optional)} more by the extras that are installed here")
    if refused:
        sys.exit(f"not permissive, or not stated: {', '.join(refused)}")


if __name__ == "__main__":
    main()
