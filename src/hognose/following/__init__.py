"""Methods that place joints on a path: one file each, one protocol, one table."""

from __future__ import annotations

import difflib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hognose.arguments import instance
from hognose.errors import InputError
from hognose.extensions import Table
from hognose.following.balanced import Balanced
from hognose.following.bisection import Bisection
from hognose.following.ccd import Ccd
from hognose.following.contract import checked_tolerance, faults_named, is_own
from hognose.following.deviation import body_deviation
from hognose.following.exact import Exact
from hognose.following.fabrik import Fabrik
from hognose.following.fitted import FittedSections
from hognose.following.follower import Array, Follower, Limits
from hognose.following.interpolation import Interpolation
from hognose.following.iterative import Iterative
from hognose.following.jacobian import Jacobian
from hognose.following.optimization import Optimization
from hognose.following.prediction import Prediction
from hognose.following.sections import AimedSections, ExactSections, SectionFollower
from hognose.path import Path
from hognose.robot.sections import RIGID_LINK, MixedSections, RigidLink, SectionModel


def _fault(name: str, method: Any) -> str | None:
    if not (isinstance(method, type) and issubclass(method, Follower)):
        return "is not a subclass of hognose.following.Follower"
    for each in ("step", "run"):
        if getattr(method, each) is not getattr(Follower, each):
            return f"has a `{each}` of its own; what {each} of Follower checks holds for all methods: define `_advance`"
    called = getattr(method, "name", None)
    return None if called == name else f"calls itself {called!r}; the class and its entry point must have one name"


#: Every method by its name, those of other packages behind ours; the first is the default.
METHODS: Table[type[Follower]] = Table(
    "methods",
    {
        method.name: method
        for method in (
            Exact,
            Balanced,
            Prediction,
            Interpolation,
            Iterative,
            Bisection,
            Optimization,
            Fabrik,
            Ccd,
            Jacobian,
        )
    },
    _fault,
)


#: Those for arms with sections of other kinds than links, by their names.
OF_SECTIONS: dict[str, type[SectionFollower]] = {
    method.name: method for method in (ExactSections, AimedSections, FittedSections)
}


def known_method(name: str) -> str:
    """The name, or an InputError that lists the methods."""
    known = [*METHODS, *(method for method in OF_SECTIONS if method not in METHODS)]
    if not isinstance(name, str) or name not in known:
        near = difflib.get_close_matches(name, known, 1) if isinstance(name, str) else []
        hint = f"; did you mean {near[0]!r}?" if near else "."
        raise InputError(f"method {name!r} is unknown{hint} Methods: {', '.join(known)}")
    return name


def follower(
    path: Path,
    link_lengths: ArrayLike,
    method: str = "exact",
    spacing: float = 0.0005,
    bend_limits: Limits = None,
    model: SectionModel = RIGID_LINK,
    axes: Array | None = None,
    carried: bool = False,
) -> Follower:
    """A follower for online use: call its `step(feed)` for one feed at a time.

    Arguments and errors as in `follow`.
    """
    known_method(method)
    said = carried.item() if isinstance(carried, np.bool_) else carried
    carried = instance("carried", said, bool, "True or False: whether the base goes along the path")
    if not isinstance(model, RigidLink):
        instance("model", model, MixedSections, "how the sections of a robot bend, `robot.model`")
    if isinstance(model, MixedSections):
        if method not in OF_SECTIONS:
            raise InputError(
                f"method {method!r} is for arms of rigid links with one universal joint each; for sections of other "
                f"kinds take {', '.join(OF_SECTIONS)}"
            )
        return OF_SECTIONS[method](path, model, link_lengths, spacing, bend_limits, axes, carried)
    if method not in METHODS:
        raise InputError(
            f"method {method!r} is for arms with sections that bend along their length or at several joints; for "
            "rigid links take exact"
        )
    if carried:
        raise InputError(
            "carried: joints of rigid links say by themselves how a carrier holds them; expected False, which is the "
            "default, or the model of sections of other kinds"
        )
    kind = METHODS[method]
    with faults_named(kind):
        made = kind(path, link_lengths, spacing, bend_limits)
        if not is_own(kind):
            checked_tolerance(made.tolerance, made.link_lengths)
        return made


def follow(
    path: Path,
    link_lengths: ArrayLike,
    feeds: ArrayLike,
    method: str = "exact",
    spacing: float = 0.0005,
    bend_limits: Limits = None,
    model: SectionModel = RIGID_LINK,
    axes: Array | None = None,
    carried: bool = False,
) -> Array:
    """Joint positions of a whole motion along a path (paper eq. 4).

    Parameters
    ----------
    path : Path
    link_lengths : (n,) m
    feeds : (T,) m
        Arc length of the first joint at every step.
    method
        A name in `METHODS`.
    spacing : float, m
        Distance sd of the points M(In), for the methods that use them.
    bend_limits : rad, optional
        Largest |α| and |β|, (n, 2) or anything that broadcasts to it, or [low, high] of each, (n, 2, 2), for the
        methods that bound them.
    model
        How the sections bend, `robot.model`; rigid links unless given. For others there are the methods `exact`,
        `aim` and `fitted`.
    axes : (3, 3), optional
        Of the base, in columns, the third one along the path, where sections of other kinds begin; unless given, those
        that turn least from the task's.
    carried
        Of other sections: whether the base goes along the path wherever that leads, as a carrier does, its axes turning
        with it. `fitted` chooses its place across the path and its direction together with the angles: the joints say
        the place, and `follower(...).run_with_axes(feeds)` the axes, too, which `robot.angles` of such joints needs.

    Returns
    -------
    (T, n+1, 3) m
        Positions of the joints and the tip.

    Raises
    ------
    InputError
        Unknown method, or one that is not for such sections, feeds outside the path, lengths that are not positive; or
        a method of another package that fails, leaves joints without a place, or makes links longer or shorter than
        they are.
    InfeasibleError
        A link that cannot reach the path; says which, where and at which step.
    """
    return follower(path, link_lengths, method, spacing, bend_limits, model, axes, carried).run(feeds)


__all__ = ["METHODS", "OF_SECTIONS", "Follower", "body_deviation", "follow", "follower", "known_method"]
