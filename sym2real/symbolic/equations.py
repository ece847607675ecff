"""Equations of one control period: the object that is learned, substituted into, printed, compiled and fitted."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any

from sympy import Expr

from sym2real.errors import ModelError, UnknownNameError
from sym2real.layout import Layouts
from sym2real.symbolic import printing
from sym2real.symbolic.expressions import canonical, exchange, names_in, require_names, symbol
from sym2real.symbolic.node_count import complexity
from sym2real.symbolic.parsing import parse_expression
from sym2real.symbolic.predicting import Predicting
from sym2real.symbolic.serialise import Origin, read_equations, write_equations
from sym2real.symbolic.shared_parts import REMEMBERED

EMPTY: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True, eq=False, repr=False)
class Equations(Predicting):
    """Next state after ``dt``, one expression per state column over state, action, inputs and parameters.

    Args:
        next: column → expression, for every state column.
        layouts: the columns that expressions may use.
        dt: control period in s.
        output: state column → what the sensors report of it; identity where absent.
        quantities: derived names (thrust of four motors) that the equations use like a column; effects bind to them.
        parameters: symbol that is neither column nor number → its value.
        robot: name of the robot, if it is a known one.
        notes: remarks for people ("wrench: approximate").
        numbers: the nominal robot's numbers that effects need, SI units: ``mass``, ``jx``, ``kx``, ``wheelbase`` …
        filters: what acts on whole series of commands or measurements, outside the equations, in the order in which
            a signal meets it: key of the effect and its values, over ``parameters``.
        start: hidden state column → its first value, over state, action, inputs and parameters.
        effects: physical effects that were put in, key and values in SI units, the first one first and what went in
            together from the dynamics outwards: nothing in an expression says that a mass was once smaller.
        origin: what makes the robot again, of one that no registry knows.

    Raises:
        UnknownNameError: when an expression uses a name that is none of these.
        ModelError: when a state column has no equation, or an expression is no finite real one.

    Examples:
        >>> layouts = Layouts.of(["x", "vx", "speed"])
        >>> equations = {"x": "x + 0.1*vx", "vx": "vx + 0.1*(speed - vx)/tau"}
        >>> model = Equations.parse(layouts, equations, dt=0.1, parameters={"tau": 0.5})
        >>> model.predict(np.array([0.0, 1.0]), np.array([2.0]))
        array([0.1, 1.2])
    """

    next: Mapping[str, Expr]
    layouts: Layouts
    dt: float
    output: Mapping[str, Expr] = field(default_factory=dict)
    quantities: Mapping[str, Expr] = field(default_factory=dict)
    parameters: Mapping[str, float] = field(default_factory=dict)
    robot: str = ""
    notes: tuple[str, ...] = ()
    numbers: Mapping[str, float] = field(default_factory=dict)
    filters: tuple[tuple[str, Mapping[str, Expr]], ...] = ()
    start: Mapping[str, Expr] = field(default_factory=dict)
    effects: tuple[tuple[str, Mapping[str, float]], ...] = ()
    origin: Origin | None = None

    def __post_init__(self) -> None:
        parameters = _finite("parameter", self.parameters)
        self._set("parameters", parameters)
        require_names([*self.columns, *self.quantities, *parameters])
        state = self.layouts.state
        for name in (*self.next, *self.output, *self.start):
            state.index(name)
        missing = [column for column in state if column not in self.next]
        if missing:
            raise ModelError(f"expected an equation for every state column, found none for {', '.join(missing)}")
        if not (math.isfinite(self.dt) and self.dt > 0.0):
            raise ModelError(f"expected a time step dt > 0 s, found {self.dt!r}")
        self._set("dt", float(self.dt))
        self._set("next", {column: self._checked(column, self.next[column]) for column in state})
        self._set("output", {c: self._checked(c, self.output[c]) for c in state if c in self.output})
        self._set("quantities", {name: self._checked(name, value) for name, value in self.quantities.items()})
        self._set("notes", tuple(self.notes))
        self._set("numbers", _finite("number", self.numbers))
        self._set("start", {c: self._checked(c, self.start[c]) for c in state if c in self.start})
        filters = [
            (key, {n: self._checked(f"{key} {n}", v) for n, v in values.items()}) for key, values in self.filters
        ]
        self._set("filters", tuple((str(key), MappingProxyType(values)) for key, values in filters))
        known = [(key, _finite(f"{key}:", values)) for key, values in self.effects]
        self._set("effects", tuple((str(key), MappingProxyType(values)) for key, values in known))
        hidden = [
            column for field in state.fields if field.hidden for column in field.columns if column not in self.start
        ]
        if hidden:
            raise ModelError(f"no start for the hidden state column{'s' * (len(hidden) > 1)} {', '.join(hidden)}")

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, MappingProxyType(value) if isinstance(value, dict) else value)

    def _checked(self, name: str, expression: Expr) -> Expr:
        try:
            expression = canonical(expression)
            for used in sorted(names_in(expression) - self._known):
                raise UnknownNameError(f"symbol in the equation of {name!r}", used, self.names)
        except ModelError as error:
            raise ModelError(f"equation of {name!r}: {error}") from error
        return expression

    @property
    def columns(self) -> tuple[str, ...]:
        """State, action and input columns."""
        return self.layouts.columns

    @property
    def names(self) -> tuple[str, ...]:
        """Every name that an expression may use."""
        return (*self.columns, *self.quantities, *self.parameters)

    @cached_property
    def _known(self) -> frozenset[str]:
        """The same to look up: of a robot of six joints they are hundreds, and every expression is checked."""
        return frozenset(self.names)

    @classmethod
    def parse(
        cls,
        layouts: Layouts,
        equations: Mapping[str, str],
        dt: float,
        *,
        output: Mapping[str, str] = EMPTY,
        quantities: Mapping[str, str] = EMPTY,
        start: Mapping[str, str] = EMPTY,
        filters: Iterable[tuple[str, Mapping[str, str]]] = (),
        **others: Any,
    ) -> Equations:
        """Equations from text (Python syntax, see :mod:`sym2real.symbolic.parsing`).

        Args:
            layouts, dt: as of the class, and so are ``others``: ``parameters``, ``robot``, ``notes``, ``numbers``,
                ``effects``, ``origin``.
            equations: state column → text of its next value.
            output, quantities, start, filters: as of the class, in text.

        Raises:
            ModelError: for text that is not an expression, with the name of the equation.
            UnknownNameError: for names that are no column, quantity or parameter.
        """

        def read(source: Mapping[str, str]) -> dict[str, Expr]:
            return {name: _parsed(name, written) for name, written in source.items()}

        return cls(
            next=read(equations),
            layouts=layouts,
            dt=dt,
            output=read(output),
            quantities=read(quantities),
            start=read(start),
            filters=tuple((key, read(values)) for key, values in filters),
            **others,
        )

    def __repr__(self) -> str:
        return printing.summary(self)

    def _repr_latex_(self) -> str:
        return r"$\displaystyle \begin{aligned}" + r" \\ ".join(printing.latex_lines(self)) + r"\end{aligned}$"

    def text(self) -> str:
        """All equations, one a line, in the syntax that :meth:`parse` reads."""
        return printing.as_text(self)

    def latex(self) -> dict[str, str]:
        """LaTeX of every quantity, of the next value of every state column, and of what is measured where that differs.

        Keys are names of quantities, state columns, and ``measured …``.
        """
        return printing.as_latex(self)

    def complexity(self) -> dict[str, int]:
        """State column → nodes of its equation; a quantity counts as one variable."""
        return {column: complexity(expression) for column, expression in self.next.items()}

    def depends(self, output: str, input: str) -> bool:  # the design's name
        """Whether the next value of state column ``output`` uses the name ``input``, also through quantities.

        Raises:
            UnknownNameError: when there are no such names.
        """
        self.layouts.state.index(output)
        if input not in self.names:
            raise UnknownNameError("symbol", input, self.names)
        seen, waiting = set[str](), [self.next[output]]
        while waiting:
            used = names_in(waiting.pop()) - seen
            seen |= used
            waiting += [self.quantities[name] for name in used if name in self.quantities]
        return input in seen

    def substitute(
        self, replacements: Mapping[str, Expr | float], parameters: Mapping[str, float] = EMPTY
    ) -> Equations:
        """Every symbol replaced in all equations at once; a replacement may contain the symbol itself.

        Args:
            replacements: name → expression over names and ``parameters``.
            parameters: new parameters that the replacements bring.

        Raises:
            UnknownNameError: when a name to replace does not exist.
        """
        for name in replacements:
            if name not in self.names:
                raise UnknownNameError("symbol", name, self.names)
        replaced = exchange({symbol(name): canonical(value) for name, value in replacements.items()})

        def put_in(expressions: Mapping[str, Expr]) -> dict[str, Expr]:
            return {name: replaced(expression) for name, expression in expressions.items()}

        changed: dict[str, Any] = {
            part: put_in(getattr(self, part)) for part in ("next", "output", "quantities", "start")
        }
        filters = tuple((key, put_in(values)) for key, values in self.filters)
        return replace(self, **changed, filters=filters, parameters={**self.parameters, **parameters})

    def at(self, **values: float) -> Equations:
        """Parameters replaced by numbers.

        Raises:
            UnknownNameError: when there is no such parameter.
        """
        for name in values:
            if name not in self.parameters:
                raise UnknownNameError("parameter", name, self.parameters)
        fixed = self.substitute({name: float(value) for name, value in values.items()})
        return replace(fixed, parameters={k: v for k, v in self.parameters.items() if k not in values})

    def __reduce__(self) -> tuple[Callable[[str], Equations], tuple[str]]:
        """For other processes, and for copies."""
        return Equations.from_json, (self.to_json(),)

    def to_json(self) -> str:
        """Text that :meth:`from_json` reads back without loss."""
        return write_equations(self)

    @classmethod
    def from_json(cls, source: str) -> Equations:
        """Equations from :meth:`to_json`'s text, which need not be trusted.

        Raises:
            ModelError: when it is not such a text.
        """
        return cls.parse(**read_equations(source))


def _finite(what: str, values: Mapping[str, float]) -> dict[str, float]:
    numbers = {str(name): float(value) for name, value in values.items()}
    for name, value in numbers.items():
        if not math.isfinite(value):
            raise ModelError(f"{what} {name!r}: expected a finite number, found {value!r}")
    return numbers


_read = lru_cache(REMEMBERED)(parse_expression)  # a model is often opened again


def _parsed(name: str, written: str) -> Expr:
    try:
        return _read(str(written))
    except ModelError as error:
        raise ModelError(f"equation of {name!r}: {error}") from error
