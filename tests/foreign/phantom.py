# SPDX-License-Identifier: GPL-3.0-or-later
"""One known volume without any symmetry, and how it lies: what every generated file says in its own way."""
import numpy

SIZES = (5, 4, 6)  # along x, y, z
# All different, 0 to 119, so that no two voxels can be exchanged unseen, and no turn or mirror image is the same.
VALUES = numpy.random.default_rng(31).permutation(120).reshape(SIZES[::-1])  # [z, y, x]

# A patient's voxels, oblique, in right, anterior, superior and mm.
SPACING = (0.75, 1.5, 2.25)
ORIGIN = (-12.5, 31.25, 7.0)


def rotation(a, b, c):
    def about(axis, angle):
        matrix = numpy.eye(3)
        i, j = [k for k in range(3) if k != axis]
        matrix[i, i] = matrix[j, j] = numpy.cos(angle)
        matrix[i, j], matrix[j, i] = -numpy.sin(angle), numpy.sin(angle)
        return matrix
    return about(0, a) @ about(1, b) @ about(2, c)


def affine(directions, origin=ORIGIN, spacing=SPACING):
    """From indices x, y, z to the world."""
    matrix = numpy.eye(4)
    matrix[:3, :3] = directions @ numpy.diag(spacing)
    matrix[:3, 3] = origin
    return matrix


OBLIQUE = affine(rotation(0.3, -0.2, 0.5))
PLAIN = affine(numpy.eye(3))
MIRRORED = affine(rotation(0.1, 0.4, -0.3) @ numpy.diag([-1, 1, 1]))  # indices are left-handed: legal everywhere
PLACES = {"plain": PLAIN, "oblique": OBLIQUE, "mirrored": MIRRORED}

# By letters, from that space to right, anterior, superior.
TO_RAS = {"RAS": (1, 1, 1), "LAS": (-1, 1, 1), "LPS": (-1, -1, 1)}


def said_in(place, space):
    """The 4 x 4 that a file in a space says of voxels that lie at `place` in RAS."""
    return numpy.diag([*TO_RAS[space], 1]) @ place
