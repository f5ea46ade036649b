# SPDX-License-Identifier: GPL-3.0-or-later
#
# A toroidal coil about the y axis, as OBJ on stdout: its ring, or the wire that is wound about it.
#   awk -f coil.awk -v part=ring
#   awk -f coil.awk -v part=wire
BEGIN {
    pi = atan2(0, -1); radius = 1
    if (part == "ring") { along = 240; around = 96; thick = 0.32; turns = 0 }
    else { along = 960; around = 24; thick = 0.085; turns = 10 }
    for (j = 0; j < along; ++j) for (i = 0; i < around; ++i) vertex(2 * pi * j / along, 2 * pi * i / around)
    for (j = 0; j < along; ++j) for (i = 0; i < around; ++i) {
        a = number(j, i); b = number(j, i + 1); c = number(j + 1, i + 1); d = number(j + 1, i)
        print "f", a, c, b
        print "f", a, d, c
    }
}
function number(j, i) { return (j % along) * around + i % around + 1 }

# A place on the tube about the middle line. Its normals: n away from the ring's middle line and b across it, or
# of the ring, whose middle line is its own, in the plane of it and along the axis.
function vertex(t, s,   u, out, n1, n2, n3, d1, d2, d3, d, x, y, z, b1, b2, b3) {
    if (turns == 0) {
        out = radius + thick * cos(s)
        printf "v %.6f %.6f %.6f\n", out * cos(t), thick * sin(s), out * sin(t)
        return
    }
    u = turns * t; out = radius + 0.4 * cos(u)
    x = out * cos(t); y = 0.4 * sin(u); z = out * sin(t)
    d1 = -0.4 * turns * sin(u) * cos(t) - out * sin(t)
    d2 = 0.4 * turns * cos(u)
    d3 = -0.4 * turns * sin(u) * sin(t) + out * cos(t)
    d = sqrt(d1 * d1 + d2 * d2 + d3 * d3); d1 /= d; d2 /= d; d3 /= d
    n1 = cos(u) * cos(t); n2 = sin(u); n3 = cos(u) * sin(t)   # across the way: the wire keeps its distance
    b1 = d2 * n3 - d3 * n2; b2 = d3 * n1 - d1 * n3; b3 = d1 * n2 - d2 * n1
    printf "v %.6f %.6f %.6f\n", x + thick * (cos(s) * n1 + sin(s) * b1),
        y + thick * (cos(s) * n2 + sin(s) * b2), z + thick * (cos(s) * n3 + sin(s) * b3)
}
