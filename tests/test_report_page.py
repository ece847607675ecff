"""What a page holds: packed numbers, errors of every combination of switches, equations, and what is read back."""

import base64
import json
import zlib
from xml.etree import ElementTree

import numpy as np
import pytest
import torch
from hypothesis import given, strategies as st
from report_pages import BASE, HOSTILE, diagnosis, logs

from sym2real import rotation
from sym2real.diagnosis import Estimate, Finding, compare, predict_windows
from sym2real.diagnosis.score.finding import applied
from sym2real.effects.along_logs import prepared
from sym2real.report.html.formulas import formulas, mathml
from sym2real.report.html.observed import observe
from sym2real.report.html.pages import comparison_page, diagnosis_page
from sym2real.report.html.render import Arrays, in_script, render
from sym2real.report.html.sentences import sentences
from sym2real.report.html.signals import signals, unwrapped
from sym2real.report.html.variants import Given, WithFindings, subsets
from sym2real.symbolic import symbol
from sym2real.symbolic.parsing import parse_expression


def one(effect: str, **values: float) -> Finding:
    return Finding(effect, {name: Estimate(value, value, value, "1") for name, value in values.items()}, 0.1)


# A quantity, a filter, a hidden state, a measurement, and more than there are switches.
EVERY_KIND = (
    one("added_mass", value=0.004),
    one("delay", value=0.03),
    one("motor_lag", value=0.02),
    one("mounting_tilt", roll=0.02, pitch=-0.01),
    one("wind", fx=0.01, fy=0.0, fz=0.0),
    one("battery_sag", value=0.01),
)


@given(st.lists(st.floats(-1e6, 1e6) | st.just(float("nan")), min_size=2, max_size=40), st.integers(1, 3))
def test_numbers_come_back_to_five_digits(values: list[float], copies: int) -> None:
    arrays, given_values = Arrays(), np.array([values] * copies) * np.arange(1, copies + 1)[:, None]
    arrays.add(np.array([1.0, 2.0]))
    assert arrays.add(given_values) == arrays.add(given_values) == 1
    found = np.array(json.loads(zlib.decompress(base64.b64decode(arrays.text)))[1], dtype=np.float64)
    np.testing.assert_allclose(found, given_values, rtol=1e-4)


