"""# Adapt to a heavier drone

What a robot has and its equations lack can be learned, flight by flight, by a small network on top of frozen equations.
Here a Crazyflie carries 4 g that nobody told the model of.

    python docs/tutorials/04_adapt.py
"""

import sys

from sym2real import ROBOTS, Adapting, MujocoPlant, ResidualTraining, adapt, effect, make_task
from sym2real.neural import Descent

SHORT = "--short" in sys.argv

# The target differs from its model by a mass. Round 0 flies the model as it is.

robot = ROBOTS["crazyflie"]
target = MujocoPlant(robot, [effect("added_mass", robot).inject(value=0.004)])
task = make_task("circle", robot)

# After every flight the network is trained on all flights so far. Every log is held out to the model that flew it, and
# the run ends by itself when two rounds in a row bring no improvement beyond their interval.

if SHORT:
    settings = Adapting(rounds=1, steps=120, samples=64)
    learner = ResidualTraining(widths=(16,), steps=5, penalties=(1e-2,), descent=Descent(steps=100))
else:
    settings, learner = Adapting(rounds=5), ResidualTraining()
adapted = adapt(robot.nominal(), target, task, learner, settings)

for report in adapted.reports:
    print(
        f"round {report.number}: {100 * report.error:.1f} cm from the path, predicted within {report.prediction:.3f} m"
    )
adapted.plot().savefig("rounds.svg")
print("best round:", adapted.best, "settled:", adapted.settled)
assert len(adapted.models) == len(adapted.logs) >= 2

# `folder=` keeps model, log and report of every round; an interrupted run goes on from there. The command is
# `sym2real adapt MODEL TARGET TASK --out FOLDER`, and `--diagnose` puts the effects that the logs establish into the
# equations first.
