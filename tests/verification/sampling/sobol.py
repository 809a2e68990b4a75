#!/usr/bin/env python3
"""Writes sobol.json (points to compare with) and the table of src/samples/sampling/joe_kuo.rs, both from SciPy.

Usage: sobol.py, with scipy 1.17.1 and numpy 2.4.6. SciPy's direction numbers are the file new-joe-kuo-6.21201 of
S. Joe and F. Y. Kuo, https://web.maths.unsw.edu.au/~fkuo/sobol/, under the BSD licence printed there.
"""

import json
import os
import pathlib

import numpy
import scipy
from scipy.stats import _sobol, qmc

HERE = pathlib.Path(__file__).parent
DIMENSIONS = 64
POINTS = 128
FAR = 1 << 20  # points far out, by SciPy's own fast_forward

table = numpy.load(os.path.join(os.path.dirname(_sobol.__file__), "_sobol_direction_numbers.npz"))
lines = []
for polynomial, start in zip(table["poly"][:DIMENSIONS], table["vinit"][:DIMENSIONS]):
    degree = int(polynomial).bit_length() - 1
    numbers = ", ".join(str(int(m)) for m in start[: max(degree, 1)])
    lines.append(f"    ({int(polynomial)}, &[{numbers}]),")
target = HERE.parents[2] / "src" / "samples" / "sampling" / "joe_kuo.rs"
head = target.read_text().split("\n    (1, &[1]),")[0]
target.write_text("\n".join([head, *lines, "];", ""]))

first = qmc.Sobol(DIMENSIONS, scramble=False).random(POINTS)
far = qmc.Sobol(DIMENSIONS, scramble=False).fast_forward(FAR).random(4)
# 30 bits: exact integers
as_integers = lambda points: [[int(x * 2**30) for x in row] for row in points]
assert (numpy.array(as_integers(first)) / 2**30 == first).all()
content = {
    "scipy": scipy.__version__,
    "numpy": numpy.__version__,
    "unit": "2^-30",
    "first": as_integers(first[:, :]),
    "far_index": FAR,
    "far": as_integers(far),
}
text = json.dumps(content)
(HERE / "sobol.json").write_text(text.replace("], [", "],\n [") + "\n")