@pytest.mark.slow
def test_switches_are_the_findings_and_nothing_else() -> None:
    """All off is the base, all on what ``apply`` puts into a model, in every row of every window."""
    variants, data = WithFindings(BASE, EVERY_KIND), logs()
    assert len(variants.switches) == 5
    for on in ((False,) * 5, (True, False, True, False, False), (True,) * 5):
        chosen = [found for found, is_on in zip(EVERY_KIND, (*on, on[-1]), strict=True) if is_on]
        expected, prepared_logs = prepared(applied(BASE, chosen), data)
        found, found_logs = variants.prepared(on, data)
        for log, other in zip(prepared_logs, found_logs, strict=True):
            right = predict_windows(expected, log, 20).predicted
            assert torch.allclose(predict_windows(found, other, 20).predicted, right, rtol=0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("below", [(), (one("motor_lag", value=0.2),)], ids=["plain", "with a hidden state"])
def test_errors_without_a_switch_are_those_of_the_comparison(below: tuple[Finding, ...]) -> None:
    base = applied(BASE, below)
    comparison, observed = compare(base, logs()), observe(WithFindings(base, EVERY_KIND[:1]), logs())
    points = (comparison.one_step, *comparison.horizons)
    assert observed.horizons == pytest.approx([point.horizon for point in points])
    for channel in points[0].errors:
        expected = [point.errors[channel].value for point in points]
        assert observed.by_horizon[channel][0] == pytest.approx(expected, rel=1e-9)


def test_the_true_effects_lower_the_errors() -> None:
    observed = observe(WithFindings(BASE, diagnosis().findings), logs())
    errors = observed.by_horizon["position"][:, -1]
    assert subsets(2) == [(False, False), (True, False), (False, True), (True, True)]
    assert errors[3] < 0.2 * errors[0]
    assert errors[3] < min(errors[1], errors[2])


def test_curves_begin_anew_at_measured_states() -> None:
    observed = observe(Given((BASE,)), logs())
    measured, predicted = observed.curves[0]
    gap = np.isnan(predicted[0]).all(axis=1)
    after = np.flatnonzero(gap[:-1] & ~gap[1:]) + 1
    assert list(np.diff(after)) == [40] * (len(after) - 1)
    assert np.abs(predicted[0, after, :3] - measured[after, :3]).max() < 0.02  # one step from the start, in m


@given(st.tuples(*[st.floats(-1.5, 1.5)] * 3))
def test_angles_come_back_from_a_quaternion(angles: tuple[float, float, float]) -> None:
    given_angles = torch.tensor(angles, dtype=torch.float64)
    assert rotation.to_euler(rotation.from_euler(*given_angles)).tolist() == pytest.approx(angles, abs=1e-9)


def test_a_heading_that_turns_has_no_jumps() -> None:
    layout, yaw = logs().layouts.state, torch.linspace(0.0, 10.0, 200, dtype=torch.float64)
    states = np.zeros((200, layout.size))
    zero = torch.zeros_like(yaw)
    states[:, layout.slice("attitude")] = rotation.from_euler(zero, zero, yaw).numpy()
    found = signals(layout, states)
    measured, predicted = unwrapped(layout, found, found[None] + 0.0)
    assert measured[:, 5] == pytest.approx(yaw.numpy(), abs=1e-6)
    assert predicted[0] == pytest.approx(measured)


def test_a_formula_is_well_formed_and_marks_what_is_new() -> None:
    expression = parse_expression("vx + 0.02*(k*vx**2 - cos(z)) - 3*Piecewise((y, y > 0), (k, True))")
    printed = mathml(expression, [symbol("k")])
    tree = ElementTree.fromstring(f"<all>{printed}</all>")
    terms = tree.findall("math")
    assert [term.get("class") for term in terms].count("new") == 2
    assert len(terms) == 3


@given(st.text())
def test_json_cannot_leave_its_script(text: str) -> None:
    written = in_script({"name": text})
    assert json.loads(written) == {"name": text}
    assert "<" not in written
    assert json.loads(in_script({"name": HOSTILE})) == {"name": HOSTILE}


def test_what_drag_puts_in_is_short_and_stands_beside_what_was_there() -> None:
    """Products of the quaternion are entries of the rotation; before, the force was what is commanded or known."""
    put_in, _ = formulas(BASE, [one("linear_drag", cx=0.01, cy=0.01, cz=0.01)])
    assert [formula.name for formula in put_in.formulas] == ["fx that acts", "fy that acts", "fz that acts"]
    for formula in put_in.formulas:
        assert "linear_drag" not in formula.before
        assert formula.before.count("<math") == 1
        terms = ElementTree.fromstring(f"<all>{formula.after}</all>").findall("math")
        assert [term.get("class") for term in terms].count("new") == 3
        assert "<mi>qw</mi>" not in formula.after
    assert "R turns vectors" in put_in.reading


def test_a_finding_is_shown_with_how_sure_it_is() -> None:
    shown = render(diagnosis_page(BASE, logs(), diagnosis(), "crazyflie"))
    assert "93 % against none, and others in its place" in shown


def test_names_keep_their_letters_at_the_head_of_a_sentence() -> None:
    assert sentences(["a log is short", "wx_cmd follows", "payload: none", "motor1, motor2 go"]) == [
        "A log is short", "wx_cmd follows", "payload: none", "motor1, motor2 go"
    ]  # fmt: skip


def test_a_model_without_findings_has_no_switch() -> None:
    page = comparison_page(BASE, logs(), compare(BASE, logs()), "crazyflie")
    assert 'name="switch"' not in render(page)
    assert [section.question for section in page.sections] == [
        "How good is the model?",
        "Where does it fail?",
        "What remains?",
    ]
