# SPDX-License-Identifier: GPL-3.0-or-later
"""What bench-expression measures, by one thread of numpy: expression_numpy.py [ROWS]."""
import sys
import time

import numpy as np

rows = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000_000
rng = np.random.default_rng(1)
x, y, px = (rng.uniform(-w, w, rows) for w in (1e-3, 1e-3, 5e3))
pz = rng.uniform(5e6 - 5e3, 5e6 + 5e3, rows)
for text, formula in (
        ("hypot(x,y)", lambda: np.hypot(x, y)),
        ("pz*1e-9", lambda: pz * 1e-9),
        ("sqrt(x^2+y^2)/pz", lambda: np.sqrt(x**2 + y**2) / pz),
        ("(x*px+y*y)/(x^2+y^2)-pz*1e-9", lambda: (x * px + y * y) / (x**2 + y**2) - pz * 1e-9),
        ("where(x>0 and y<0,hypot(x,y),px/pz)", lambda: np.where((x > 0) & (y < 0), np.hypot(x, y), px / pz)),
        ("atan2(y,x)", lambda: np.arctan2(y, x)),
        ("exp(-x^2)*sin(y)", lambda: np.exp(-(x**2)) * np.sin(y))):
    best = 1e9
    for _ in range(5):
        begun = time.perf_counter()
        formula()
        best = min(best, time.perf_counter() - begun)
    print(f"{text:<40} {best * 1e3:8.1f} ms {best * 1e9 / rows:6.2f} ns a row")
