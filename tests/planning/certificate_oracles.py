"""What a motion needs, from dense samples, and the certificate's bulge in NumPy, whole or with a term left out."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from hognose.planning.certificate import bound, own_body, passing
from hognose.planning.certificate.bound import Certificate

#: Points of each link that are looked at, ends included.
_ALONG = np.linspace(0, 1, 9)


def needed(motion: np.ndarray) -> np.ndarray:
    """What must at least be taken off the mean clearance of both ends of a motion (T, n+1, 3), for each link (n,) m.

    A place p that an axis passes through is at most |p - link at first| and |p - link at last| away at the ends, and
    0 away in between. So half the sum of both is what a bound has to take off, were p an obstacle. No obstacle beside
    the way asks for more, by the triangle inequality: this is the worst of all spaces at once.
    """
    start, end = motion[:, :-1, None], motion[:, 1:, None]
    passed = start + _ALONG[:, None] * (end - start)
    first, last = (_to_segments(passed, motion[t, :-1], motion[t, 1:]) for t in (0, -1))
    return 0.5 * (first + last).max(axis=(0, 2))


def _to_segments(points: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Distances (T, n, k) of points (T, n, k, 3) to segment j of n."""
    along = (ends - starts)[:, None]
    off = points - starts[:, None]
    share = np.clip((off * along).sum(axis=-1) / (along * along).sum(axis=-1), 0, 1)
    return np.linalg.norm(off - share[..., None] * along, axis=-1)


@contextlib.contextmanager
def halved_at_most(halvings: int) -> Iterator[None]:
    """Certificates are made with so few halvings of a step."""
    with pytest.MonkeyPatch.context() as patch:
        for proof in (bound, own_body, passing):
            patch.setattr(proof, "MOST_HALVINGS", halvings)
        yield


def taken_off(certify: Callable[[np.ndarray], Certificate | None], links: int, steps: int = 2) -> np.ndarray:
    """What an unhalved certificate takes off the mean clearance of a step, for each link (n,) m, at the worst step."""
    found = np.empty(links)
    with halved_at_most(0):
        for link in range(links):
            clearance = np.full((steps, links), math.inf)
            clearance[:, link] = 1.0
            proof = certify(clearance)
            assert proof is not None
            assert proof.link == link
            found[link] = 1.0 - proof.clearance
    return found


def bulges(low: np.ndarray, high: np.ndarray, lengths: np.ndarray, without: str = "") -> np.ndarray:
    """How far each joint (n+1,) can leave its chord, by docs/certificate.md; `without` leaves a term of it out.

    The terms are: "carried round" (S w: a joint's axis is turned by the links before it), "own turn" (a b: β's axis is
    turned by α), "growth" (of the angular speed within the step), "angular acceleration", "centripetal", "beta".
    """
    frame, spin = np.eye(3), np.zeros(3)
    grown = speed = acceleration = 0.0
    out = [0.0]
    for (alpha, beta), (a, b), length in zip(low, high - low, lengths, strict=True):
        about_y, about_x = _about_y(alpha), _about_x(beta)
        spin = spin + a * frame[:, 1] + (b * (frame @ about_y)[:, 0] if without != "beta" else 0.0)
        grown += (speed * math.hypot(a, b) if without != "carried round" else 0.0) + (
            abs(a * b) if without != "own turn" else 0.0
        )
        speed = float(np.linalg.norm(spin)) + (grown if without != "growth" else 0.0)
        acceleration += length * (
            (grown if without != "angular acceleration" else 0.0) + (speed**2 if without != "centripetal" else 0.0)
        )
        out.append(acceleration / 8)
        frame = frame @ about_y @ about_x
    return np.array(out)


def _about_y(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def _about_x(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
