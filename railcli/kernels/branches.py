"""Minima at neighbouring grid poses joined into the branches of a contact table's cells (theory.md section 4).

Poses are ordered roll, yaw^2, y (fastest). Corner c of a cell lies at its upper y, roll, yaw^2 where bit 0, 1, 2 of c
is set; direction 0, 1, 2 is that of y, roll, yaw^2.
"""

import numpy as np

from .jit import builder, kernel
from .layout import Node

PER_CORNER = 4  # minima kept per grid pose


@kernel
def same_branch(node, basin, a, b):
    """True when each of two minima lies in the other's basin."""
    sa, sb = node[a, Node.LATERAL], node[b, Node.LATERAL]
    return basin[b, 0] < sa and sa < basin[b, 1] and basin[a, 0] < sb and sb < basin[a, 1]


@kernel
def link_nodes(first, node, basin, ny, nr, nw, link):
    """Link every minimum with its continuation at the next pose of each direction: link (n_node, 3), -1 where none.

    first : (n_pose + 1,) first node of each pose.  basin : (n_node, 2) ends of each minimum's basin [m].
    """
    for ir in range(nr):
        for iw in range(nw):
            for iy in range(ny):
                pose = (ir * nw + iw) * ny + iy
                for a in range(first[pose], first[pose + 1]):
                    for d in range(3):
                        link[a, d] = -1
                        if (iy, ir, iw)[d] == (ny, nr, nw)[d] - 1:
                            continue
                        after = pose + (1, nw * ny, ny)[d]
                        for b in range(first[after], first[after + 1]):
                            if same_branch(node, basin, a, b):
                                link[a, d] = b


@kernel
def gather(first, link, ny, nw, ir, iw, iy, member, corner, label):
    """Minima at the corners of one cell, labelled alike where they hang together along its edges.

    Returns how many they are, and how many links join them.
    """
    n = 0
    for c in range(8):
        pose = ((ir + ((c >> 1) & 1)) * nw + iw + (c >> 2)) * ny + iy + (c & 1)
        for k in range(first[pose], first[pose + 1]):
            member[n], corner[n], label[n] = k, c, n
            n += 1
    return n, join(link, member, corner, label, n, 0)


@kernel
def join(link, member, corner, label, n, face):
    """Give linked minima one label; face : 0 for the whole cell, else as `on_face`. Returns the number of links."""
    links = 0
    for a in range(n):
        for d in range(3):
            b = link[member[a], d]
            if b < 0 or corner[a] & (1 << d) or not (on_face(corner[a], face) and on_face(corner[a] | 1 << d, face)):
                continue
            for k in range(a + 1, n):
                if member[k] == b and corner[k] == corner[a] | 1 << d:
                    links += 1
                    low, high = min(label[a], label[k]), max(label[a], label[k])
                    for m in range(n):
                        if label[m] == high:
                            label[m] = low
    return links


