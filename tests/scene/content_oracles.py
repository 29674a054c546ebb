"""What is compared of the content of files: sets of triangles, whatever their order."""

import numpy as np

#: A box that is no cube and not at the origin: its corners (8, 3) m and its triangles (12, 3), anticlockwise outside.
CORNERS = np.array([(x, y, z) for x in (-0.1, 0.3) for y in (0.1, 0.4) for z in (0.2, 0.8)])
QUADS = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
FACES = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]])
VOLUME = 0.4 * 0.3 * 0.6


def canonical(triangles, digits=6):
    """Triangles (m, 3, 3) in an order of their own, each beginning with its least corner, as text."""
    rows = []
    for triangle in np.round(triangles, digits) + 0.0:
        corners = [tuple(corner) for corner in triangle.tolist()]
        first = corners.index(min(corners))
        rows.append((*corners[first:], *corners[:first]))
    return sorted(rows)


def of_body(body):
    """The triangles (m, 3, 3) of a body."""
    return body.vertices[body.faces]


def of_content(content):
    """The triangles of all bodies."""
    return np.concatenate([np.empty((0, 3, 3)), *(of_body(body) for body in content.bodies)])


def volume(body):
    """The volume that a body encloses; negative if it is inside out."""
    return np.linalg.det(of_body(body)).sum() / 6


def assert_is_the_box(content, name="box", digits=6, points=0):
    """The box, whole, as one body with its name, and no more."""
    (body,) = content.bodies
    assert body.name == name
    np.testing.assert_allclose(canonical(of_body(body), digits), canonical(CORNERS[FACES]), atol=2 * 10.0**-digits)
    assert len(of_body(body)) == 12
    np.testing.assert_allclose(volume(body), VOLUME, rtol=10.0 ** (1 - digits))
    assert len(content.points) == points
