"""Words for plan files that are not as they were written."""

from __future__ import annotations

#: What to do about such a file.
REMEDY = "Take another copy of it, or plan the task anew."
#: The end of a message that has said what shows it.
ALTERED = f"the file was altered. {REMEDY}"
