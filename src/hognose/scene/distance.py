"""Exact distance from capsule axes to triangles: the numba kernels.

Symbols: a segment is P + s D with s in 0…1; a triangle has corner A, edges B and C from it, and unit
normal N. All distances are between axis and surface; radii are subtracted by the caller.
"""

from __future__ import annotations

import numpy as np

from hognose.kernels import kernel

# Of numpy's types, since a literal among the arguments would be compiled as a type of its own.
_NONE, _LEFT, _RIGHT = np.int64(-1), np.int64(0), np.int64(6)
# The tree is at most 64 deep, and the search keeps one node a level and one more.
_STACK = 80
# Sine of the angle to a plane below which a segment is searched as if along it.
_GRAZING = 1e-2
# Where a segment cuts a plane is known to this, relative to the coordinates: rounding over _GRAZING.
_SLIT = 1e-13
# Triangles on the two sides of a flat edge differ by less than this angle, rad; see `faces`.
_TILT = 1e-8


@kernel(error_model="numpy")
def _segment_edge(px, py, pz, dx, dy, dz, dd, inv_dd, qx, qy, qz, ex, ey, ez, inv_ee, limit2):
    """Return (squared distance, s, t) between the segments P + s D and Q + t E.

    s comes from the cross product of the directions, not from a 2 × 2 system: its error, times the sine of
    the angle between the segments, stays at rounding level however parallel they are.
    If the distance is not below the limit, a lower bound that is not below it either may come back instead.
    """
    rx, ry, rz = px - qx, py - qy, pz - qz
    nx, ny, nz = dy * ez - dz * ey, dz * ex - dx * ez, dx * ey - dy * ex
    nn = nx * nx + ny * ny + nz * nz
    s = 0.0
    if nn > 0.0:
        inv_nn = 1.0 / nn
        apart = rx * nx + ry * ny + rz * nz
        apart2 = apart * apart * inv_nn
        # The lines are farther apart than the limit. Of near-parallel ones rounding leaves no such knowledge.
        if apart2 >= limit2 and nn * inv_ee > 1e-12 * dd:
            return apart2, 0.0, 0.0
        cx, cy, cz = ey * rz - ez * ry, ez * rx - ex * rz, ex * ry - ey * rx
        s = min(max((cx * nx + cy * ny + cz * nz) * inv_nn, 0.0), 1.0)
    t = ((rx + s * dx) * ex + (ry + s * dy) * ey + (rz + s * dz) * ez) * inv_ee
    if t <= 0.0 or t >= 1.0:
        t = min(max(t, 0.0), 1.0)
        s = ((t * ex - rx) * dx + (t * ey - ry) * dy + (t * ez - rz) * dz) * inv_dd
        s = min(max(s, 0.0), 1.0)
    wx, wy, wz = rx + s * dx - t * ex, ry + s * dy - t * ey, rz + s * dz - t * ez
    return wx * wx + wy * wy + wz * wz, s, t


@kernel(error_model="numpy", inline="always")
def _covers(faces, k, x, y, z, slit):
    """Whether the inside of face k has the point A + (x, y, z) of its plane.

    Beyond an edge left to a neighbour it goes on for a slit, lest rounding open one there.
    """
    bx, by, bz = faces[k, 3], faces[k, 4], faces[k, 5]
    cx, cy, cz = faces[k, 6], faces[k, 7], faces[k, 8]
    nx, ny, nz = faces[k, 9], faces[k, 10], faces[k, 11]
    # N × B and N × C: across the edges from A.
    ux, uy, uz = ny * bz - nz * by, nz * bx - nx * bz, nx * by - ny * bx
    vx, vy, vz = ny * cz - nz * cy, nz * cx - nx * cz, nx * cy - ny * cx
    over_b = x * ux + y * uy + z * uz
    over_c = -(x * vx + y * vy + z * vz)
    whole = cx * ux + cy * uy + cz * uz
    over_a = whole - over_b - over_c
    if min(over_a, over_b, over_c) >= 0.0:
        return True
    if min(over_a, over_b, over_c) < -slit * faces[k, 15]:
        return False
    inv_b, inv_c, inv_a = faces[k, 12], faces[k, 13], faces[k, 14]
    return (
        over_b >= (-slit / np.sqrt(-inv_b) if inv_b < 0.0 else 0.0)
        and over_c >= (-slit / np.sqrt(-inv_c) if inv_c < 0.0 else 0.0)
        and over_a >= (-slit / np.sqrt(-inv_a) if inv_a < 0.0 else 0.0)
    )


