"""``sym2real add``: a model with physical effects in it, at known values or as a hypothesis held against logs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from rich.console import Console

from sym2real.cli.of_logs import OfFit
from sym2real.cli.positionals import EffectTexts, JsonFile, ModelPlace
from sym2real.errors import ModelError

if TYPE_CHECKING:
    from sym2real.diagnosis import HypothesisTest
    from sym2real.effects import Effect
    from sym2real.symbolic import Equations

    Chosen = Sequence[tuple[Effect, dict[str, float]]]


@dataclass(frozen=True)
class Add(OfFit):
    """Put physical effects into a model's equations: at values you know, or fitted to logs.

    With values the effects are simply there; what is not given stays at its null value. With --fit they are a
    hypothesis ("I taped 5 g on it"): their values are fitted together, with intervals, other effects are tested in the
    place of each, and the error ladder shows what they do to predictions of logs that took no part in the fit. The
    model is written in any case: the verdict says whether to believe it. `sym2real effects NAME` says what an effect's
    parameters are.

    For example:
      sym2real add runs/base added_mass value=0.005 --out runs/heavier
      sym2real add runs/base wind fx=0.02 com_offset rx=0.001 --out runs/both
      sym2real add runs/base added_mass --fit flight1.csv flight2.csv --out runs/heavier
      sym2real add runs/base added_mass wind --fit flight1.csv flight2.csv --out runs/both
      sym2real add runs/base "term:fz=0.02*vx*vx" --out runs/term
    """

    FOLDERS: ClassVar = ("simulator",)
    OUT_IS_NEW: ClassVar = True

    model: ModelPlace
    effects: EffectTexts
    """Each effect as KIND or KIND:COLUMN, then its PARAMETER=VALUE in the unit that the catalogue gives; or a term of
    your own, as a diagnosis may propose it: term:CHANNEL=EXPRESSION over the model's columns and the time t."""
    out: Path
    """Folder of the new model; the robot with the effects as a simulator goes to OUT/simulator."""
    fit: tuple[Path, ...] = ()
    """Logs that the values of the effects are fitted to."""
    json: JsonFile = None

    def run(self, console: Console) -> dict[str, Any]:
        """Fit if asked to, compose, print, write."""
        from sym2real.cli.model import equations_below, require_another_folder
        from sym2real.cli.results import write_simulator
        from sym2real.diagnosis import add, add_term
        from sym2real.effects.catalogue import require_patterns
        from sym2real.effects.known_effects import TERM
        from sym2real.symbolic import save_model

        require_patterns(self.exclude)
        require_another_folder(self.model, self.out)
        base, about_model = equations_below(self.model, console)
        effects, terms = self._wanted(base)
        result: dict[str, Any] = {}
        if self.fit:
            test = self._fitted(base, effects, console)
            chosen, result = [(finding.effect, finding.values) for finding in test.findings], test.to_dict()
            for finding in test.findings:
                base = finding.bound(base)
        else:
            chosen = self._given(effects, console)
        changed = add(base, chosen)
        for channel, expression in terms:
            changed = add_term(changed, channel, expression)
        save_model(changed, self.out)
        for note in (note for note in changed.notes if note not in result.get("notes", ())):
            console.print(f"note: {note}", markup=False)
        names = _changed(base, changed)
        changed_names = f"changed equations: {', '.join(names)}; " if names else ""
        console.print(f"model in {self.out}; {changed_names}`sym2real show {self.out}` prints it", markup=False)
        if chosen:
            write_simulator(changed, self.out / "simulator", console)
        added: list[dict[str, Any]] = [{"effect": key, "values": values} for key, values in chosen]
        added += [{"effect": f"{TERM}{channel}", "expression": expression} for channel, expression in terms]
        about = {"notes": [*about_model, *result.get("notes", ())]} if about_model else {}
        return {"model": self.out, "effects": added, "latex": changed.latex(), **result, **about}

    def _wanted(self, base: Equations) -> tuple[Chosen, list[tuple[str, str]]]:
        """The effects with their values, and terms, each a channel and an expression."""
        from sym2real.cli.chosen import chosen_effects
        from sym2real.effects.known_effects import TERM

        terms = [text.removeprefix(TERM).partition("=") for text in self.effects if text.startswith(TERM)]
        effects = chosen_effects([text for text in self.effects if not text.startswith(TERM)], base)
        if not effects and not terms:
            raise ModelError("expected an effect and its values, found none; `sym2real effects` lists them")
        for option in ("held_out", "spec", "columns", "exclude", "horizon"):
            if getattr(self, option) and not self.fit:
                raise ModelError(f"--{option.replace('_', '-')}: expected --fit LOG… beside it, found none")
        return effects, [(channel, expression) for channel, _, expression in terms]

    def _given(self, effects: Chosen, console: Console) -> list[tuple[str, dict[str, float]]]:
        from sym2real.cli.chosen import require_values, warn_of_values

        require_values(effects, ", or --fit LOG to find it")
        warn_of_values(effects, console)
        return [(put_in.key, values) for put_in, values in effects]

    def _fitted(self, base: Equations, effects: Chosen, console: Console) -> HypothesisTest:
        from sym2real.cli.progress import stages_progress
        from sym2real.cli.results import plain_simulator
        from sym2real.diagnosis import try_effect
        from sym2real.report.diagnosis import hypothesis_report

        if not effects or any(values for _, values in effects):
            raise ModelError("--fit finds the values of effects: expected their names alone")
        data, options = self.read(base, self.fit)
        keys, simulator = [put_in.key for put_in, _ in effects], plain_simulator(base)
        with stages_progress() as on_progress:
            test = try_effect(base, keys, data, simulator, **options, on_progress=on_progress)
        console.print(hypothesis_report(test))
        return test


def _changed(base: Equations, changed: Equations) -> list[str]:
    """Names of the equations that are not the base's."""
    before = {**base.quantities, **base.next, **base.output}
    after = (*changed.quantities.items(), *changed.next.items(), *changed.output.items())
    return [name for name, expression in after if before.get(name) != expression]
