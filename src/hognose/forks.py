"""A process may be forked while one of its threads compiles: the fork waits until that is done.

Else the child had a copy of numba's lock that is held by a thread it does not have, and would wait for it for ever.
"""

from __future__ import annotations

import os

from numba.core.compiler_lock import global_compiler_lock

if hasattr(os, "register_at_fork"):
    os.register_at_fork(
        before=global_compiler_lock.acquire,
        after_in_parent=global_compiler_lock.release,
        after_in_child=global_compiler_lock.release,
    )