@kernel(error_model="numpy", inline="always")
def _segment_edges(faces, k, px, py, pz, dx, dy, dz, dd, inv_dd, limit2, all_of_them):
    """Return (squared distance, s, mesh point) from a segment to the edges of face k, or to those not left to others.

    Bounds may come back as from `_segment_edge`.
    """
    ax, ay, az = faces[k, 0], faces[k, 1], faces[k, 2]
    bx, by, bz = faces[k, 3], faces[k, 4], faces[k, 5]
    cx, cy, cz = faces[k, 6], faces[k, 7], faces[k, 8]
    best, s, x, y, z = np.inf, 0.0, 0.0, 0.0, 0.0
    for edge in range(3):
        inv_ee = faces[k, 12 + edge]
        if inv_ee < 0.0:
            if not all_of_them:
                continue
            inv_ee = -inv_ee
        qx, qy, qz = (ax, ay, az) if edge < 2 else (ax + bx, ay + by, az + bz)
        ex, ey, ez = (bx, by, bz) if edge == 0 else (cx, cy, cz)
        if edge == 2:
            ex, ey, ez = cx - bx, cy - by, cz - bz
        d2, s2, t = _segment_edge(px, py, pz, dx, dy, dz, dd, inv_dd, qx, qy, qz, ex, ey, ez, inv_ee, min(best, limit2))
        if d2 < best:
            best, s, x, y, z = d2, s2, qx + t * ex, qy + t * ey, qz + t * ez
    return best, s, x, y, z


@kernel(error_model="numpy")
def _segment_face(faces, k, px, py, pz, dx, dy, dz, dd, inv_dd, limit2):
    """Return (squared distance, s, mesh point) from a segment to what face k answers for.

    That is its inside and those of its edges that are not left to a neighbour. If the distance is not below
    the limit, a lower bound that is not below it either may come back instead, infinity if it answers for
    nothing that could be closest.
    """
    ax, ay, az = faces[k, 0], faces[k, 1], faces[k, 2]
    nx, ny, nz = faces[k, 9], faces[k, 10], faces[k, 11]

    # Heights of the segment's ends over the plane. If the closest point of the triangle is an inner one, it
    # lies under the lower end, or where the segment crosses the plane.
    rx, ry, rz = px - ax, py - ay, pz - az
    start = rx * nx + ry * ny + rz * nz
    rise = dx * nx + dy * ny + dz * nz
    end = start + rise
    if start * end <= 0.0:
        s = min(max(-start / rise, 0.0), 1.0) if rise != 0.0 else 0.0
        height = 0.0
    else:
        s = 0.0 if abs(start) <= abs(end) else 1.0
        height = start if s == 0.0 else end
        if height * height >= limit2:
            return height * height, 0.0, 0.0, 0.0, 0.0

    if nx != 0.0 or ny != 0.0 or nz != 0.0:
        x, y, z = rx + s * dx - height * nx, ry + s * dy - height * ny, rz + s * dz - height * nz
        scale = abs(ax) + abs(ay) + abs(az) + abs(rx) + abs(ry) + abs(rz)
        if _covers(faces, k, x, y, z, _SLIT * scale + _TILT * abs(height)):
            return height * height, s, ax + x, ay + y, az + z

    # Along the plane, rounding decides which end is the lower one and where the plane is crossed, perhaps
    # differently for neighbours: then no edge is left to them.
    grazing = rise * rise <= _GRAZING * _GRAZING * dd
    return _segment_edges(faces, k, px, py, pz, dx, dy, dz, dd, inv_dd, limit2, grazing)


@kernel(error_model="numpy")
def _segment_grown(faces, grown, k, px, py, pz, dx, dy, dz, dd, inv_dd, limit):
    """Return the squared distance from a segment to face k thickened by its growth, or a bound as above."""
    if faces[k, 12] == 0.0:  # its longest edge has no length: a point, thickened to a ball
        rx, ry, rz = faces[k, 0] - px, faces[k, 1] - py, faces[k, 2] - pz
        s = min(max((rx * dx + ry * dy + rz * dz) * inv_dd, 0.0), 1.0)
        rx, ry, rz = rx - s * dx, ry - s * dy, rz - s * dz
        d2 = rx * rx + ry * ry + rz * rz
    else:
        reach = limit + grown[k]
        d2 = _segment_face(faces, k, px, py, pz, dx, dy, dz, dd, inv_dd, reach * reach)[0]
    apart = np.sqrt(d2) - grown[k]
    return apart * apart if apart > 0.0 else 0.0


