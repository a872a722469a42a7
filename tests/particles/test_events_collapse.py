"""The rule that decides whether a tracer ever leaves a corner, against one bounce after another."""

import numpy as np

from particles.events import is_collapsing

BOUNCES = 300
MARGIN = 0.01  # from the boundary of the rule; nearer to it, bounces take too long to decide


def still_bounces(theta: float, alpha: float, restitution: float) -> bool:
    """Bounce between the half-lines at angles 0 and theta from the corner at (0, 0).

    The tracer leaves (1, 0) at the angle alpha with the wall, from the side of the corner. It can
    only strike the other wall, or none: then it has left. Lengths are scaled back to 1 after each
    bounce, and nothing of the rule is used.
    """
    walls = np.array([[1.0, 0.0], [np.cos(theta), np.sin(theta)]])
    normals = np.array([[0.0, 1.0], [np.sin(theta), -np.cos(theta)]])
    place, velocity, here = walls[0], np.array([-np.cos(alpha), np.sin(alpha)]), 0
    for _ in range(BOUNCES):
        here = 1 - here
        wall, normal = walls[here], normals[here]
        approach = velocity @ normal
        if approach >= 0:
            return False
        place = place - (place @ normal) / approach * velocity
        if place @ wall <= 0:
            return False  # beyond the corner: this half-line is not met
        velocity = velocity - (1 + restitution) * approach * normal
        velocity = velocity / np.hypot(*velocity)
        place = wall
    return True


def test_the_rule_agrees_with_bounces_in_a_wedge() -> None:
    rng = np.random.default_rng(3)
    collapsing = decided = 0
    for _ in range(1500):
        restitution = rng.uniform(0.01, 0.99)
        # Half of the angles small: there restitutions near 1 collapse too.
        theta = rng.uniform(0.01, np.pi - 0.01) * rng.choice([1.0, 0.1])
        alpha = rng.uniform(0.0, np.pi)
        bound = (1 + restitution) / (1 - restitution) * np.sin(theta)
        if abs(bound - 1) < MARGIN:
            continue
        if bound < 1 and abs(2 * alpha + theta - np.pi + np.arcsin(bound)) < MARGIN:
            continue
        turn, mirror = rng.uniform(0, 2 * np.pi), rng.choice([-1.0, 1.0])
        rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        vectors = [[np.sin(theta), -np.cos(theta)], [0.0, 1.0], [-np.cos(alpha), np.sin(alpha)]]
        before, left, direction = (rotation @ (v * np.array([1, mirror])) for v in vectors)
        expected = still_bounces(theta, alpha, restitution)
        found = is_collapsing(*before, *left, *direction, restitution)
        assert found == expected, (theta, alpha, restitution)
        decided += 1
        collapsing += expected
    assert decided > 1300
    assert 200 < collapsing < decided - 200
