"""Plans as plan files."""

from __future__ import annotations

from hognose.files.exports.format import Export
from hognose.planning.plan_file import to_parquet

EXPORT = Export(".parquet", "a plan file", lambda plan: to_parquet(plan, plan.checks))
