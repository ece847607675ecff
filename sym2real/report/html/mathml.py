"""Expressions as MathML, which browsers draw without help; marked symbols bring their whole term into colour."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import sympy
from markupsafe import Markup
from sympy import Add, Expr, Piecewise, Symbol
from sympy.printing.mathml import MathMLPresentationPrinter

from sym2real.report.tables import rounded


def mathml(expression: Expr, marked: Collection[Symbol] = (), names: Mapping[str, str] | None = None) -> Markup:
    """An expression with its numbers to four digits, a sum in terms between which a line may end.

    Args:
        expression: what is printed.
        marked: symbols; the smallest terms with one of them get the class "new".
        names: what symbols are called, by their own name; a part behind a "|" stands below.
    """
    printer = _Printer(frozenset(marked), names or {})
    short = rounded(expression)
    terms = short.as_ordered_terms() if isinstance(short, Add) else [short]
    return Markup(" ").join(_term(printer, term, first=not place) for place, term in enumerate(terms))


def _term(printer: _Printer, term: Expr, *, first: bool) -> Markup:
    negative = term.could_extract_minus_sign()
    sign = "−" if negative else "" if first else "+"
    body = printer.doprint(-term if negative else term)
    operator = f"<mo form='infix'>{sign}</mo>" if sign else ""
    is_new = bool(printer.marked & term.free_symbols)
    attribute = ' class="new"' if is_new else ""
    return Markup(f"<math{attribute}><mrow>{operator}{body}</mrow></math>")


class _Printer(MathMLPresentationPrinter):  # type: ignore[misc]
    """SymPy's printer with our names for symbols."""

    def __init__(self, marked: frozenset[Symbol], names: Mapping[str, str]) -> None:
        super().__init__({"mul_symbol": "dot"})
        self.marked, self._names = marked, names

    def _print_Symbol(self, sym: Symbol, style: str = "plain") -> Any:  # noqa: N802 — as SymPy names it
        del style
        name, _, below = self._names.get(sym.name, sym.name).partition("|")
        element = self._element("mi", name)
        if below:
            element = self._element("msub", element, self._element("mtext", below))
        if sym in self.marked:
            element.setAttribute("class", "symbol")
        return element

    def _print_Piecewise(self, expr: Piecewise) -> Any:  # noqa: N802 — as SymPy names it
        rows = []
        for value, condition in expr.args:
            when = self._element("mtext", "otherwise") if condition == sympy.true else self._print(condition)
            cells = (self._element("mtd", part) for part in (self._print(value), when))
            rows.append(self._element("mtr", *cells))
        return self._element("mrow", self._element("mo", "{"), self._element("mtable", *rows))

    def _element(self, tag: str, *inside: Any) -> Any:
        """An element with texts or other elements inside."""
        element = self.dom.createElement(tag)
        for part in inside:
            element.appendChild(self.dom.createTextNode(part) if isinstance(part, str) else part)
        return element
