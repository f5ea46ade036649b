# SPDX-License-Identifier: GPL-3.0-or-later
#
# A pipe along z around a plot [-1, 1]^3, as OBJ on stdout: two thirds of a round wall, and a flange at each end.
#   awk -f pipe.awk -v radius=0.8 -v half=1.25 -v flange=0.12      (half: its half length)
BEGIN {
    pi = atan2(0, -1); around = 180; along = 120; rings = 12
    # The opening looks to +x and up.
    from = 0.42 * pi; to = 1.75 * pi
    for (j = 0; j <= along; ++j) for (i = 0; i <= around; ++i) {
        a = from + (to - from) * i / around
        printf "v %.6f %.6f %.6f\n", radius * cos(a), radius * sin(a), half * (2 * j / along - 1)
    }
    grid(1, along)
    next_vertex = 1 + (along + 1) * (around + 1)
    for (side = -1; side <= 1; side += 2) {
        for (j = 0; j <= rings; ++j) for (i = 0; i <= around; ++i) {
            a = from + (to - from) * i / around; r = radius + flange * j / rings
            printf "v %.6f %.6f %.6f\n", r * cos(a), r * sin(a), half * side
        }
        grid(next_vertex, rings)
        next_vertex += (rings + 1) * (around + 1)
    }
}
function grid(first, rows,   i, j, k) {
    for (j = 0; j < rows; ++j) for (i = 0; i < around; ++i) {
        k = first + j * (around + 1) + i
        print "f", k, k + 1, k + around + 2
        print "f", k, k + around + 2, k + around + 1
    }
}
