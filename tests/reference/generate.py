#!/usr/bin/env python3
"""Converts the reference problems to study files, Matrix Market matrices and compact reference values.

Usage: generate.py SOURCE   (SOURCE holds <case>/problem.json, <case>/reference.json, fixed-discretisation.json, lb2/values.txt)
SOURCE is the output of other codes and not part of the repository: README.md.
Writes next to itself; python3, standard library only. Numbers keep all digits of the source.
"""

import json
import math
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).parent

SOURCES = """The values come from independent harmonic balance codes (NLvib 1.3, tmdsimpy 1.0.0, pyHarm 1.2.2, octave-jim) and
from Newmark time marching (average acceleration, implicit contact), as stated per value."""

CONVENTIONS = """
## Conventions

- q(t) = q0 + sum ck cos(k w t) + sk sin(k w t); coefficients in the order 0, c1, s1, c2, s2, ...
- f(t) = static_force + level * (cosine_force cos(w t) + sine_force sin(w t))
- relative displacements t1, t2, n are the tables of the contact; n > 0 is compression; N = max(0, n_0 + k_n n)
- slider at zero displacement with zero traction just before the sample w t = 0; contact states are decided at the
  samples (`events = "sampled"`)
- `fixed.json`: solutions at a fixed discretisation: harmonics H, Nt points, `loops` passes over the period (null: until
  the slider is periodic), `harmonics[frequency][coefficient][dof]` of the named degrees of freedom. To be met to 1e-9
  of the largest coefficient: the codes agree with them to 1e-12.
- `peaks.json`: per level the resonance peak, the amplitude at that frequency against (H, Nt), time marching, and
  `curve`: first-harmonic amplitudes `[frequency][dof]` of the responses of `study.toml` at H and Nt.
"""

CASES = {
    "jenkins-1dof": ("a_1dof_jenkins", 9, 256),
    "varying-normal-3dof": ("b1_3dof_varN", 9, 256),
    "blades-strip-oop": ("c_oop", 5, 256),
}


def quoted(name):
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name)


def table(names, row):
    return "{ " + ", ".join(f"{quoted(d)} = {v!r}" for d, v in zip(names, row) if v) + " }"


def write_matrix(path, a):
    n = len(a)
    symmetric = all(a[i][j] == a[j][i] for i in range(n) for j in range(i))
    entries = [(i, j, a[i][j]) for j in range(n) for i in range(j if symmetric else 0, n) if a[i][j]]
    kind = "symmetric" if symmetric else "general"
    lines = [f"%%MatrixMarket matrix coordinate real {kind}", f"{n} {n} {len(entries)}"]
    lines += [f"{i + 1} {j + 1} {v!r}" for i, j, v in entries]
    path.write_text("\n".join(lines) + "\n")


def forces(names, problem):
    parts = {"static_force": problem["static_force"], "cosine_force": problem["harmonic_force"]["cos"],
             "sine_force": problem["harmonic_force"]["sin"]}
    return [f"{key} = {table(names, row)}" for key, row in parts.items() if any(row)]


def contacts(names, problem):
    lines = []
    for c in problem["contacts"]:
        lines += ["", "[[model.contact]]", f'name = "{c["name"]}"']
        for key, row, k_key, k in [("t1", c["B_t1"], "k_t1", c["kt1"]), ("t2", c["B_t2"], "k_t2", c["kt2"]),
                                   ("n", c["B_n"], "k_n", c["kn"])]:
            if row and any(row):
                lines += [f"{key} = {table(names, row)}", f"{k_key} = {k!r}"]
        lines += [f"mu = {c['mu']!r}", f"n_0 = {c['N0']!r}"]
    return lines


