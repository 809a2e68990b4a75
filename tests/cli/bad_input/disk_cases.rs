//! Studies of a tuned disk that the program refuses.

use super::cases::Case;

/// A study of a disk by one sector.
pub(crate) const DISK: &str = "\
name = \"disk\"
levels = [1.0]

[model]
kind = \"cyclic\"
sector = \"matrices\"
sectors = 12
mass = \"mass.mtx\"
stiffness = \"stiffness.mtx\"
modal_damping_ratio = 0.01
dof_names = [\"left.x\", \"blade.x\", \"strip.x\", \"strip.z\", \"right.x\"]
left = [\"left.x\"]
right = [\"right.x\"]
static_force = { \"strip.z\" = 5.0 }
cosine_force = { \"blade.x\" = 1.0 }
responses = [\"blade.x\"]

[[model.contact]]
name = \"next\"
t1 = { \"strip.x\" = 1.0, \"next:blade.x\" = -1.0 }
n = { \"strip.z\" = 1.0 }
k_t1 = 2e5
k_n = 1e6
mu = 0.3

[operation]
speed_rpm = [1000, 2000]
engine_orders = [3]

[frequency]
band_hz = [100, 400]
";

/// Files of [`DISK`]: the right boundary has no mass of its own.
pub(crate) const DISK_FILES: [(&str, &str); 2] = [
    (
        "mass.mtx",
        "%%MatrixMarket matrix coordinate real symmetric\n5 5 4\n1 1 1.0\n2 2 0.4\n3 3 0.001\n4 4 0.001\n",
    ),
    (
        "stiffness.mtx",
        "%%MatrixMarket matrix coordinate real symmetric\n5 5 5\n1 1 4e6\n2 1 -1e6\n2 2 1e6\n5 1 -2e6\n5 5 2e6\n",
    ),
];

/// Changes of [`DISK`] that the program and the schema refuse.
pub(crate) const DISK_REFUSED: &[Case] = &[
    (
        "engine_orders = [3]",
        "engine_orders = [0]",
        &[":28: operation.engine_orders[0] = 0: must be a whole number >= 1"],
    ),
    (
        "engine_orders = [3]",
        "engine_orders = [-1]",
        &[":28: operation.engine_orders: -1: must be from 1 to 100000"],
    ),
    (
        "engine_orders = [3]",
        "engine_orders = [5000000000]",
        &[":28: operation.engine_orders: 5000000000: must be from 1 to 100000"],
    ),
    (
        "sectors = 12",
        "sectors = 12\nsectorz = 12",
        &[
            ":8: model.sectorz: unknown field `sectorz`",
            "`blade_frequency_scatter`",
            "`sectors`",
        ],
    ),
    (
        "[operation]\nspeed_rpm = [1000, 2000]\nengine_orders = [3]\n",
        "",
        &[":1: operation = (absent): must be given: its engine_orders name the engine order"],
    ),
    (
        "sectors = 12",
        "sectors = 1",
        &[":7: model.sectors = 1: must be from 2 to 1000"],
    ),
    (
        "sectors = 12",
        "sectors = 12\nblade_frequency_scatter = -0.01\nblade = [\"blade.x\"]",
        &[
            ":8: model.blade_frequency_scatter = -0.01: must be from 0 to 0.1",
            "standard deviation",
        ],
    ),
    (
        "sectors = 12",
        "sectors = 12\nblade_frequency_scatter = 0.2\nblade = [\"blade.x\"]",
        &[":8: model.blade_frequency_scatter = 0.2: must be from 0 to 0.1"],
    ),
    (
        "kind = \"cyclic\"\nsector = \"matrices\"\nsectors = 12",
        "kind = \"matrices\"\nblade_frequency_scatter = 0.01",
        &[
            ":6: model.blade_frequency_scatter: must be absent: only a disk",
            "has blades that differ",
        ],
    ),
    ("sectors = 12\n", "", &[":4: model.sectors: must be given"]),
    (
        "sector = \"matrices\"",
        "sector = \"ring\"",
        &[":6: model.sector = ring: must be \"blade-strip\" or \"matrices\""],
    ),
    (
        "left = [\"left.x\"]",
        "left = [\"left.x\"]\nmirror = \"mirror.mtx\"",
        &[":13: model.mirror = mirror.mtx: must be absent: one sector of a disk is not folded"],
    ),
];

/// Changes of [`DISK`] that the program alone refuses.
pub(crate) const DISK_BEYOND_SCHEMA: &[Case] = &[
    (
        "sectors = 12",
        "sectors = 2\nblade_frequency_scatter = 0.01\nblade = [\"blade.x\"]",
        &[":7: model.sectors = 2: must be from 3 to 128 where blade_frequency_scatter is given"],
    ),
    (
        "sectors = 12",
        "sectors = 12\nblade_frequency_scatter = 0.01",
        &[":4: model.blade = []: must name the degrees of freedom of the blade"],
    ),
    (
        "sectors = 12",
        "sectors = 12\nblade_frequency_scatter = 0.01\nblade = [\"right.x\"]",
        &[
            ":9: model.blade[0] = right.x: must name a degree of freedom of the sector that is not on",
        ],
    ),
    (
        "sectors = 12",
        "sectors = 12\nblade_frequency_scatter = 0.01\nblade = [\"strip.z\"]",
        &[":9: model.blade = strip.z: must name degrees of freedom with a stiffness among them"],
    ),
    (
        "responses = [\"blade.x\"]",
        "responses = [\"next:blade.x\"]\nblade_frequency_scatter = 0.01\nblade = [\"blade.x\"]",
        &[":16: model.responses[0] = next:blade.x: must be on the sector itself where"],
    ),
    (
        "responses = [\"blade.x\"]",
        "responses = [{ name = \"none\", row = { \"next:left.x\" = 1.0, \"right.x\" = -1.0 } }]",
        &[":16: model.responses[0] = none: must have a weight that is not zero"],
    ),
    (
        "t1 = { \"strip.x\" = 1.0, \"next:blade.x\" = -1.0 }",
        "t1 = { \"next:left.x\" = 1.0, \"right.x\" = -1.0 }",
        &[":20: model.contact[0].t1 = {}: must have a weight that is not zero"],
    ),
    (
        "stiffness = \"stiffness.mtx\"",
        "stiffness = \"stiffness-{nd}.mtx\"",
        &[":8: model.mass = mass.mtx: must have {nd} in its name, as the other matrices have"],
    ),
    (
        "mass = \"mass.mtx\"\nstiffness = \"stiffness.mtx\"",
        "mass = \"mass-{nd}.mtx\"\nstiffness = \"stiffness-{nd}.mtx\"",
        &[":12: model.left = 1 names: must be absent: the matrices of a nodal diameter"],
    ),
    (
        "sectors = 12\nmass = \"mass.mtx\"\nstiffness = \"stiffness.mtx\"",
        "sectors = 12\nblade_frequency_scatter = 0.01\nmass = \"mass-{nd}.mtx\"\nstiffness = \"stiffness-{nd}.mtx\"",
        &[
            ":8: model.blade_frequency_scatter = 0.01: must be absent where matrices are reduced for each nodal diameter",
        ],
    ),
    (
        "right = [\"right.x\"]",
        "right = []",
        &[":13: model.right = 0 names: must be as many as in left (1)"],
    ),
    (
        "right = [\"right.x\"]",
        "right = [\"strip.z\"]",
        &[
            ":13: model.right[0] = strip.z: must meet a displacement of the same direction, but left[0] is left.x",
        ],
    ),
    (
        "right = [\"right.x\"]",
        "right = [\"left.x\"]",
        &[":13: model.right[0] = left.x: must not be on both boundaries"],
    ),
    (
        "right = [\"right.x\"]",
        "right = [\"nobody.x\"]",
        &[":13: model.right[0] = nobody.x: must name a degree of freedom of the sector"],
    ),
    (
        "cosine_force = { \"blade.x\" = 1.0 }",
        "cosine_force = { \"right.x\" = 1.0 }",
        &[":15: model.cosine_force.right.x = 1: must be 0 on the right boundary"],
    ),
    (
        "\"next:blade.x\" = -1.0",
        "\"next:nobody.x\" = -1.0",
        &[":20: model.contact[0].t1.next:nobody.x = -1: must name a degree of freedom"],
    ),
    (
        "\"next:blade.x\" = -1.0",
        "\"next:right.x\" = -1.0",
        &[
            ":20: model.contact[0].t1.next:right.x = -1: must lie in the sector or in the next one, but the right boundary of the next sector is left.x two sectors on",
        ],
    ),
    (
        "left = [\"left.x\"]\nright = [\"right.x\"]",
        "left = []\nright = []",
        &[
            ":8: model.mass = (matrix): must be positive definite",
            "nodal diameter 0 row 5",
        ],
    ),
    (
        "[frequency]",
        "[inputs.strip_thickness_mm]\ndistribution = \"uniform\"\nlow = 0.3\nhigh = 0.5\n\n[frequency]",
        &[":30: inputs.strip_thickness_mm = (given): must be absent: a model of kind \"cyclic\""],
    ),
    (
        "[frequency]",
        "[inputs.initial_traction]\ndistribution = \"uniform\"\nlow = 0.0\nhigh = 1.0\n\n[frequency]",
        &[
            ": inputs.initial_traction = (given): must be absent: every sector would begin with the same tractions",
        ],
    ),
];
