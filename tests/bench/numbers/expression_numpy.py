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
    clock = processor = 1e9
    for _ in range(2):
        begun, used = time.perf_counter(), time.process_time()
        formula()
        clock, processor = min(clock, time.perf_counter() - begun), min(processor, time.process_time() - used)
    print(f"{text:<40} {clock * 1e3:8.1f} ms, {processor * 1e3:8.1f} ms of processors")
