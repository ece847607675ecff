"""What a fully explained model would still miss: sensor noise, an unknown start, and small disturbances of every kind.

Per segment the residual's covariance is C = Σ σ_c² I_c + J_x P_x J_xᵀ + Σ q_d J_d J_dᵀ: noise of every channel, a start
that is hardly known (its directions carry no weight then), and disturbances that are constant over a fifth of a
segment. The variances σ², q maximise the likelihood of residuals that the full model leaves, by the
multiplicative minorise–maximise step of H. Zhou et al., "MM algorithms for variance components models", J. Comp.
Graph. Stat. 28 (2019): θ ← θ √(rᵀC⁻¹A C⁻¹r / tr C⁻¹A).

Real logs have pieces in which something rare happens that no model of disturbances foresees (a motor controller winds
up, a wheel slips). Few of them must not decide, nor hide what all others obey: where the full model's residuals have
heavy tails, each segment's covariance is C/g with the weight g that Student's t gives it, g = (ν + n)/(ν + rᵀC⁻¹r),
its degrees of freedom ν by maximum likelihood. Gaussian residuals make ν infinite and every g one. Sources: K. Lange,
R. Little, J. Taylor, "Robust statistical modeling using the t distribution", J. Am. Stat. Assoc. 84 (1989); weights
divided by their mean, so that the scale converges: C. Liu, D. Rubin, Y. Wu, "Parameter expansion to accelerate EM",
Biometrika 85 (1998).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import lgamma, log

import numpy as np
import torch
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import Segments
from sym2real.diagnosis.estimate.variances import Products, most_likely
from sym2real.diagnosis.estimate.wander import Wander
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.body import GRAVITY, SPAN_PART
from sym2real.layout import Layout
from sym2real.least_squares import root_plus_identity
from sym2real.logs.noise import APART, growth
from sym2real.symbolic import Equations
from sym2real.trajectory import Array
from sym2real.vocabulary import FORCE, HEIGHT, RATE_COMMAND, SPEED, STEERING, THRUST, TORQUE, push_column

PIECES = 5
# What may wander: places and angles, which estimators add up.
WANDERING = {"position", "attitude", "heading"}
SHARES = (0.1, 1.0, 10.0, 100.0)  # of a walk's step, beside the white noise: each tenfold is ten times the variance
# Standard deviation of the free start in the tangent's units, far above any error of its estimate; of others 1.
FREE_START = {"position": 0.05, "attitude": 0.2, "heading": 0.3, "velocity": 0.5, "rate": 2.0}
# What counts as one disturbance, and its first guess: share of the weight, angular acceleration.
FORCE_SHARE, TORQUE_ACCELERATION, JOINT_ACCELERATION = 0.01, 1.0, 0.1
# Degrees of freedom that compete with infinitely many, and rounds of weights and variances.
TAILS, TRUST_ROUNDS = (3.0, 5.0, 8.0, 12.0, 20.0, 40.0, 80.0), 3


@dataclass(frozen=True, eq=False)
class Whitening:
    """Covariance of a data set's segments.

    Args:
        sensor: standard deviation of each compared component ``# (C,)``.
        disturbances: name of each disturbance and its standard deviation.
        weight, lost: the inverse covariance is diag(weight) - lost lostᵀ ``# (R,), (S, R, K)``.
        freedom: number of residual components that the free start leaves, all segments together.
        trust: factor of every segment's inverse covariance ``# (S,)``.
        fields: what is compared.
        wander: of the sensors; weight and lost are of rows in which it is white.
    """

    sensor: Tensor
    disturbances: dict[str, float]
    weight: Tensor
    lost: Tensor
    freedom: int
    trust: Tensor
    fields: tuple[str, ...] = ()
    wander: Wander = field(default_factory=Wander)

    @property
    def length(self) -> int:
        """Rows of a segment."""
        return len(self.weight) // len(self.sensor)

    def products(self, columns: Tensor) -> Tensor:
        """Products under C⁻¹ of columns ``# (S, R, A)`` with each other ``# (S, A, A)``."""
        columns = self.wander.whitened(columns)
        lost = self.lost.mT @ columns
        return (columns.mT @ (columns * self.weight[:, None]) - lost.mT @ lost) * self.trust[:, None, None]

    def loss(self, residuals: Tensor) -> Tensor:
        """Whitened squares per segment ``# (B, S)`` of ``# (B, S, R)``."""
        columns = self.wander.whitened(residuals.permute(1, 2, 0))  # (S, R, B)
        whole = (columns.square() * self.weight[:, None]).sum(dim=1)
        return (whole - (self.lost.mT @ columns).square().sum(dim=1)).T * self.trust

    def squares(self, residuals: Tensor) -> Tensor:
        """Whitened squares of every segment ``# (S,)`` of residuals ``# (S, R)``, every segment trusted alike.

        Trust keeps odd segments from deciding a fit; it must not keep them from being seen.
        """
        return replace(self, trust=torch.ones_like(self.trust)).loss(residuals[None])[0]

    def misfit(self, residuals: Tensor) -> float:
        """The same of all segments, per degree of freedom."""
        return float(self.squares(residuals).sum()) / self.freedom

    def deviance(self, residuals: Tensor) -> float:
        """Minus twice the logarithm of the likelihood of residuals ``# (S, R)``, but for what is the same for all."""
        seen = self.lost.mT @ (self.lost / self.weight[:, None])  # (S, K, K)
        unit = torch.eye(seen.shape[-1], dtype=seen.dtype)
        determinants = -torch.linalg.slogdet(unit - seen).logabsdet - self.weight.log().sum()
        determinants += self.wander.determinant - residuals.shape[1] * self.trust.log()
        return float((self.loss(residuals[None])[0] + determinants).sum())

    def inverse_times(self, columns: Tensor) -> Tensor:
        """C⁻¹ times columns ``# (S, R, A)``, every segment trusted alike."""
        white = self.wander.whitened(columns)
        return self.wander.whitened(white * self.weight[:, None] - self.lost @ (self.lost.mT @ white), back=True)

    def directions(self, moves: Tensor) -> float:
        """Part of the C directions of a measured row that moves of the residuals ``# (S, R, A)`` have: 1/C to 1.

        The participation ratio tr(M)²/tr(M²) of the moves' second moments under C⁻¹, over C; tr(M)²/tr(M²) of a single
        direction is one, however the world's axes lie.
        """
        unit = self.sensor.repeat(moves.shape[1] // len(self.sensor))[:, None]
        pulled = self.inverse_times(moves) * unit
        rows = [columns.unflatten(1, (-1, len(self.sensor))) for columns in (moves / unit, pulled)]
        moments = torch.einsum("snca,snda->cd", *rows)
        moments = (moments + moments.mT) / 2
        return float(moments.trace().square() / moments.square().sum().clamp_min(1e-300)) / len(self.sensor)


@dataclass(frozen=True, eq=False)
class Spread:
    """What shapes the covariance, before its variances are known.

    Args:
        start: derivative of the residuals by the free start, in units of its deviation ``# (S, R, n)``.
        disturbances: by every disturbance over every piece, in units of its size ``# (S, R, D, P)``.
        names: of the disturbances: columns of inputs or commands.
        sizes: what counts as one, in the column's unit ``# (D,)``.
        components: that a row compares, C; R is N·C.
        fields: to which they belong.
        wander: of the sensors.
    """

    start: Tensor
    disturbances: Tensor
    names: tuple[str, ...]
    sizes: Tensor
    components: int
    fields: tuple[str, ...] = ()
    wander: Wander = field(default_factory=Wander)

    @classmethod
    def of(cls, problem: Problem, values: Tensor) -> Spread:
        """Sensitivities at one parameter set ``# (P,)``."""
        layout = problem.segments.layout
        names = disturbances(problem.library.equations)
        jacobian = problem.disturbance_jacobian(values, names, PIECES)
        return cls(
            start=problem.start_jacobian(values) * free_start(layout),
            disturbances=jacobian,
            names=tuple(name for name, _ in names),
            sizes=jacobian.new_tensor([size for _, size in names]),
            components=len(problem.segments.compared),
            fields=tuple(layout.fields[number].name for number in dict.fromkeys(problem.segments.channel)),
        )

    def products(self, residuals: Tensor, rows: Tensor) -> Products:
        """With residuals ``# (S, R)``, by the channel of every row ``# (R,)``, where the sensors' noise is white."""
        parts = self.start, self.disturbances.flatten(-2), residuals[..., None]
        start, disturbances, left = map(self.wander.whitened, parts)
        return Products.of(start, disturbances.unflatten(-1, self.disturbances.shape[-2:]), left[..., 0], rows)

    def like(self, other: Whitening) -> Whitening:
        """With the noise and the disturbances of another."""
        power = self.sizes.new_tensor([other.disturbances[name] for name in self.names]) / self.sizes
        return replace(self, wander=other.wander).whitening(other.sensor.square(), power.square())

    def whitening(self, sensor: Tensor, power: Tensor) -> Whitening:
        """The inverse covariance by Woodbury's identity.

        Args:
            sensor: variances of components ``# (C,)``.
            power: variances of disturbances in units of their size ``# (D,)``.
        """
        segments, rows = self.start.shape[:2]
        weight = 1.0 / sensor.repeat(rows // self.components)
        disturbed = (self.disturbances * power.sqrt()[:, None]).flatten(-2)
        columns = self.wander.whitened(torch.cat([self.start, disturbed], dim=-1))
        weighted = columns * weight[:, None]
        lost = torch.linalg.solve_triangular(root_plus_identity(columns.mT @ weighted), weighted.mT, upper=False).mT
        freedom = segments * (rows - int(torch.linalg.matrix_rank(self.start[0])))
        disturbances = dict(zip(self.names, (power.sqrt() * self.sizes).tolist(), strict=True))
        trust = weight.new_ones(segments)
        return Whitening(sensor.sqrt(), disturbances, weight, lost, freedom, trust, self.fields, self.wander)


@dataclass(frozen=True, eq=False)
class Whitened:
    """A data set at a parameter set, with the covariance of what a fully explained model leaves of it.

    Args:
        problem: a library against the data.
        spread, whitening: the covariance.
        values: the parameter set ``# (P,)``.
    """

    problem: Problem
    spread: Spread
    whitening: Whitening
    values: Tensor

    @cached_property
    def residuals(self) -> Tensor:
        """Predicted less measured ``# (S, R)``."""
        return self.problem.residuals(self.values[None])[0]


def free_start(layout: Layout) -> Tensor:
    """Standard deviation of the free start ``# (tangent,)``."""
    free = [FREE_START.get(field.name, 1.0) for field in layout.fields for _ in range(field.tangent_size)]
    return torch.tensor(free, dtype=torch.float64)


def disturbances(equations: Equations) -> list[tuple[str, float]]:
    """Columns whose disturbances stand for what no model knows, each with its unit size: wrench inputs, or commands."""
    inputs, numbers = equations.layouts.inputs, equations.numbers
    weight, joints = GRAVITY * numbers.get("mass", 1.0), equations.layouts.state.joints
    sizes = dict.fromkeys(FORCE.columns, FORCE_SHARE * weight)
    inertias = zip(TORQUE.columns, ("jx", "jy", "jz"), strict=True)
    sizes |= {column: TORQUE_ACCELERATION * numbers.get(inertia, 1e-5) for column, inertia in inertias}
    sizes |= {push_column(joint): JOINT_ACCELERATION * numbers.get(f"{joint}_inertia", 1.0) for joint in joints}
    planar = HEIGHT not in equations.layouts.state and not joints
    used = [n for n in sizes if n in inputs and any(equations.depends(c, n) for c in equations.next)]
    if used and not planar:
        return [(name, sizes[name]) for name in used]
    others = dict.fromkeys(THRUST.columns, FORCE_SHARE * weight)
    others |= dict.fromkeys((*RATE_COMMAND.columns, *SPEED.columns), 0.1) | dict.fromkeys(STEERING.columns, 0.05)
    spans = {name: numbers.get(f"{name}_range", 0.05 / SPAN_PART) for name in equations.layouts.action}
    return [(name, others.get(name, SPAN_PART * span)) for name, span in spans.items()]


def with_wander(spread: Spread, residuals: Tensor, segments: Segments, data: Dataset) -> Spread:
    """The same with the wander of positions and angles that makes residuals ``# (S, R)`` most likely.

    There is none where the logs have no noise that grows in proportion to the rows, as a walk does: what a model gets
    wrong looks like one as well, and so do white noise and motion together.
    """
    layout, near, far = segments.layout, growth(data, 2) - 1.0, growth(data, APART) - 1.0
    shares, length = torch.zeros(spread.components, dtype=torch.float64), segments.length
    least = estimate(spread, residuals, segments.noise, segments.channel, alike=True).deviance(residuals)
    for number in dict.fromkeys(segments.channel):
        own, places = torch.tensor(segments.channel) == number, layout.tangent_places[number]
        twice, grown = np.median(near[places]), np.median(far[places])
        walks = SETTINGS.above_noise - 1.0 < grown < SETTINGS.gap * (APART - 1.0) * twice
        for share in SHARES if walks and layout.fields[number].name in WANDERING else ():
            tried = Wander(torch.where(own, share, shares), length)
            likely = estimate(replace(spread, wander=tried), residuals, segments.noise, segments.channel, alike=True)
            if (deviance := likely.deviance(residuals)) > least - SETTINGS.heavy_tails:
                break
            spread, shares, least = replace(spread, wander=tried), tried.shares, deviance
    return spread


def estimate(
    spread: Spread, residuals: Tensor, noise: Array, channel: tuple[int, ...], *, alike: bool = False
) -> Whitening:
    """The whitening that makes residuals ``# (S, R)`` most likely.

    Args:
        spread: sensitivities.
        residuals: of the full model.
        noise: first guess of the sensors' standard deviation ``# (C,)``.
        channel: channel of each component; components of a channel share one variance ``# (C,)``.
        alike: every segment is trusted alike. While an effect may still be missing from the model, segments in which
            it acts are not to be taken for odd ones.
    """
    number = torch.tensor([sorted(set(channel)).index(name) for name in channel])  # (C,)
    first = torch.as_tensor(noise, dtype=torch.float64).square()
    sensor = torch.stack([first[number == name].mean() for name in range(int(number.max()) + 1)])
    power = torch.full((len(spread.names),), 0.25, dtype=torch.float64)
    products = spread.products(residuals, number.repeat(residuals.shape[1] // spread.components))
    trust = residuals.new_ones(len(residuals))
    for _ in range(1 + TRUST_ROUNDS):
        weight = trust / trust.mean()  # without the mean the scale would hardly move (see above)
        sensor, power = most_likely(products.weighted(weight), sensor, power)
        whitening = spread.whitening(sensor[number], power)
        trust = whitening.trust if alike else _trust(whitening, residuals)
        if bool((trust == 1).all()):
            return whitening
    return replace(whitening, trust=trust)


def _trust(whitening: Whitening, residuals: Tensor) -> Tensor:
    """Weight of every segment ``# (S,)``; ones where the residuals' tails are not clearly heavy."""
    squares, size = whitening.squares(residuals), whitening.freedom / len(residuals)
    gaussian = float((-size / 2 * log(2) - squares / 2).sum())
    # Logarithm of Student's density of so many components, but for what does not depend on ν.
    heights = {nu: lgamma((nu + size) / 2) - lgamma(nu / 2) - size / 2 * log(nu) for nu in TAILS}
    likely = {nu: float((heights[nu] - (nu + size) / 2 * torch.log1p(squares / nu)).sum()) for nu in TAILS}
    nu = max(likely, key=lambda degrees: likely[degrees])
    if 2 * (likely[nu] - gaussian) < SETTINGS.heavy_tails:
        return torch.ones_like(squares)
    return (nu + size) / (nu + squares)