@kernel(error_model="numpy")
def _box_bound(boxes, node, first, px, py, pz, dx, dy, dz, inv_dd, mx, my, mz, lx, ly, lz):
    """Return a lower bound of the distance between a segment and a child's box.

    The larger of two: along the direction from the segment to the box's middle, and between the box and
    the segment's own box of middle M and half extent L.
    """
    hx, hy, hz = boxes[node, first + 3], boxes[node, first + 4], boxes[node, first + 5]
    cx, cy, cz = boxes[node, first], boxes[node, first + 1], boxes[node, first + 2]
    gx = max(abs(cx - mx) - hx - lx, 0.0)
    gy = max(abs(cy - my) - hy - ly, 0.0)
    gz = max(abs(cz - mz) - hz - lz, 0.0)
    gap2 = gx * gx + gy * gy + gz * gz
    wx, wy, wz = cx - px, cy - py, cz - pz
    s = min(max((wx * dx + wy * dy + wz * dz) * inv_dd, 0.0), 1.0)
    wx, wy, wz = abs(wx - s * dx), abs(wy - s * dy), abs(wz - s * dz)
    w2 = wx * wx + wy * wy + wz * wz
    apart = w2 - wx * hx - wy * hy - wz * hz
    if apart > 0.0 and apart * apart > gap2 * w2:
        return apart / np.sqrt(w2)
    return np.sqrt(gap2)


@kernel(error_model="numpy")
def _search(boxes, child, faces, grown, nodes, bounds, px, py, pz, dx, dy, dz, limit, known):
    """Return (distance, face, lower bound) for the closest face.

    Only distances below `limit` are found; without any the face is -1 and the lower bound of the distance,
    at least `limit`, is what was seen while passing by. `known` is a face to try first, or -1. `nodes` and
    `bounds` are scratch space for the nodes still to visit.
    """
    dd = dx * dx + dy * dy + dz * dz
    inv_dd = 1.0 / dd if dd > 1e-300 else 0.0
    mx, my, mz = px + 0.5 * dx, py + 0.5 * dy, pz + 0.5 * dz
    lx, ly, lz = 0.5 * abs(dx), 0.5 * abs(dy), 0.5 * abs(dz)
    best, best2, face, passed2 = limit, limit * limit, _NONE, np.inf
    thick = len(grown) > 0
    if known >= 0:
        if thick:
            d2 = _segment_grown(faces, grown, known, px, py, pz, dx, dy, dz, dd, inv_dd, best)
        else:
            d2 = _segment_face(faces, known, px, py, pz, dx, dy, dz, dd, inv_dd, best2)[0]
        if d2 < best2:
            best, best2, face = np.sqrt(d2), d2, known
    nodes[0], bounds[0], waiting = 0, 0.0, 1
    while waiting > 0:
        waiting -= 1
        node, bound = nodes[waiting], bounds[waiting]
        if bound >= best:
            passed2 = min(passed2, bound * bound)
        elif node < 0:
            first, held = (-1 - node) >> 2, ((-1 - node) & 3) + 1
            for k in range(first, first + held):
                if thick:
                    d2 = _segment_grown(faces, grown, k, px, py, pz, dx, dy, dz, dd, inv_dd, best)
                else:
                    d2 = _segment_face(faces, k, px, py, pz, dx, dy, dz, dd, inv_dd, best2)[0]
                if d2 < best2:
                    best, best2, face = np.sqrt(d2), d2, k
                else:
                    passed2 = min(passed2, d2)
        else:
            left = _box_bound(boxes, node, _LEFT, px, py, pz, dx, dy, dz, inv_dd, mx, my, mz, lx, ly, lz)
            right = _box_bound(boxes, node, _RIGHT, px, py, pz, dx, dy, dz, inv_dd, mx, my, mz, lx, ly, lz)
            swap = 1 if left <= right else 0
            nodes[waiting + 1 - swap], bounds[waiting + 1 - swap] = child[node, 1], right
            nodes[waiting + swap], bounds[waiting + swap] = child[node, 0], left
            waiting += 2
    return best, face, np.sqrt(passed2)


@kernel(error_model="numpy")
def nearest(boxes, child, faces, grown, index, starts, ends, upper, span, value, on_segment, on_mesh, triangle):
    """Fill the answers of independent queries span[0] … span[1] - 1; see `Scene.distance`."""
    nodes, bounds = np.empty(_STACK, np.int32), np.empty(_STACK)
    for i in range(span[0], span[1]):
        px, py, pz = starts[i, 0], starts[i, 1], starts[i, 2]
        dx, dy, dz = ends[i, 0] - px, ends[i, 1] - py, ends[i, 2] - pz
        best, face, _ = _search(boxes, child, faces, grown, nodes, bounds, px, py, pz, dx, dy, dz, upper, _NONE)
        value[i] = best
        if face < 0:
            triangle[i] = -1
            on_segment[i], on_mesh[i] = np.nan, np.nan
            continue
        triangle[i] = index[face]
        dd = dx * dx + dy * dy + dz * dz
        inv_dd = 1.0 / dd if dd > 1e-300 else 0.0
        d2, s, x, y, z = _segment_face(faces, face, px, py, pz, dx, dy, dz, dd, inv_dd, np.inf)
        sx, sy, sz = px + s * dx, py + s * dy, pz + s * dz
        share = min(grown[face] / np.sqrt(d2), 1.0) if len(grown) > 0 and d2 > 0.0 else 0.0
        on_segment[i, 0], on_segment[i, 1], on_segment[i, 2] = sx, sy, sz
        on_mesh[i, 0], on_mesh[i, 1], on_mesh[i, 2] = x + share * (sx - x), y + share * (sy - y), z + share * (sz - z)


