# SPDX-License-Identifier: GPL-3.0-or-later
"""A generator of particles that nobody chose: sheets, curves, knots, rings, shells, crossing planes, lattices, gases,
power-law halos and clusters, of 1 to 10^6 particles, with extents from 1e-6 to 1 and weights over 10^4."""
import numpy

FORMS = ("gas", "gaussian", "sheet", "disc", "curve", "ring", "knot", "shell", "planes", "lattice", "halo", "clusters",
         "beams", "band")


def _turned(random, points):
    """Points in a random orientation."""
    q, _ = numpy.linalg.qr(random.normal(size=(3, 3)))
    return points @ q


def _thick(random, points, extent):
    return points + extent * random.normal(size=points.shape)


def _gas(random, n):
    return random.uniform(-1, 1, (n, 3))


def _gaussian(random, n):
    return random.normal(size=(n, 3)) * 10.0 ** random.uniform(-2, 0, 3)


def _sheet(random, n):
    flat = numpy.c_[random.uniform(-1, 1, (n, 2)), numpy.zeros(n)]
    return _turned(random, _thick(random, flat, 10.0 ** random.uniform(-6, -2)))


def _disc(random, n):
    flat = numpy.c_[0.3 * random.normal(size=(n, 2)), numpy.zeros(n)]
    return _turned(random, _thick(random, flat, 10.0 ** random.uniform(-6, -2)))


def _curve(random, n):
    t = random.uniform(0, 1, n)[:, None]
    a, b, c = random.normal(size=(3, 1, 3))
    return _thick(random, a * t + b * t ** 2 + c * t ** 3, 10.0 ** random.uniform(-5, -1.5))


def _ring(random, n):
    phase = random.uniform(0, 2 * numpy.pi, n)
    flat = numpy.c_[numpy.cos(phase), numpy.sin(phase), numpy.zeros(n)]
    return _turned(random, _thick(random, flat, 10.0 ** random.uniform(-5, -1)))


def _knot(random, n):
    p, q = random.integers(2, 6, 2)
    phase = random.uniform(0, 2 * numpy.pi, n)
    r = 2 + numpy.cos(q * phase)
    knot = numpy.c_[r * numpy.cos(p * phase), r * numpy.sin(p * phase), numpy.sin(q * phase)] / 3
    return _turned(random, _thick(random, knot, 10.0 ** random.uniform(-4, -1.3)))


def _shell(random, n):
    points = random.normal(size=(n, 3))
    points /= numpy.linalg.norm(points, axis=1)[:, None]
    return points * (1 + 10.0 ** random.uniform(-6, -1) * random.normal(size=(n, 1)))


def _planes(random, n):
    parts = numpy.array_split(numpy.arange(n), 3)
    return numpy.concatenate([_sheet(random, len(part)) for part in parts])


def _lattice(random, n):
    side = max(2, round(n ** (1 / 3) / random.integers(1, 4)))
    return random.integers(0, side, (n, 3)) / side + 1e-4 * random.normal(size=(n, 3))


def _halo(random, n):
    radius = random.pareto(random.uniform(1.2, 3), (n, 1)).clip(0, 1e3) + 1e-3
    points = random.normal(size=(n, 3))
    return points / numpy.linalg.norm(points, axis=1)[:, None] * radius


def _clusters(random, n):
    count = int(random.integers(1, 30))
    centres, sizes = random.uniform(-1, 1, (count, 3)), 10.0 ** random.uniform(-4, -0.5, (count, 1))
    which = random.integers(0, count, n)
    return centres[which] + sizes[which] * random.normal(size=(n, 3))


def _beams(random, n):
    one, two = _gaussian(random, n // 2), _gaussian(random, n - n // 2)
    return numpy.concatenate([_turned(random, one), _turned(random, two)])


def _band(random, n):
    y = 0.4 * random.normal(size=n)
    return numpy.c_[random.normal(size=n), y, y * (1 + 1e-6 * random.normal(size=n))]


_MAKE = {name[1:]: make for name, make in list(globals().items()) if name.startswith("_") and name[1:] in FORMS}


def weights(random, n):
    kind = random.integers(0, 4)
    if kind == 0:
        return 10.0 ** random.uniform(-2, 2, n)
    if kind == 1:
        return numpy.where(numpy.arange(n) % 2, 1.0, 100.0)
    return numpy.ones(n)


def particles(seed, most=1_000_000):
    """Form, places (n, 3), weights of a set; each seed gives another."""
    random = numpy.random.default_rng(seed)
    form = FORMS[seed % len(FORMS)]
    n = int(10.0 ** random.uniform(0, numpy.log10(most)))
    return form, _MAKE[form](random, n) * 10.0 ** random.uniform(-6, 3, 3), weights(random, n)
