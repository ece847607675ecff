"""A physical effect: a kind of the registry (``gain``), bound to a robot and perhaps to a column (``gain:thrust``).

Substitution is the hypothesis. Injection is the truth in a simulator, by its own means: masses, places and contacts of
its file, actuators, forces on its bodies. Where an effect is a law of force (drag, wind), both write that law, and what
the force does to the robot is the simulator's.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from sympy import Expr, Symbol
from torch import Tensor

from sym2real.effects.body import Body, Describable
from sym2real.effects.kind import ANYTHING, Domain, Kind, Parameter, Stage
from sym2real.effects.manoeuvres import in_words_of
from sym2real.effects.memory import Memory, series
from sym2real.effects.searching import Searching
from sym2real.errors import ModelError, UnknownNameError
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import canonical
from sym2real.symbolic.mass_normalised import unit_for

NO_COLUMN = "which is no column or quantity here"


@dataclass(frozen=True)
class Effect:
    """A kind, bound to a body and perhaps a column.

    Args:
        of: the kind.
        body: what the effect may know about the robot; names the column.
        group: keys, or patterns of keys, that may stand for this effect.
    """

    of: Kind
    body: Body
    group: tuple[str, ...] = field(default=())

    @property
    def kind(self) -> str:
        """Name of the kind."""
        return self.of.name

    @property
    def column(self) -> str:
        """The column that it is bound to, or ""."""
        return self.body.column

    @property
    def key(self) -> str:
        """What a user types and a report prints."""
        return f"{self.kind}:{self.column}" if self.column else self.kind

    @property
    def stage(self) -> Stage:
        """Where it acts."""
        return self.of.stage

    @property
    def shown_by(self) -> str:
        """Which manoeuvre shows it, with the commands that the robot has."""
        return in_words_of(self.body.layouts.action, self.of.shown_by)

    @property
    def searching(self) -> Searching:
        """How it takes part in a search."""
        return self.of.searching

    @property
    def stood_for_by(self) -> str:
        """Key of the effect that it equals on every flight, and that a search tries in its place; "" for none."""
        return self.of.searching.stood_for_by(self.body)

    @property
    def fix(self) -> str:
        """What to change on the robot or in the model."""
        return self.of.fix

    @property
    def given(self) -> float | None:
        """What the equations hold of the parameter that it is bound to; None of an effect of anything else."""
        return self.body.parameters.get(self.column)

    @property
    def scaled(self) -> tuple[str, float] | None:
        """What its value multiplies, and what that is: the parameter that it is bound to, or a number of the robot."""
        if self.given is not None:
            return self.column, self.given
        number = self.body.numbers.get(self.of.scales)
        return None if number is None else (self.of.scales, number)

    @cached_property
    def memory(self) -> Memory:
        """The recursion of an effect with memory.

        Raises:
            ModelError: when the effect has none.
        """
        if self.of.memory is None:
            raise ModelError(f"{self.key} has no memory: it is in the equations, not a filter")
        return self.of.memory(self.body)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Its numbers, with units, bounds and null values for this robot."""
        return tuple(
            replace(parameter, unit=unit_for(self.body, parameter.unit)) for parameter in self.of.parameters(self.body)
        )

    @property
    def null(self) -> dict[str, float]:
        """Values at which the effect does nothing."""
        return {parameter.name: parameter.null for parameter in self.parameters}

    def symbols(self) -> dict[str, Symbol]:
        """One symbol per parameter, named after effect, column and parameter: what a fit puts in."""
        stem = f"{self.kind}_{self.column}" if self.column else self.kind
        return {parameter.name: symbol(f"{stem}_{parameter.name}") for parameter in self.parameters}

    def why_not(self, described: Describable) -> str:
        """Why the effect cannot be had on these equations, or this robot; "" where it can."""
        body = Body.of(described, self.column)
        fits = self.of.fits(body)
        if not fits and self.of.robot != "both":
            return f"{self.kind} is an effect of a {self.of.robot}"
        missing = [name for name in self._bound(self.of.needs) if name not in body.names]
        if missing:
            return f"{self.key} needs {', '.join(missing)}, {NO_COLUMN}"
        missing = [name for name in self._bound(self.of.numbers) if name not in body.numbers]
        if missing:
            numbers = f"{self.key} needs the robot's {', '.join(missing)}, which is not among the numbers here"
            return f"{numbers} (`sym2real nominal`, `learn --numbers` and `Equations.parse(numbers=…)` take it)"
        if not fits:
            return f"{self.kind} is an effect of a body that moves in space or in a plane"
        if any(name in body.names for name in self.of.hidden):
            return f"{self.key} is in these equations already, with a state of its own that they can have once"
        return ""

    def _bound(self, names: Iterable[str]) -> list[str]:
        return [name.format(column=self.column, heading=self.body.heading) for name in names]

    def applies(self, equations: Equations) -> bool:
        """Whether the quantities and numbers that the effect needs exist; :meth:`why_not` says which do not."""
        return not self.why_not(equations)

    def values(self, given: Mapping[str, Expr | float]) -> dict[str, Expr]:
        """An expression for every parameter, null where none is given.

        Raises:
            UnknownNameError: for a parameter that the effect does not have.
            ModelError: for numbers that no such effect can have.
        """
        names = [parameter.name for parameter in self.parameters]
        for name in given:
            if name not in names:
                raise UnknownNameError(f"parameter of {self.key!r}", name, names)
        values = {parameter.name: self._value(parameter, given) for parameter in self.parameters}
        wrong = self.of.contradiction({name: float(value) for name, value in values.items() if value.is_number})
        if wrong:
            raise ModelError(f"{self.key}: {wrong}")
        return values

    def _value(self, parameter: Parameter, given: Mapping[str, Expr | float]) -> Expr:
        value = given.get(parameter.name, parameter.null)
        if getattr(value, "is_number", True) and not _is_in(parameter.domain, value):
            unit = "" if parameter.unit == "1" or parameter.domain == ANYTHING else f" {parameter.unit}"
            raise ModelError(f"{self.key}: expected {parameter.domain}{unit} for {parameter.name}, found {value}")
        return canonical(value)

    def require_fittable(self, equations: Equations) -> None:
        """Refuse an effect whose values no logs could say.

        What is a choice (which rotor) or differs from log to log (a phase) has no derivative that a fit could follow.

        Raises:
            ModelError: when it does not apply, with the reason, or for parameters that cannot be fitted.
        """
        reason = self.why_not(equations)
        if reason:
            raise ModelError(reason)
        chosen = (fixed for fixed in self.parameters if fixed.per_log or (not fixed.fitted and fixed.null != 0.0))
        cannot = ", ".join(parameter.name for parameter in chosen)
        if cannot:
            raise ModelError(f"{self.key}: expected values, found logs; its {cannot} cannot be fitted")

    def substitute(self, equations: Equations, values: Mapping[str, Expr | float]) -> Equations:
        """The equations with the effect in them; an effect with memory goes to their filters.

        Args:
            equations: without effects that stand further from the dynamics (see
                :func:`sym2real.effects.composing.compose`, which orders several).
            values: by parameter name, numbers or expressions over the equations' names; symbols that the equations
                do not have become parameters, of the null value where the expression is that symbol alone.

        Raises:
            ModelError: when the effect does not apply, with the reason.
        """
        from sym2real.effects.composing import compose  # noqa: PLC0415 — parts are composed, and compose substitutes

        return compose(equations, [(self, values)])

    def filter(self, rows: Tensor, dt: float, values: Mapping[str, Tensor | float]) -> Tensor:
        """A whole series of commands, or of measurements, through an effect with memory.

        Args:
            rows: action or measured state columns ``# (..., T, columns)``; the series starts in rest at its first row.
            dt: in s.
            values: tensors of any batch shape ``# (...)``, which broadcasts with that of the rows.

        Raises:
            ModelError: when the effect has no memory.
        """
        wanted = {parameter.name: values.get(parameter.name, parameter.null) for parameter in self.parameters}
        return series(self.memory, rows, dt, wanted, self.filtered_columns)

    @property
    def filtered_columns(self) -> list[int]:
        """Positions of the columns that an effect with memory acts on."""
        if self.of.columns == "state":
            return [self.body.layouts.state.index(self.column)]
        return self.body.action_indices()

    def inject(self, **values: float) -> Change:
        """The effect as a change of a simulated robot, by MuJoCo's own means.

        Raises:
            UnknownNameError: for a parameter that the effect does not have.
            ModelError: when the robot's numbers do not suffice.
        """
        known = self.values(dict(values))
        numbers = {name: float(value) for name, value in known.items()}
        shown = ", ".join(f"{name} {value:g}" for name, value in values.items())
        change = Change("") if numbers == self.null else self.of.inject(self.body, numbers)
        return replace(change, name=f"{self.key} {shown}".strip())


def _is_in(domain: Domain, value: Expr | float) -> bool:
    """False also for what is no real number."""
    try:
        return float(value) in domain
    except (TypeError, ValueError):
        return False