def study(case, problem, responses, harmonics, time_points):
    names, frequency = problem["dof_names"], problem["frequency"]
    suffix = {"Hz": "hz", "rad/s": "rad_s"}[frequency["unit"]]
    lines = [f"# {problem['description']}", f'name = "{case}"', f"levels = {problem['levels']}", "",
             "[model]", 'kind = "matrices"', 'mass = "mass.mtx"', 'stiffness = "stiffness.mtx"',
             'damping = "damping.mtx"', f"dof_names = {json.dumps(names)}"]
    lines += forces(names, problem) + [f"responses = {json.dumps(responses)}"] + contacts(names, problem)
    lines += ["", "[contact]", f'law = "{problem["law"]}"', 'events = "sampled"', 'anchor = "unloaded"', "",
              "[solver]", f"harmonics = {harmonics}", f"time_points = {time_points}", "alert = false", "",
              "[frequency]", f"band_{suffix} = [{frequency['start']!r}, {frequency['end']!r}]",
              f"points = {frequency['n']}"]
    return "\n".join(lines) + "\n"


def peaks(reference, responses):
    at = [reference["dof_names"].index(name) for name in responses]
    levels = []
    for level in reference["levels"]:
        peak, keep = level["peak"], {"level": level["level"]}
        keep["frequency"] = peak.get("w", peak.get("f_hz"))
        keep["amplitude"] = peak.get("A1", peak.get("A1_m_H41"))
        keep["convergence"] = level.get("convergence_at_peak_w", level.get("convergence_at_peak_f"))
        marching = level.get("time_marching_at_peak_w", level.get("time_marching_at_peak_f"))
        if marching:
            keep["time_marching"] = {key: marching[key] for key in ("scheme", "steps_per_period", "A1") if key in marching}
            keep["time_marching"]["extrapolated"] = marching.get("A1_richardson", marching.get("A1_extrapolated"))
        # First harmonic of every named degree of freedom; nine digits are more than the comparison needs.
        amplitude = [[float(f"{math.hypot(h[1][i], h[2][i]):.9g}") for i in at] for h in level["harmonics"]]
        keep["curve"] = {"frequency": level.get("frequency", level.get("frequency_hz")), "amplitude": amplitude}
        levels.append(keep)
    head = {key: reference[key] for key in ("law", "H", "Nt", "slider_init")}
    return {**head, "levels": levels}


def compact(value):
    return json.dumps(value, separators=(",", ":")) + "\n"


def convert(source, case):
    name, harmonics, time_points = CASES[case]
    folder = HERE / case
    folder.mkdir(exist_ok=True)
    problem = json.loads((source / case / "problem.json").read_text())
    reference = json.loads((source / case / "reference.json").read_text())
    fixed = [c for c in json.loads((source / "fixed-discretisation.json").read_text())["cases"] if c["problem"] == name]
    for key, file in [("M", "mass"), ("C", "damping"), ("K", "stiffness")]:
        write_matrix(folder / f"{file}.mtx", problem[key])
    responses = fixed[0]["dof_names"]
    (folder / "study.toml").write_text(study(case, problem, responses, harmonics, time_points))
    keys = ("law", "loops", "H", "Nt", "level", "unit", "frequency", "dof_names", "harmonics", "verified")
    (folder / "fixed.json").write_text(compact([{k: c[k] for k in keys} for c in fixed]))
    (folder / "peaks.json").write_text(compact(peaks(reference, responses)))
    readme = f"# {case}\n\n{problem['description']}\n\nUnits: {problem['units']}.\n\n{SOURCES}\n{CONVENTIONS}"
    (folder / "README.md").write_text(readme)


LB2 = """# Two lumped blades and a rigid strip ({phase}); see README.md.
name = "lb2-{phase}"
levels = [1, 10, 20, 40, 100]

[model]
kind = "matrices"
mass = "mass.mtx"
stiffness = "stiffness.mtx"
damping = "damping.mtx"
retention = "retention.mtx"
dof_names = ["x1", "x2", "X", "Y", "theta"]
static_force = {{ Y = 180.0 }}
cosine_force = {{ x1 = 1.0, x2 = {sign} }}
responses = ["x1", "x2", "X", "Y", "theta"]
{contacts}
[contact]
law = "box"
events = "interpolated"
anchor = "unloaded"

[solver]
harmonics = 5
time_points = 256
alert = false

[frequency]
band_hz = [300.0, 450.0]
"""

