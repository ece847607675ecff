"""Numbers that a user gives as options."""

from __future__ import annotations

from sym2real.errors import ModelError


def require_positive(**options: float | None) -> None:
    """Refuse options that must be greater than zero; None stands for the default.

    Raises:
        ModelError: naming the option and what was found.
    """
    for name, value in options.items():
        if value is not None and not value > 0:
            raise ModelError(f"--{name.replace('_', '-')}: expected a number greater than 0, found {value:g}")
