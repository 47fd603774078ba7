"""Train a vacuum for the brake over an elbow for a minute, and draw what it has learnt.

    pip install ".[mujoco,figures]" gymnasium cma
    python examples/elbow_train.py --seconds 60 --figure elbow.svg

The policy is a small network; CMA-ES (pycma) changes its 37 numbers. On loads, targets and speeds
that it has not seen it is compared with the best simple rule: full vacuum as soon as the arm would
be at the target a fixed time later, and that time chosen by trial.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import cma
import numpy as np
from elbow import EVERY, STEP, STEPS, Elbow

HIDDEN, EPISODES, UNSEEN = 6, 12, 200
Policy = Callable[[np.ndarray], np.ndarray]


def network(numbers: np.ndarray) -> Policy:
    """What vacuum to ask for: one hidden layer over distance, speed, vacuum and target."""
    first = numbers[: 5 * HIDDEN].reshape(5, HIDDEN)
    second, last = numbers[5 * HIDDEN : -1], numbers[-1]

    def policy(seen: np.ndarray) -> np.ndarray:
        angle, target, speed, vacuum = seen
        inputs = np.array([4 * (target - angle), speed, vacuum, target, 1.0])
        return np.array([1 / (1 + np.exp(-(np.tanh(inputs @ first) @ second + last)))])

    return policy


def switch(ahead: float) -> Policy:
    """Full vacuum as soon as the arm would be at the target after `ahead` seconds."""

    def policy(seen: np.ndarray) -> np.ndarray:
        angle, target, speed, _ = seen
        return np.array([float(angle + ahead * speed >= target)])

    return policy


def best_switch(arm: Elbow) -> Policy:
    """The rule whose time ends nearest to the target on sixty arms."""
    choices = [switch(ahead) for ahead in np.linspace(0.0, 0.6, 25)]
    away = [
        np.mean([abs(np.subtract(*_end(arm, rule, seed))) for seed in range(60)])
        for rule in choices
    ]
    return choices[int(np.argmin(away))]


def _end(arm: Elbow, policy: Policy, seed: int) -> tuple[float, float]:
    angles, target = episode(arm, policy, seed)
    return angles[-1], target


def episode(arm: Elbow, policy: Policy, seed: int) -> tuple[np.ndarray, float]:
    """(angles at every action, target) in degrees."""
    seen, _ = arm.reset(seed=seed)
    angles = [seen[0]]
    for _ in range(STEPS):
        seen, *_ = arm.step(policy(seen))
        angles.append(seen[0])
    return np.degrees(angles), float(np.degrees(arm.target))


def cost(arm: Elbow, numbers: np.ndarray, seeds: range) -> float:
    """Mean distance from the target over the episodes [degrees]."""
    runs = [episode(arm, network(numbers), seed) for seed in seeds]
    return float(np.mean([np.abs(angles - target).mean() for angles, target in runs]))


def ends(arm: Elbow, policy: Policy) -> tuple[list[np.ndarray], np.ndarray]:
    """Angles over time less the target, and where each unseen episode ends [degrees]."""
    runs = [episode(arm, policy, 10**6 + seed) for seed in range(UNSEEN)]
    paths = [angles - target for angles, target in runs]
    return paths, np.array([path[-1] for path in paths])


def train(seconds: float, generations: int = 10**6) -> tuple[np.ndarray, np.ndarray]:
    """(numbers of the network, processor seconds and cost [degrees] of each generation)."""
    arm, began = Elbow(), time.process_time()
    search = cma.CMAEvolutionStrategy(
        np.zeros(6 * HIDDEN + 1), 1.0, {"seed": 1, "verbose": -9, "popsize": 16}
    )
    history, generation = [], 0
    while (now := time.process_time() - began) < seconds and generation < generations:
        asked = search.ask()
        seeds = range(generation * EPISODES, (generation + 1) * EPISODES)
        costs = [cost(arm, numbers, seeds) for numbers in asked]
        search.tell(asked, costs)
        history.append((now, min(costs)))
        generation += 1
        print(f"{now:5.0f} s  generation {generation:3}  {min(costs):5.1f} degrees", end="\r")
    print()
    return np.asarray(search.result.xfavorite), np.array(history)


def draw(file: Path, before: Policy, after: Policy, history: np.ndarray) -> str:
    """The picture, and what it says in a line."""
    from layerjam.core.drawing import style

    arm, times = Elbow(), np.arange(STEPS + 1) * EVERY * STEP
    shown = {"untrained": (before, style.GREY), "trained": (after, style.BLUE)}
    results = {name: ends(arm, policy) for name, (policy, _) in shown.items()}
    _, simple = ends(arm, best_switch(arm))
    with style.apply_style():
        figure, (left, right) = style.make_axes(columns=2, width=9.2)
        for name, (_, color) in shown.items():
            for path in results[name][0][:20]:
                left.plot(times, path, color=color, linewidth=0.9, alpha=0.6)
        style.add_label(left, 0.62, 50, "untrained", style.GREY)
        style.add_label(left, 0.75, -8, "trained", style.BLUE)
        style.label_axes(left, "Trained arms come to rest at the target",
                         "simulated; twenty new arms", xlabel="time [s]",
                         ylabel="angle below the target [°]", ylim=(-50, 65))  # fmt: skip
        right.plot(history[:, 0], history[:, 1], color=style.BLUE)
        style.label_axes(right, "A minute of training halves the error",
                         xlabel="training time [s]", ylim=(0, None),
                         ylabel="mean distance over an episode [°]")  # fmt: skip
        figure.savefig(file, metadata={"Date": None})

    def said(away: np.ndarray) -> str:
        return f"{np.median(np.abs(away)):.1f} ({np.quantile(np.abs(away), 0.95):.1f})"

    words = {name: said(away) for name, (_, away) in results.items()}
    return (
        f"stops {words['trained']} degrees from the target, median (95 %) of {UNSEEN} unseen arms; "
        f"untrained {words['untrained']}, the best simple rule {said(simple)}"
    )


def main() -> None:
    """Train, draw, say how far from the target the arm stops."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("--seconds", type=float, default=60.0)
    asked.add_argument("--figure", type=Path, default=Path("elbow.svg"))
    given = asked.parse_args()
    numbers, history = train(given.seconds)
    print(draw(given.figure, network(np.zeros_like(numbers)), network(numbers), history))


if __name__ == "__main__":
    main()
