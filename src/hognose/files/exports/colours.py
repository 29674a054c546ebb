"""Colours of exported models: red, green, blue and opacity, 0 to 1."""

COLOURS = {
    "arm": (0.91, 0.64, 0.24, 1.0),
    "arm_2": (0.96, 0.84, 0.60, 1.0),
    "mount": (0.35, 0.32, 0.29, 1.0),
    "obstacle": (0.49, 0.58, 0.67, 0.3),
}
