"""What one-step residuals remember of themselves and of the commands, in sentences."""

from sym2real.diagnosis.errors.residuals import Residuals

# A command that answers the noise of a measured row meets it again in the residual up to this lag: a velocity by
# differences has noise of two rows.
ANSWERED = 1


def residual_lines(residuals: Residuals) -> list[str]:
    """What a person should know, a sentence each."""
    sentences = [_following(residuals, name, command) for command, name in residuals.suspicious().items()]
    if not residuals.components:
        return sentences
    if not residuals.coloured:
        return ["the one-step residuals are white, but for what sensor noise makes", *sentences]
    return [_coloured(residuals), *sentences]


def _coloured(residuals: Residuals) -> str:
    first = residuals.coloured[0]
    residual, (_, lag) = residuals.components[first], residuals.components[first].worst()
    band = residuals.white_bar * residual.deviations[lag - 1]
    count = f"{len(residuals.coloured)} of {len(residuals.components)} components"
    most = f"{first} most, {_rows(lag)} apart (r {residual.autocorrelation[lag - 1]:.2f}, band {band:.2f})"
    return f"the one-step residuals are not white in {count}: {most}"


def _following(residuals: Residuals, name: str, command: str) -> str:
    following = residuals.components[name].commands[command]
    band = residuals.command_bar * following.deviation
    extremes = (int(following.causal.argmax()), int(following.causal.argmin()))
    # The later one first: a delay shows as what came so many rows earlier, less what comes now.
    lags = sorted((lag for lag in extremes if abs(following.causal[lag]) > band), reverse=True)
    when = [f"{_rows(lag)} earlier" if lag else "of the same row" for lag in lags]
    clauses = [
        f"{'follows' if size > 0 else 'opposes'} {what} {at} (r {size:.2f})"
        for at, size, what in zip(when, following.causal[lags], (command, "it"), strict=False)
    ]
    answers = lags[0] <= ANSWERED and following.answers_noise
    noise = "; a loop that answers sensor noise may do that" if answers else ""
    return f"the residual of {name} {' and '.join(clauses)}, band {band:.2f}{noise}"


def _rows(count: int) -> str:
    return f"{count} row{'s' if count > 1 else ''}"
