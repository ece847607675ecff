"""Which effects compete in a diagnosis, and why each of the others does not: what was not tried is not refuted."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import asdict, dataclass
from fnmatch import fnmatch
from itertools import groupby

import numpy as np

from sym2real.diagnosis.predict.library import Library
from sym2real.effects import Effect
from sym2real.effects.catalogue import known
from sym2real.effects.groups import unnamed
from sym2real.errors import ModelError
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset

# Why a search leaves an effect out, by pattern of its key.
SETTLED = "settled by the checks of the data before the search"
ALONE = "not searched for; `sym2real add MODEL EFFECT --fit LOG` tests it alone"
NOT_SEARCHED = {
    "sensor_lag:*": "not searched for: the checks of the data see it as a time shift",
    "sensor_*": SETTLED,
    "time_shift*": SETTLED,
    "payload": "added_mass and com_offset stand for it together",
    "rate_damping": "rate_loop_gain and the gains of the rate commands stand for it together",
    "*:q?_cmd": "a component of a quaternion is no command of its own",
    **dict.fromkeys(("rotor_reaction", "rate_limit", "dead_band"), ALONE),
    **dict.fromkeys((f"{kind}:{on}" for kind in ("rate_limit", "dead_band") for on in ("w*", "thrust")), ALONE),
    **dict.fromkeys(("limit:w*", "limit:motor*", "rate_limit:motor*", "dead_band:motor*"), ALONE),
    **dict.fromkeys((f"{kind}:motor*" for kind in ("lag", "delay", "gain", "offset")), ALONE),
}
# Equal to another on every flight: the other stands for them.
STANDS_FOR = {
    "added_mass": ("gain:thrust",),
    "torque_bias": ("offset:w?_cmd",),
    "wind": ("slope",),
    "gain:steer": ("wheelbase",),
}
EXCLUDED = "excluded on request"
STILL = 1e-9
MOST_BRACED = 4  # columns of a kind that a line names one by one


@dataclass(frozen=True)
class NotTried:
    """An effect that took no part in a search, and why."""

    effect: str
    reason: str

    def to_dict(self) -> dict[str, str]:
        """An entry of ``not_tried`` in ``diagnosis.json``."""
        return asdict(self)


def competing(
    equations: Equations, data: Dataset, exclude: Collection[str] = ()
) -> tuple[tuple[str, ...], tuple[NotTried, ...]]:
    """Keys of the effects of such a robot that compete on this data, and all others."""
    reasons = {one.key: _why_not(one, equations, data, exclude) for one in known(equations)}
    for key, others in STANDS_FOR.items():
        if reasons.get(key) == "":
            alike = (other for other in reasons if any(fnmatch(other, pattern) for pattern in others))
            reasons |= {other: reasons[other] or f"{key} stands for it: no flight tells them apart" for other in alike}
    left = {key for key, reason in reasons.items() if not reason}
    reasons |= {
        key: f"{by} stands for it: in these logs {why}"
        for key, (by, why) in unnamed(left, data).items()
        if not reasons.get(key, "-")
    }
    keys = tuple(key for key, reason in reasons.items() if not reason)
    return keys, tuple(NotTried(key, reason) for key, reason in reasons.items() if reason)


def _why_not(one: Effect, equations: Equations, data: Dataset, exclude: Collection[str]) -> str:
    """Why an effect does not compete; "" where it does."""
    if any(fnmatch(one.key, pattern) for pattern in exclude):
        return EXCLUDED
    reason = next((why for pattern, why in NOT_SEARCHED.items() if fnmatch(one.key, pattern)), "")
    reason = reason or one.why_not(equations).removeprefix(f"{one.key} ")
    if not reason and one.column in data.layouts.action:
        values = np.concatenate([trajectory.column(one.column) for trajectory in data])
        # Commands are as sent, without noise: one that never varies shows nothing of its map.
        reason = f"{one.column} never varies in these logs" if float(np.std(values)) < STILL else ""
    return reason or _refused(one, equations)


def _refused(one: Effect, equations: Equations) -> str:
    """Why the equations cannot be given an effect that has all it names: a push without a place, a number for that."""
    try:
        Library.of(equations, [one])
    except ModelError as error:
        return str(error)
    return ""


def not_tried_said(left_out: Iterable[NotTried]) -> Iterator[str]:
    """A line for every reason, with the effects that it holds for."""
    ordered = sorted(left_out, key=lambda one: one.reason)
    for reason, same in groupby(ordered, key=lambda one: one.reason):
        kinds: dict[str, list[str]] = {}
        for one in same:
            kind, _, column = one.effect.partition(":")
            kinds.setdefault(kind, []).append(column)
        yield f"{', '.join(_keys(kind, columns) for kind, columns in kinds.items())}: {reason}"


def _keys(kind: str, columns: list[str]) -> str:
    named = [column for column in columns if column]
    if len(columns) == 1 or not named:
        return f"{kind}:{columns[0]}" if named else kind
    return f"{kind}:{{{','.join(named)}}}" if len(columns) <= MOST_BRACED else f"{kind}:*"
