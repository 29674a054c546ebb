"""`python -m benchmarks.as_it_stands`: the arm as it stands, in one run and for a page of the documentation.

Frames of the base, the body against itself, cables between set-points, tolerances and the fastest profile; each part
has a module of its own, which prints it alone.
"""

from __future__ import annotations

import argparse

from benchmarks import cables_between, docs_page, frames, own_body, profile, tolerances
from benchmarks.rows import as_markdown


def main() -> None:
    """Measure, and write the page if it is asked for."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.as_it_stands", description="The arm as it stands: base, body, cables, tolerances."
    )
    docs_page.add_option(parser)
    given = parser.parse_args()
    if given.docs is not None:
        docs_page.found_in(given.docs, "stands")
    print(docs_page.measured_with())
    frames.main()
    cables_between.main()
    own_body.main()  # from here on on one core
    tolerances.main()
    profile.main()
    if given.docs is not None:
        docs_page.write_block(given.docs, "stands", f"{docs_page.measured_with()}\n\n{as_markdown()}")


if __name__ == "__main__":
    main()
