"""The camera in the tip, as pictures and exported models have it: which one is really there, no robot file says."""

#: From top to bottom of its picture, deg [assumed].
ANGLE_OF_VIEW_DEG = 80.0