@kernel
def on_face(corner, face):
    """True when a corner lies on face 1 ... 6: below and above in y, roll, yaw^2; face 0 is the whole cell."""
    if face == 0:
        return True
    return (corner >> ((face - 1) // 2)) & 1 == (face - 1) % 2


@kernel
def knotted(link, member, corner, label, on_this, n):
    """Label of a branch that a face of the cell does not join as the cell does, or that meets a corner twice; -1: none.

    Such a branch winds around a cusp of the difference surface; the cell next door would join it otherwise, and the
    contact would jump between them.
    """
    for face in range(1, 7):
        for k in range(n):
            on_this[k] = k
        join(link, member, corner, on_this, n, face)
        for a in range(n):
            for b in range(a + 1, n):
                if label[a] == label[b] and on_this[a] != on_this[b]:
                    if on_face(corner[a], face) and on_face(corner[b], face):
                        return label[a]
    return -1


@kernel
def cut_longest(node, link, member, corner, label, n, which):
    """Cut the link of one branch within a cell along which the contact moves farthest."""
    farthest, cut_node, cut_direction = -1.0, -1, -1
    for a in range(n):
        if label[a] != which:
            continue
        for d in range(3):
            b = link[member[a], d]
            if b < 0 or corner[a] & (1 << d):
                continue
            moved = abs(node[b, Node.LATERAL] - node[member[a], Node.LATERAL])
            if moved > farthest:
                farthest, cut_node, cut_direction = moved, member[a], d
    link[cut_node, cut_direction] = -1


@builder
def cut_knots(first, node, link, ny, nr, nw):
    """Cut links until the cells on both sides join every face alike. Returns the number of cuts."""
    member, corner = np.empty(8 * PER_CORNER, np.int64), np.empty(8 * PER_CORNER, np.int64)
    label, on_this = np.empty(8 * PER_CORNER, np.int64), np.empty(8 * PER_CORNER, np.int64)
    unsure = np.ones((nr - 1, nw - 1, ny - 1), np.bool_)
    cuts, before = 0, -1
    while cuts != before:
        before = cuts
        for ir in range(nr - 1):
            for iw in range(nw - 1):
                for iy in range(ny - 1):
                    if not unsure[ir, iw, iy]:
                        continue
                    unsure[ir, iw, iy] = False
                    n, links = gather(first, link, ny, nw, ir, iw, iy, member, corner, label)
                    if n == 8 and links == 12:
                        continue
                    which = knotted(link, member, corner, label, on_this, n)
                    while which >= 0:
                        cut_longest(node, link, member, corner, label, n, which)
                        cuts += 1
                        unsure[max(ir - 1, 0) : ir + 2, max(iw - 1, 0) : iw + 2, max(iy - 1, 0) : iy + 2] = True
                        gather(first, link, ny, nw, ir, iw, iy, member, corner, label)
                        which = knotted(link, member, corner, label, on_this, n)
    return cuts


@builder
def fill_slopes(node, link, y_step, roll_step, yaw2_step):
    """Slopes of contact angle and place in every node, by differences along its branch.

    Central between two neighbours; at the end of a branch or of the table that of the parabola through the next two, or
    the difference to the only one. No slope is more than twice a difference beside it of its sign (van Leer 1977),
    so that a fast motion of the contact between two poses does not swing past them.
    """
    count = node.shape[0]
    back = np.full((count, 3), -1, np.int32)
    for a in range(count):
        for d in range(3):
            if link[a, d] >= 0:
                back[link[a, d], d] = a
    step = (y_step, roll_step, yaw2_step)
    for a in range(count):
        for d in range(3):
            after, before = link[a, d], back[a, d]
            for k in range(2):
                value = (Node.SLOPE.value, Node.LATERAL.value)[k]
                change = 0.0
                if after >= 0 and before >= 0:
                    change = limited(node[after, value] - node[a, value], node[a, value] - node[before, value], 0.5)
                elif after >= 0:
                    change = node[after, value] - node[a, value]
                    if link[after, d] >= 0:
                        change = limited(change, node[link[after, d], value] - node[after, value], 1.5)
                elif before >= 0:
                    change = node[a, value] - node[before, value]
                    if back[before, d] >= 0:
                        change = limited(change, node[before, value] - node[back[before, d], value], 1.5)
                node[a, Node.SLOPE_Y.value + 3 * d + k] = change / step[d]


@kernel
def limited(near, far, share):
    """share near + (1 - share) far, no larger than twice the smaller of both where they have one sign."""
    change = share * near + (1.0 - share) * far
    if near * far > 0.0:
        most = 2.0 * min(abs(near), abs(far))
        change = min(max(change, -most), most)
    return change


@builder
def join_cells(first, node, link, ny, nr, nw, cell, branch):
    """Write the branches of every cell.

    cell : (n_cell + 1,) filled; branch : (capacity, 8) filled with node indices, -1 where the branch does not reach.
    Returns the number of branches (over capacity: nothing more was written) and of those that end within their cell.
    """
    member, corner = np.empty(8 * PER_CORNER, np.int64), np.empty(8 * PER_CORNER, np.int64)
    label = np.empty(8 * PER_CORNER, np.int64)
    count, ended, place = 0, 0, 0
    for ir in range(nr - 1):
        for iw in range(nw - 1):
            for iy in range(ny - 1):
                cell[place] = count
                place += 1
                n, _ = gather(first, link, ny, nw, ir, iw, iy, member, corner, label)
                start = count
                for a in range(n):
                    if label[a] != a:
                        continue
                    if count < branch.shape[0]:
                        ended += write_branch(branch, count, member, corner, label, n, a)
                    count += 1
                order_branches(node, branch, start, min(count, branch.shape[0]))
    cell[place] = count
    return count, ended


@kernel
def write_branch(branch, row, member, corner, label, n, which):
    """Write the corners of one branch; returns 1 when it does not reach all of them."""
    for c in range(8):
        branch[row, c] = -1
    reached = 0
    for k in range(n):
        if label[k] == which:
            branch[row, corner[k]] = member[k]
            reached += 1
    return 1 if reached < 8 else 0


@kernel
def order_branches(node, branch, start, stop):
    """Sort branches start ... stop - 1 of one cell from the flange to the field side."""
    for a in range(start + 1, stop):
        b = a
        while b > start and mean_lateral(node, branch[b]) < mean_lateral(node, branch[b - 1]):
            for c in range(8):
                branch[b, c], branch[b - 1, c] = branch[b - 1, c], branch[b, c]
            b -= 1


@kernel
def mean_lateral(node, corners):
    """Mean profile coordinate of a branch over the corners that it reaches [m]."""
    total, n = 0.0, 0
    for c in range(8):
        if corners[c] >= 0:
            total += node[corners[c], Node.LATERAL]
            n += 1
    return total / max(n, 1)
