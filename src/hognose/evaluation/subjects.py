"""What is compared: every following method, and the three of the paper once more as they were published."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np

from hognose.evaluation.case import Case
from hognose.evaluation.section_families import MAKERS
from hognose.following import METHODS, OF_SECTIONS, Follower, known_method

#: Methods that also come as published: compiled, but without what Hognose adds to them.
PUBLISHED = ("iterative", "bisection", "optimization")
_SUFFIX = " (published)"
#: The spacing family says something only about methods that use the points, beside the one that does not.
_WITH_SPACING = ("exact", "prediction", "interpolation", "iterative")


def subjects_of(methods: Sequence[str] = ()) -> list[str]:
    """Labels of what is measured for these methods, all if there are none; unknown names are an InputError."""
    names = [known_method(name) for name in methods] or [*METHODS, *OF_SECTIONS]
    labels = []
    for name in dict.fromkeys(names):
        labels += [name, as_published(name)] if name in PUBLISHED else [name]
    return labels


def as_published(name: str) -> str:
    """The label of a method in its published form."""
    return name + _SUFFIX


def method_of(label: str) -> str:
    """The method's name in a label."""
    return label.removesuffix(_SUFFIX)


def kind_of(label: str) -> type[Follower]:
    """The class behind a label; of methods that are there for links and for other sections, that for links."""
    method = method_of(label)
    return METHODS[method] if method in METHODS else OF_SECTIONS[method]


def takes_part(label: str, family: str) -> bool:
    """Whether a label is measured in a family."""
    if family in MAKERS:
        return label in OF_SECTIONS
    if method_of(label) not in METHODS:
        return False
    return family != "spacing" or method_of(label) in _WITH_SPACING


def follower_for(label: str, case: Case, begin: float = 0.0) -> Follower:
    """A new follower, cold, whose way begins at a feed (m): with the arm laid along the path."""
    follower = _made(label, case)
    follower.begin(begin)
    return follower


def _made(label: str, case: Case) -> Follower:
    if case.model is not None:
        of_sections = OF_SECTIONS[label]
        return of_sections(case.path, case.model, case.link_lengths, case.spacing, case.bend_limit, np.eye(3))
    kind = METHODS[method_of(label)]
    if label.endswith(_SUFFIX):
        published = cast(Callable[..., Any], kind)
        return published(case.path, case.link_lengths, case.spacing, case.bend_limit, as_published=True)
    return kind(case.path, case.link_lengths, case.spacing, case.bend_limit)
