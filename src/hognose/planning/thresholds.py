"""How closely columns, tip and way-points must agree with what they follow from."""

from __future__ import annotations

import math

#: How closely (m) the tip must reach the target and keep to exact following, unless the task says otherwise.
TIP_TOLERANCE = 1e-6
#: The same for methods that look joints up among points of the path.
LOOKUP_TIP_TOLERANCE = 1e-3
#: How closely (m) way-points must pass places that are via: both may be rounded to 0.001 mm in a task file.
VIA_TOLERANCE = 1e-6
#: How closely columns that follow from others must agree with them (m).
COLUMN_TOLERANCE = 1e-9
#: The part of a feed by which it may exceed its end: last bits of the arc at which the first joint is found.
FEED_SLACK = 1e-12
#: The same as of columns, for times (s).
TIME_TOLERANCE = 1e-9
#: Joints bent by less (rad) are straight.
STRAIGHT_TOLERANCE = math.radians(1e-6)