LB2_README = """# lb2: two lumped blades and a rigid strip

Two blades with one tangential translation each, a rigid strip (tangential, normal, rotation), four contact nodes.

- blades: m = 0.4 kg, k = 1.6e6 N/m, c = 2 zeta sqrt(k m) with zeta = 0.002
- strip: mass 1.58e-3 kg in X and Y, rotary inertia 1.58e-3 * 1e-4 / 12 kg m2, no stiffness and damping of its own
- nodes at a = (-4, -1, 1, 4) mm; 1, 2 on blade 1 and 3, 4 on blade 2; k_n = 2.5e6 N/m, k_t = 0.5825e6 N/m, mu = 0.6
- t1 = X - x_b; n = Y + a theta - (0.2 sigma_b + 100 (a - c_b)) x_b, sigma = (1, -1), c = (-2.5, 2.5) mm
- 180 N on Y; retention 1e3 N/m on X in harmonic 0 only
- in phase: F cos(w t) on both blades; out of phase: -F cos(w t) on blade 2

`values.csv`: an independent harmonic balance program (H = 5, 256 points, box law, closing instant interpolated),
cross-checked by implicit time integration, to 5 digits: fundamental cosine and sine of x1 (m), mean Y (m), mean normal
forces of nodes 1, 2, 4 (N), fundamental tangential force amplitude of node 1 (N), shares of stick, slip and lift-off
over nodes and time, and work per cycle (J).
"""


def lb2(source):
    folder = HERE / "lb2"
    folder.mkdir(exist_ok=True)
    mass, stiffness = 0.4, 1.6e6
    damping = 2 * 0.002 * (stiffness * mass) ** 0.5
    diagonals = {"mass": [mass, mass, 1.58e-3, 1.58e-3, 1.58e-3 * 1e-4 / 12],
                 "stiffness": [stiffness, stiffness, 0, 0, 0], "damping": [damping, damping, 0, 0, 0],
                 "retention": [0, 0, 1e3, 0, 0]}
    for name, diagonal in diagonals.items():
        n = len(diagonal)
        write_matrix(folder / f"{name}.mtx", [[diagonal[i] if i == j else 0 for j in range(n)] for i in range(n)])
    text = ""
    for j, a_mm in enumerate((-4, -1, 1, 4)):
        blade, sigma, c_mm = (1, 1, -2.5) if j < 2 else (2, -1, 2.5)
        slope = round(0.2 * sigma + 0.1 * (a_mm - c_mm), 12)
        text += f'\n[[model.contact]]\nname = "node{j + 1}"\nt1 = {{ X = 1.0, x{blade} = -1.0 }}\nk_t1 = 0.5825e6\n'
        text += f"n = {{ Y = 1.0, theta = {a_mm}e-3, x{blade} = {-slope!r} }}\nk_n = 2.5e6\nmu = 0.6\n"
        text += f"interface = {blade - 1}\n"
    for phase, sign in [("out-of-phase", "-1.0"), ("in-phase", "1.0")]:
        file = folder / ("study.toml" if phase == "out-of-phase" else "in-phase.toml")
        file.write_text(LB2.format(phase=phase, sign=sign, contacts=text))
    rows = ["phase,level_n,frequency_hz,x1_cos_m,x1_sin_m,y_mean_m,n1_mean_n,n2_mean_n,n4_mean_n,t1_amplitude_n,"
            "stick,slip,separated,work_input_j,work_viscous_j,work_friction_j"]
    for line in (source / "lb2" / "values.txt").read_text().splitlines():
        shares = [float(x) for x in re.search(r"st/sl/li (\S+)", line).group(1).split("/")]
        named = {k: float(v) for k, v in re.findall(r"(\|?\w+\|?)=\s*([-+\d.e]+)", line)}
        values = [named[k] for k in ("F", "f", "x1c", "x1s", "Y0", "N1_0", "N2_0", "N4_0", "|T1_1|")] + shares
        values += [named[k] for k in ("Win", "Wvisc", "Wfric")]
        phase = "out-of-phase" if line.startswith("OOP") else "in-phase"
        rows.append(",".join([phase] + [repr(v) for v in values]))
    (folder / "values.csv").write_text("\n".join(rows) + "\n")
    (folder / "README.md").write_text(LB2_README)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for case_name in CASES:
        convert(pathlib.Path(sys.argv[1]), case_name)
    lb2(pathlib.Path(sys.argv[1]))
