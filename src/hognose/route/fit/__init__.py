"""From a passage to a spline that the arm can follow."""
