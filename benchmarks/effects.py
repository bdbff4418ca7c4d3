"""Cost of each effect on the Porter governor, as ratios to the run without effects, in one process.

Usage: python benchmarks/effects.py
"""

from __future__ import annotations

from collections.abc import Mapping

import governor_mechanism as gm
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import DryFriction, Stops
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.engines import MultibodyEngine
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction

ACCURACY, REPEATS = 1e-8, 7

EFFECTS: Mapping[str, Effect] = {
    "dry friction, 1 N: sixteen oscillations": DryFriction(reading="sleeve_lift", force=InputFunction(values=(1.0,))),
    "dry friction, 10 N: sticks early": DryFriction(reading="sleeve_lift", force=InputFunction(values=(10.0,))),
    "dashpot, linear": Dashpot(reading="sleeve_lift", linear=20.0),
    "dashpot, quadratic": Dashpot(reading="sleeve_lift", quadratic=200.0),
    "spring": OutputSpring(reading="sleeve_lift", rate=100.0),
    "spring, one-sided": OutputSpring(reading="sleeve_lift", rate=100.0, zero=0.12, one_sided=True),
    "stops with impacts": Stops(reading="arm_angle", low=0.5, high=0.75, restitution=0.5),
    "stops without impacts": Stops(reading="arm_angle", low=0.1, high=1.4),
}


def main() -> None:
    """Print the table."""
    bare = gm.load("porter")
    scenes = {"bare": bare} | {name: _with(bare, effect) for name, effect in EFFECTS.items()}
    uneven = Spindle(speeds=bare.spindle.speed_function.values, speed_fluctuation=0.02)
    scenes["fluctuating spindle speed"] = bare.with_changes(spindle=uneven)
    base = time_runs(bare)[0]
    print("| effect | time, ratio | evaluations | events | energy drift |\n|---|---|---|---|---|")
    for name, scene in scenes.items():
        time, run = time_runs(scene)
        evaluations = run.cost.evaluations["equations of motion"]
        print(f"| {name} | {time / base:.2f} | {evaluations:,} | {run.cost.events} | {run.energy.drift:.0e} |")


def _with(scene: Scene, effect: Effect) -> Scene:
    return scene.with_changes(effects=(*scene.effects, effect))


def time_runs(scene: Scene) -> tuple[float, Trajectory]:
    """Return the shortest wall time (s) of several certified runs, and the last run."""
    runs = [MultibodyEngine().run(scene, accuracy=ACCURACY) for _ in range(REPEATS)]
    return min(run.cost.wall_time for run in runs), runs[-1]


if __name__ == "__main__":
    main()
