"""A pytest plugin: tests run in the order in which they are named, whatever a ``conftest.py`` makes of it."""

from __future__ import annotations

import pytest


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Sort by the place of a test's name among the arguments."""
    place = {name: number for number, name in enumerate(config.args)}
    items.sort(key=lambda item: place.get(item.nodeid, len(place)))