@kernel(error_model="numpy")
def clearances(boxes, child, faces, grown, index, starts, ends, radii, horizon, slack, links, steps, value, triangle):
    """Fill the clearances of links[0] … links[1] - 1 over steps[0] … steps[1] - 1; see `Scene.clearance`.

    A link that was found to be at least `lower` away at an earlier step, and none of whose ends has moved
    farther than m since, is still at least lower - m away: beyond the horizon it is not looked at again.
    """
    nodes, bounds = np.empty(_STACK, np.int32), np.empty(_STACK)
    for j in range(links[0], links[1]):
        reach = horizon + radii[j]
        known, lower, seen = _NONE, -np.inf, steps[0]
        for i in range(steps[0], steps[1]):
            px, py, pz = starts[i, j, 0], starts[i, j, 1], starts[i, j, 2]
            qx, qy, qz = ends[i, j, 0], ends[i, j, 1], ends[i, j, 2]
            if lower > reach:
                mx, my, mz = px - starts[seen, j, 0], py - starts[seen, j, 1], pz - starts[seen, j, 2]
                nx, ny, nz = qx - ends[seen, j, 0], qy - ends[seen, j, 1], qz - ends[seen, j, 2]
                moved2 = max(mx * mx + my * my + mz * mz, nx * nx + ny * ny + nz * nz)
                if lower - np.sqrt(moved2) > reach:
                    value[i, j], triangle[i, j] = horizon, -1
                    continue
            dx, dy, dz = qx - px, qy - py, qz - pz
            limit = reach + slack
            best, face, passed = _search(
                boxes, child, faces, grown, nodes, bounds, px, py, pz, dx, dy, dz, limit, known
            )
            seen = i
            if face >= 0:
                known, lower = face, best
            else:
                lower = passed
            if face >= 0 and best < reach:
                value[i, j], triangle[i, j] = best - radii[j], index[face]
            else:
                value[i, j], triangle[i, j] = horizon, -1


@kernel(error_model="numpy")
def clearances_of_parts(
    boxes, child, faces, grown, index, starts, ends, radii, first, horizon, slack, parts, steps, value, triangle
):
    """Fill the clearances of parts[0] … parts[1] - 1, each the smallest of its links first[g] … first[g + 1] - 1.

    As `clearances`, but a link is only looked at where it may come closer than those of its part before it, of which
    the first is the one that was closest a step ago.
    """
    nodes, bounds = np.empty(_STACK, np.int32), np.empty(_STACK)
    for g in range(parts[0], parts[1]):
        count, closest = first[g + 1] - first[g], 0
        known, lower, seen = np.full(count, _NONE), np.full(count, -np.inf), np.full(count, steps[0])
        for i in range(steps[0], steps[1]):
            least, nearest_face, now = horizon, _NONE, closest
            for turn in range(count):
                c = closest if turn == 0 else (turn - 1 if turn <= closest else turn)
                j = first[g] + c
                reach = least + radii[j]
                px, py, pz = starts[i, j, 0], starts[i, j, 1], starts[i, j, 2]
                qx, qy, qz = ends[i, j, 0], ends[i, j, 1], ends[i, j, 2]
                if lower[c] > reach:
                    k = seen[c]
                    mx, my, mz = px - starts[k, j, 0], py - starts[k, j, 1], pz - starts[k, j, 2]
                    nx, ny, nz = qx - ends[k, j, 0], qy - ends[k, j, 1], qz - ends[k, j, 2]
                    of_start, of_end = mx * mx + my * my + mz * mz, nx * nx + ny * ny + nz * nz
                    if lower[c] - np.sqrt(max(of_start, of_end)) > reach:
                        continue
                dx, dy, dz, limit = qx - px, qy - py, qz - pz, reach
                if nearest_face < 0:  # else more would only be looked for in vain
                    limit += slack
                best, face, passed = _search(
                    boxes, child, faces, grown, nodes, bounds, px, py, pz, dx, dy, dz, limit, known[c]
                )
                seen[c], lower[c] = i, passed
                if face >= 0:
                    known[c], lower[c] = face, best
                    if best < reach:
                        least, nearest_face, now = best - radii[j], face, c
            value[i, g], triangle[i, g] = least, (index[nearest_face] if nearest_face >= 0 else -1)
            closest = now
