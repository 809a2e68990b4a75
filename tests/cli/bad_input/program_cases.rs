//! Study files that the program alone refuses: JSON Schema cannot say why.

use super::cases::Case;

/// Refused by the program alone: values that are compared with each other, or with files.
pub(crate) const BEYOND_SCHEMA: &[Case] = &[
    (
        "[contact]\nlaw",
        "[[model.contact]]\nname = \"c1\"\nt1 = { x1 = 1 }\nk_t1 = 1\nmu = 0.1\nn = { x2 = 1 }\nk_n = 1\n[contact]\nlaw",
        &[":25: model.contact[1].name = c1: must not be given twice"],
    ),
    (
        "[output]",
        "[[criteria]]\nname = \"a\"\nquantity = \"amplitude-um\"\nlimit = 1\n[[criteria]]\n\
             name = \" a \"\nquantity = \"amplitude-um\"\nlimit = 2\n[output]",
        &[":44: criteria[1].name = ", "must not be given twice"],
    ),
    (
        "[output]",
        "[stress]\nmodal_stress_mpa_per_um = 12\nmean_stress_mpa = 900000\nendurance_limit_mpa = 350\n\
             ultimate_strength_mpa = 900\n[output]",
        &[":41: stress.mean_stress_mpa = 9e5: must be below ultimate_strength_mpa"],
    ),
    (
        "[output]",
        "[stress]\nmodal_stress_mpa_per_um = 12\nmean_stress_mpa = 180\nendurance_limit_mpa = 900\n\
             ultimate_strength_mpa = 350\n[output]",
        &[":42: stress.endurance_limit_mpa = 900: must be below ultimate_strength_mpa"],
    ),
    (
        "[output]",
        "[stress]\nmodal_stress_mpa_per_um = 12\nmean_stress_mpa = 180\nendurance_limit_mpa = 350\n\
             ultimate_strength_mpa = 350\n[output]",
        &[":42: stress.endurance_limit_mpa = 350: must be below ultimate_strength_mpa"],
    ),
    (
        "time_points = 128",
        "time_points = 65536\nalert = { highest_harmonic = 200 }",
        &[
            ":34: solver.time_points = 65536: times the highest",
            "16777216",
        ],
    ),
    (
        "[1.0, 2.0]",
        "[1.0, 0.5]",
        &[":4: levels[1] = 0.5: must be greater"],
    ),
    (
        "low = 0.1",
        "low = 0.9",
        &[":30: inputs.friction_coefficient.high = 0.8: must be"],
    ),
    (
        "high = 0.8",
        "high = 0.8\ntruncation = [0, 1]",
        &[":31: ", ".truncation = [0, 1]: must lie"],
    ),
    (
        "time_points = 128",
        "time_points = 20",
        &[":34: solver.time_points = 20: must be more"],
    ),
    (
        "[100, 200]",
        "[200, 100]",
        &[":37: frequency.band_hz = [200, 100]: must be [low"],
    ),
    (
        "t1 = { x1 = 1.0 }",
        "t1 = { x3 = 1.0 }",
        &[":18: model.contact[0].t1.x3 = 1: must name a degree"],
    ),
    (
        "cosine_force = { x1",
        "cosine_force = { y",
        &[":13: model.cosine_force.y"],
    ),
    (
        "[output]",
        "[output]\nfolder = \"mass.mtx\"",
        &[":40: output.folder = mass.mtx: must be a folder: a file has this name"],
    ),
    (
        "mass = \"mass.mtx\"",
        "mass = \"mass.mtx\"\nmirror = \"mass.mtx\"",
        &[
            "mass.mtx: must be a mirror: one entry 1 or -1 in each column",
            "study.toml names it: model.mass (line 8), model.mirror (line 9)",
        ],
    ),
    (
        "{ x1 = 1.0 }\nresp",
        "{ x1 = 0.0 }\nresp",
        &[":13: model.cosine_force", "zero"],
    ),
    (
        "responses = [\"x1\"]",
        "responses = [\"x9\"]",
        &[":14: model.responses[0].x9", "degree"],
    ),
    (
        "[\"x1\", \"x2\"]",
        "[\"x1\"]",
        &[":11: model.dof_names = 1 names: must be 2"],
    ),
    (
        "[output]",
        "[[criteria]]\nname = \"a\"\nquantity = \"amplitude-um\"\nlimit = 1\n[[criteria]]\n\
             name = \"a\"\nquantity = \"amplitude-um\"\nlimit = 2\n[output]",
        &[":44: criteria[1].name = a: must not be given twice"],
    ),
];
