//! The mesh of `studies/calculix-blade`, written by its rules: a blade and a strip of bricks, numbered along x, then y, then z.

use std::fmt::Write as _;
use std::path::Path;

/// A box of bricks: its first node, its first corner and its edges between neighbours (mm), its elements along x, y, z.
struct Bricks {
    first_node: usize,
    corner: [f64; 3],
    edge: [f64; 3],
    elements: [usize; 3],
}

/// Edge along z of every brick (mm).
const HEIGHT: f64 = 100.0 / 12.0;
const BLADE: Bricks = Bricks {
    first_node: 1,
    corner: [0.0, 0.0, 0.0],
    edge: [6.0, 10.0, HEIGHT],
    elements: [2, 2, 12],
};
const STRIP: Bricks = Bricks {
    first_node: 1001,
    corner: [12.0, 0.0, 4.0 * HEIGHT],
    edge: [2.0, 10.0, HEIGHT],
    elements: [1, 2, 2],
};
/// Springs that hold the outer face of the strip: direction, N/mm.
const HOLDS: [(usize, &str); 3] = [(1, "4.0"), (2, "8000.0"), (3, "8000.0")];

impl Bricks {
    fn node(&self, [i, j, k]: [usize; 3]) -> usize {
        let [nx, ny] = [self.elements[0] + 1, self.elements[1] + 1];
        self.first_node + i + nx * (j + ny * k)
    }

    /// Nodes by their number, with their places in the grid.
    fn nodes(&self) -> Vec<(usize, [usize; 3])> {
        let [nx, ny, nz] = self.elements.map(|n| n + 1);
        let places = (0..nx * ny * nz).map(|at| [at % nx, at / nx % ny, at / (nx * ny)]);
        places.map(|place| (self.node(place), place)).collect()
    }

    fn position(&self, place: [usize; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| self.corner[axis] + self.edge[axis] * place[axis] as f64)
    }

    /// Eight nodes of every brick: the lower face around, then the upper one.
    fn bricks(&self) -> Vec<[usize; 8]> {
        let [nx, ny, nz] = self.elements;
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
        let around =
            |[i, j, k]: [usize; 3], up| corners.map(|[a, b]| self.node([i + a, j + b, k + up]));
        let places = (0..nx * ny * nz).map(|at| [at % nx, at / nx % ny, at / (nx * ny)]);
        let brick = |place| {
            let mut nodes = [0; 8];
            nodes[..4].copy_from_slice(&around(place, 0));
            nodes[4..].copy_from_slice(&around(place, 1));
            nodes
        };
        places.map(brick).collect()
    }

    /// Nodes of the face at the highest (or the lowest) x.
    fn side(&self, highest: bool) -> Vec<usize> {
        let at = if highest { self.elements[0] } else { 0 };
        let nodes = self.nodes().into_iter();
        nodes
            .filter(|(_, place)| place[0] == at)
            .map(|(node, _)| node)
            .collect()
    }
}

/// The deck for CalculiX.
fn deck() -> Result<String, std::fmt::Error> {
    let mut deck = String::from(
        "** A cantilever blade (12 x 20 x 100 mm) and a strip (2 x 20 x 16.7 mm) beside it, in one model, without contact.\n\
         ** Units: mm, t, s. Nodes 1 to 117 are the blade, 1001 to 1018 the strip.\n*NODE, NSET=ALL\n",
    );
    for body in [&BLADE, &STRIP] {
        for (node, place) in body.nodes() {
            let [x, y, z] = body.position(place);
            writeln!(deck, "{node}, {x:.4}, {y:.4}, {z:.4}")?;
        }
    }
    deck.push_str("*ELEMENT, TYPE=C3D8, ELSET=SOLID\n");
    let bricks = [&BLADE, &STRIP].into_iter().flat_map(Bricks::bricks);
    for (at, nodes) in bricks.enumerate() {
        let nodes = nodes.map(|node| node.to_string()).join(", ");
        writeln!(deck, "{}, {nodes}", at + 1)?;
    }
    deck.push_str("** The strip is held by springs on its outer face: soft along x, where it is pressed, stiff along y and z.\n");
    let outer = STRIP.side(true);
    for (at, (direction, stiffness)) in HOLDS.into_iter().enumerate() {
        writeln!(deck, "*ELEMENT, TYPE=SPRING1, ELSET=HOLD{direction}")?;
        for (k, node) in outer.iter().enumerate() {
            writeln!(deck, "{}, {node}", 2001 + at * outer.len() + k)?;
        }
        writeln!(
            deck,
            "*SPRING, ELSET=HOLD{direction}\n{direction}\n{stiffness}"
        )?;
    }
    deck.push_str("*BOUNDARY\n");
    for (node, _) in BLADE.nodes().iter().filter(|(_, place)| place[2] == 0) {
        writeln!(deck, "{node}, 1, 3")?;
    }
    deck.push_str(
        "*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n*DENSITY\n7.8E-9\n*SOLID SECTION, ELSET=SOLID, MATERIAL=STEEL\n\
         *STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n12\n*END STEP\n",
    );
    Ok(deck)
}

/// Coordinates of all nodes, to the four decimals of the deck.
fn coordinates() -> String {
    let mut table = String::from("node,x,y,z\n");
    for body in [&BLADE, &STRIP] {
        for (node, place) in body.nodes() {
            let rounded = body.position(place).map(|x| (1e4 * x).round() / 1e4);
            table.push_str(&format!(
                "{node},{}\n",
                rounded.map(|x| x.to_string()).join(",")
            ));
        }
    }
    table
}

fn nodes_table(nodes: &[usize]) -> String {
    let rows = nodes.iter().map(|node| format!("{node}\n"));
    std::iter::once("node\n".to_owned()).chain(rows).collect()
}

/// A force on the blade's tip, and 81 N that press the strip.
fn forces() -> String {
    let tip = BLADE.node([2, 0, 12]);
    let pressed = STRIP.side(true).into_iter();
    let rows = pressed.map(|node| format!("{node}.1,,-9\n"));
    let head = format!("dof,cosine,static\n{tip}.2,1,\n");
    std::iter::once(head).chain(rows).collect()
}

/// Writes the mesh and its tables into `folder`.
pub(crate) fn write(folder: &Path) {
    for (name, text) in files() {
        std::fs::write(folder.join(name), text).unwrap();
    }
}

fn files() -> [(&'static str, String); 5] {
    [
        ("blade.inp", deck().unwrap()),
        ("nodes.csv", coordinates()),
        ("blade_side.csv", nodes_table(&BLADE.side(true))),
        ("strip_side.csv", nodes_table(&STRIP.side(false))),
        ("forces.csv", forces()),
    ]
}

/// The files of the study are what the rules give, so that nobody edits them by hand.
///
/// Seen to fail with another height of the bricks.
#[test]
fn the_files_of_the_study_follow_from_the_rules() {
    for (name, text) in files() {
        let stored =
            std::fs::read_to_string(Path::new("studies/calculix-blade").join(name)).unwrap();
        assert!(stored == text, "{name} is not what its rules give:\n{text}");
    }
}
