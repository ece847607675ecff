"""Flights and drives out of distribution are what their names promise."""

from __future__ import annotations

from test_experiments_flights import forward_speed, quadrotor_spread
from wild_flights import reverse_drives, wild_drives, wild_flights

from sym2real.dataset import Dataset


def test_flights_out_of_distribution_are_wild() -> None:
    tilts, speeds, rates = quadrotor_spread(wild_flights(8, seed=0))
    assert tilts >= 70.0
    assert speeds >= 5.0
    assert rates >= 7.0


def test_drives_out_of_distribution_go_backward_or_fast() -> None:
    drives = wild_drives(4, seed=0, steps=120)
    for drive in drives:
        late = forward_speed(Dataset([drive.rows(60, 120)]))
        if "reverse" in drive.name:
            assert late.max() < -0.5
        else:
            assert late.min() > 2.0
    assert forward_speed(Dataset([d.rows(60, 120) for d in reverse_drives(2, seed=1, steps=120)])).max() < -0.5
