//! Study files that the program and the JSON Schema refuse: one list for both. What the schema cannot say is in `program_cases`.

/// What is replaced in the study of these tests, by what, and what the message must name.
pub(crate) type Case = (&'static str, &'static str, &'static [&'static str]);

/// Refused by the program and by the schema.
pub(crate) const REFUSED: &[Case] = &[
    (
        "time_points = 128",
        "alert = { highest_harmonic = 1000000000 }",
        &[
            ":34: solver.alert.highest_harmonic = 1000000000: ",
            "from 1 to 200",
        ],
    ),
    (
        "harmonics = 5",
        "harmonics = 1000000000",
        &[":33: solver.harmonics = 1000000000: ", "from 1 to 200"],
    ),
    (
        "[inputs.friction_coefficient]",
        "[inputs]\nfrom = 3\n[inputs.friction_coefficient]",
        &[":28: inputs.from: ", "expected a file name in quotes"],
    ),
    (
        "[inputs.friction_coefficient]",
        "[inputs]\nnormal_stiffness = \"nominal\"\n[inputs.friction_coefficient]",
        &[
            ":28: inputs.normal_stiffness: ",
            "unknown variant `nominal`",
        ],
    ),
    (
        "[inputs.friction_coefficient]",
        "[inputs]\nnormal_stiffness = \"with-tangential\"\n[inputs.friction_coefficient]",
        &[":28: inputs.normal_stiffness = (given): must be absent without inputs.from"],
    ),
    (
        "band_hz = [100, 200]",
        "band_hz = [100, 200]\nvalues_hz = [150, 1e300]",
        &[":38: frequency.values_hz[1] = 1e300: must be from 1e-6 to 1e9"],
    ),
    (
        "samples = 10",
        "samples = 0",
        &[":3: samples = 0: must be from 1"],
    ),
    ("samples = 10", "samples = -4", &[":3: samples: ", "-4"]),
    (
        "samples = 10",
        "samples = 1.5",
        &[
            ":3: samples: ",
            "floating point `1.5`, expected a whole number >= 0",
        ],
    ),
    (
        "harmonics = 5",
        "harmonics = 5\nstability = true",
        &[":34: solver.stability: expected one of its names, a text in quotes"],
    ),
    (
        "samples = 10",
        "samples = { until = \"decided\", at_most = 0 }",
        &[":3: ", "samples.at_most = 0: must be from 1 to"],
    ),
    (
        "samples = 10",
        "samples = { until = \"decided\", at_most = 10 }",
        &[
            ":3: ",
            "samples.until = \"decided\": needs a criterion to decide",
        ],
    ),
    (
        "samples = 10",
        "samples = { until = \"decided\" }",
        &[":3: ", "samples: missing field `at_most`"],
    ),
    (
        "samples = 10",
        "samples = { until = \"bored\", at_most = 10 }",
        &[
            ":3: ",
            "unknown variant `bored`, expected `decided` or `width`",
        ],
    ),
    (
        "samples = 10",
        "samples = { at_most = 10 }",
        &[":3: ", "samples: missing field `until`"],
    ),
    (
        "samples = 10",
        "samples = { until = \"decided\", at_most = 10, relative = 0.1 }",
        &[":3: ", "samples.relative = (given): must be absent"],
    ),
    (
        "samples = 10",
        "samples = { until = \"width\", at_most = 10, of = \"amplitude\" }",
        &[":3: ", "samples.relative = (absent): must be given"],
    ),
    (
        "samples = 10",
        "samples = { until = \"width\", at_most = 10, relative = 0.1 }",
        &[":3: ", "samples.of = (absent): must be given"],
    ),
    (
        "samples = 10",
        "samples = { until = \"width\", at_most = 10, of = \"amplitude\", relative = 0.0 }",
        &[":3: ", "samples.relative = 0: must be a finite number > 0"],
    ),
    (
        "samples = 10",
        "samples = { until = \"width\", at_most = 10, of = \"amplitude\", relative = 2.0 }",
        &[":3: ", "samples.relative = 2: must be from 0 to 1"],
    ),
    (
        "samples = 10",
        "samples = { until = \"width\", at_most = 10, of = \"amplitude\", relative = nan }",
        &[
            ":3: ",
            "samples.relative = NaN: must be a finite number > 0",
        ],
    ),
    (
        "samples = 10",
        "samples = { until = \"width\", at_most = 10, of = \"amplitude\", relative = 0.1, quantile = 1.0 }",
        &[":3: ", "samples.quantile = 1: must lie between 0 and 1"],
    ),
    (
        "samples = 10",
        "samples = { until = \"decided\", at_most = 10, more = 1 }",
        &[":3: ", "unknown field `more`"],
    ),
    ("seed = 7", "seed = -7", &[":2: seed: "]),
    (
        "\"two masses\"",
        "\"\"",
        &[":1: name = \"\": must not be empty"],
    ),
    ("[1.0, 2.0]", "[]", &[":4: levels = []: must not be empty"]),
    (
        "[1.0, 2.0]",
        "[\n0.0]",
        &[":5: levels[0] = 0: must be a finite number > 0"],
    ),
    (
        "[1.0, 2.0]",
        "[inf]",
        &[":4: levels[0] = inf: must be a finite"],
    ),
    ("[1.0, 2.0]", "1.0", &[":4: levels: "]),
    (
        "0.01",
        "-0.01",
        &[":10: model.modal_damping_ratio = -0.01: must be"],
    ),
    (
        "0.01",
        "1.5",
        &[":10: model.modal_damping_ratio = 1.5: must be below 1"],
    ),
    (
        "k_n = 1e6",
        "k_n = -1e6",
        &[":21: model.contact[0].k_n = -1e6: must be from 0"],
    ),
    (
        "k_n = 1e6",
        "k_n = nan",
        &[":21: model.contact[0].k_n = NaN: must be from 0"],
    ),
    (
        "mu = 0.3",
        "mu = -0.1",
        &[":22: model.contact[0].mu = -0.1: must be from 0 to 10"],
    ),
    (
        "mu = 0.3",
        "mu = 0.3\ngap = -1e-6",
        &[":23: model.contact[0].gap"],
    ),
    (
        "mu = 0.3",
        "mu = 0.3\ngap = 0\nn_0 = 3",
        &[":23: model.contact[0].gap", "n_0"],
    ),
    (
        "law = \"box\"",
        "law = \"ball\"",
        &[":25: contact.law: ", "box", "circle"],
    ),
    (
        "low = 0.1",
        "low = -0.1",
        &[":28: inputs.friction_coefficient", "negative"],
    ),
    (
        "low = 0.1",
        "low = nan",
        &[":29: inputs.friction_coefficient.low = NaN"],
    ),
    (
        "\"uniform\"",
        "\"log-uniform\"\nvalue = 3",
        &[":29: ", ".value = 3: must be absent"],
    ),
    (
        "\"uniform\"",
        "\"gauss\"",
        &[":28: inputs.friction_coefficient.distribution: ", "normal"],
    ),
    (
        "high = 0.8",
        "",
        &[":27: inputs.friction_coefficient.high = (absent): must be given"],
    ),
    (
        "harmonics = 5",
        "harmonics = 0",
        &[":33: solver.harmonics = 0"],
    ),
    (
        "harmonics = 5",
        "harmonics = [1, 3]",
        &[":33: solver.harmonics = [1, 3]", "0 and 1"],
    ),
    (
        "harmonics = 5",
        "harmonics = \"x\"",
        &[":33: solver.harmonics: expected"],
    ),
    (
        "harmonics = 5",
        "tolerance = 0.0",
        &[":33: solver.tolerance = 0: must be from 1e-14 to 0.001"],
    ),
    (
        "harmonics = 5",
        "laps = 0",
        &[":33: solver.laps = 0: must be from 1 to 10000"],
    ),
    (
        "time_points = 128",
        "alert = { threshold = -1.0 }",
        &[":34: solver.alert.threshold = -1"],
    ),
    (
        "[100, 200]",
        "[100, 200]\npoints = 1",
        &[":38: frequency.points = 1: must be from 2"],
    ),
    (
        "[100, 200]",
        "[100, 200]\nsweep = \"upward\"",
        &[":38: frequency.sweep = upward: must be absent for a continuous"],
    ),
    ("[100, 200]", "[100]", &[":37: frequency.band_hz: "]),
    (
        "band_hz = [100, 200]",
        "band_hz = [100, 200]\npeak = 0",
        &[":38: frequency.peak = 0: must be at least 1"],
    ),
    (
        "band_hz = [100, 200]",
        "",
        &[":36: frequency.band_hz = (absent): must be given"],
    ),
    (
        "samples = 10",
        "samples = \"ten\"",
        &[":3: samples: ", "expected a whole number >= 0"],
    ),
    (
        "samples = 10",
        "samples = 1000000000000",
        &[":3: samples = 1000000000000: must be from 1 to 100000000"],
    ),
    (
        "[1.0, 2.0]",
        "[1e308]",
        &[":4: levels = 1e308: must be from 1e-12 to 1e12"],
    ),
    (
        "mu = 0.3",
        "mu = 1e308",
        &[
            ":22: ",
            ".mu = 1e308: must be from 0 to 10: a friction coefficient, no percentage",
        ],
    ),
    (
        "k_n = 1e6",
        "k_n = 1e300",
        &[":21: ", ".k_n = 1e300: must be from 0 to 1e30"],
    ),
    (
        "[\"x1\", \"x2\"]",
        "[\"x1\", \" \"]",
        &[":11: model.dof_names[1] = \"\": must not be empty"],
    ),
    (
        "name = \"c1\"",
        "name = \"\"",
        &[":17: model.contact[0].name = \"\": must not be empty"],
    ),
    (
        "low = 0.1\nhigh = 0.8",
        "low = 20\nhigh = 40",
        &[
            ":28: ",
            "must not give values above 10 (a friction coefficient, no percentage)",
        ],
    ),
    (
        "\"uniform\"\nlow = 0.1",
        "\"beta\"\nalpha = 2\nbeta = 3e7\nlow = 0.1",
        &[":30: ", ".beta = 3e7: must be from 0.01 to 1e6"],
    ),
    (
        "\"uniform\"\nlow = 0.1\nhigh = 0.8",
        "\"lognormal\"\nmedian = 0.3\nlog_standard_deviation = 1e3",
        &[
            ":30: ",
            ".log_standard_deviation = 1000: must be from 1e-9 to 10",
        ],
    ),
    (
        "high = 0.8",
        "high = 0.8\ntruncation = [0.1, 0.2, 0.3]",
        &[":31: inputs.friction_coefficient.truncation: expected a list of 2 values, not of 3"],
    ),
    (
        "harmonics = 5",
        "laps = 1000000000000000",
        &[":33: solver.laps = 1000000000000000: must be from 1 to 10000"],
    ),
    (
        "harmonics = 5",
        "tolerance = 1",
        &[":33: solver.tolerance = 1: must be from 1e-14 to 0.001"],
    ),
    (
        "harmonics = 5",
        "max_iterations = 1000000000",
        &[":33: solver.max_iterations = 1000000000: must be from 1 to 10000"],
    ),
    (
        "time_points = 128",
        "alert = { compared_with = 0 }",
        &[":34: solver.alert.compared_with = 0: ", "from 1 to 200"],
    ),
    (
        "time_points = 128",
        "alert = { threshold = 5 }",
        &[":34: solver.alert.threshold = 5: must be from 1e-9 to 1"],
    ),
    (
        "[100, 200]",
        "[100, 200, 300]",
        &[":37: frequency.band_hz: expected a list of 2 values, not of 3"],
    ),
    (
        "[100, 200]",
        "[100, 1e300]",
        &[":37: frequency.band_hz = 1e300: must be from 1e-6 to 1e9"],
    ),
    (
        "[output]",
        "[operation]\nspeed_rpm = [3000, 3600, 4000]\nengine_orders = [4]\n[output]",
        &[":40: operation.speed_rpm: expected a list of 2 values, not of 3"],
    ),
    (
        "[output]",
        "[design]\nkind = \"grid\"\n[output]",
        &[":39: design.points = (absent): must be given"],
    ),
    (
        "[output]",
        "[[criteria]]\nname = \"a\"\nquantity = \"reserve-factor\"\nlimit = 1\n[output]",
        &[":41: criteria[0].quantity = ", "needs the table [stress]"],
    ),
    (
        "[output]",
        "[[criteria]]\nname = \"a\\u0001\"\nquantity = \"amplitude-um\"\nlimit = 1\n[output]",
        &[":40: criteria[0].name = \"a\\u{1}\": must be one line of printable characters"],
    ),
    (
        "[output]",
        "[[criteria]]\nname = \"a\"\nclause = \"\\uFFFE\"\nquantity = \"amplitude-um\"\nlimit = 1\n[output]",
        &[":41: criteria[0].clause = \"\\u{fffe}\": must be one line"],
    ),
    (
        "[output]",
        "[stress]\nmodal_stress_mpa_per_um = 12\nmean_stress_mpa = 180\nendurance_limit_mpa = 350e6\n\
             ultimate_strength_mpa = 900\n[output]",
        &[":42: stress.endurance_limit_mpa = 3.5e8: must be from 0 to 1e6"],
    ),
    (
        "[output]",
        "[stress]\nmodal_stress_mpa_per_um = 12\nmean_stress_mpa = 180\nendurance_limit_mpa = 350\n\
             ultimate_strength_mpa = 1e308\n[output]",
        &[":43: stress.ultimate_strength_mpa = 1e308: must be from 0 to 1e6"],
    ),
    (
        "[output]",
        "[operation]\nspeed_rpm = [3000, 3600]\nengine_orders = [4000000000]\n[output]",
        &[":41: operation.engine_orders[0] = 4000000000: must be at most 100000"],
    ),
    (
        "[output]",
        "[operation]\nspeed_rpm = [3000, 3600]\nengine_orders = [4]\ndwell_rpm = [1e300]\n[output]",
        &[":42: operation.dwell_rpm[0] = 1e300: must lie in the range speed_rpm"],
    ),
    ("seed = 7", "sed = 7", &[":2: sed: unknown key", "seed"]),
    (
        "mu = 0.3",
        "mue = 0.3",
        &[":22: model.contact[0].mue: unknown field `mue`"],
    ),
    (
        "law = \"box\"",
        "lav = \"box\"",
        &[":25: contact.lav: unknown field"],
    ),
    ("mass = \"mass.mtx\"", "", &["model: missing field `mass`"]),
    ("kind = \"matrices\"", "", &["model.kind: must be given"]),
    (
        "\"matrices\"",
        "\"disk\"",
        &[":7: model.kind = disk: must be \"two-blade-strip\""],
    ),
    (
        "\"matrices\"",
        "3",
        &[":7: model.kind: invalid type: integer `3`"],
    ),
    ("name = \"two masses\"", "", &[":1: name: must be given"]),
    (
        "name = \"two masses\"",
        "name = \"two\\nmasses\"",
        &[":1: name = \"two\\nmasses\": must be one line of printable characters"],
    ),
    (
        "[inputs.friction_coefficient]",
        "[inputs.friction]",
        &[":27: inputs.friction: unknown input"],
    ),
    (
        "seed = 7",
        "seed = 7\nseed = 8",
        &[":3: not valid TOML: duplicate key"],
    ),
    ("samples = 10", "samples = ", &[":3: not valid TOML: "]),
    ("[frequency]", "[frequency", &[":36: not valid TOML: "]),
    (
        "law = \"box\"",
        "share = \"equal\"",
        &[":25: contact.share", "[[model.contact]]"],
    ),
    (
        "responses = [\"x1\"]",
        "responses = []",
        &[":14: model.responses = []"],
    ),
    (
        "[\"x1\", \"x2\"]",
        "[\"x1\", \"x1\"]",
        &[":11: model.dof_names[1] = x1: must not be given twice"],
    ),
    (
        "k_t1 = 2e5",
        "",
        &[":16: model.contact[0].k_t1 = (absent): must be given"],
    ),
    (
        "modal_damping_ratio = 0.01",
        "",
        &[":6: model.damping = (absent): must be given"],
    ),
];
