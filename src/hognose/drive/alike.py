"""Sentences about many nodes, of which those that are alike are said once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import groupby

#: More nodes than this of which the same is said are said together.
_FEW = 3


def sentences(said: Mapping[int, str], name: Callable[[int], str], kind: str) -> list[str]:
    """What is said of each node, as one sentence where it is the same for many.

    Parameters
    ----------
    said
        By node.
    name
        Of a node that stands alone.
    kind
        What many of them are, such as `drives`.
    """
    nodes_of: dict[str, list[int]] = {}
    for node, words in sorted(said.items()):
        nodes_of.setdefault(words, []).append(node)
    found: list[str] = []
    for words, nodes in nodes_of.items():
        if len(nodes) > _FEW:
            found.append(f"{len(nodes)} {kind} (nodes {in_ranges(nodes)}): {words}")
        else:
            found += [f"{name(node)}: {words}" for node in nodes]
    return found


def in_ranges(numbers: list[int]) -> str:
    """Rising numbers in words: `1 to 4, 7, 9 to 12`."""
    runs = [[each for _, each in run] for _, run in groupby(enumerate(numbers), lambda pair: pair[1] - pair[0])]
    return ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)
