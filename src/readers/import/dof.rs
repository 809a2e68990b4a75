//! Degrees of freedom as finite-element programs name them: a node and a component.

use std::fmt;

/// One degree of freedom.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Dof {
    /// Number of the node; negative for internal nodes, and of the row where the file has no names.
    pub node: i64,
    /// Component at the node.
    pub component: Component,
}

/// Component of a degree of freedom at its node.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Component {
    /// 1, 2, 3 displacements along x, y, z; 4, 5, 6 rotations about them; others as the program counts.
    Number(u32),
    /// A name that has no number, such as TEMP.
    Label(String),
    /// The file has no names: only the number of the row is known.
    TextRow,
}

/// What a degree of freedom measures; its unit follows from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A length.
    Displacement,
    /// An angle.
    Rotation,
    /// A modal coordinate or another one without a unit that is known.
    Generalized,
}

/// Names of ANSYS for the components 1 to 6.
const ANSYS: [&str; 6] = ["UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ"];

impl Dof {
    /// Component `component` of `node`.
    #[must_use]
    pub fn new(node: i64, component: u32) -> Self {
        let component = Component::Number(component);
        Self { node, component }
    }

    /// Row `row` (from 0) of a matrix without names.
    #[must_use]
    pub fn row(row: usize) -> Self {
        Self {
            node: row as i64 + 1,
            component: Component::TextRow,
        }
    }

    /// A component by its number or by its name in ANSYS (`UX` to `ROTZ`).
    #[must_use]
    pub fn labelled(node: i64, label: &str) -> Self {
        let upper = label.to_ascii_uppercase();
        let component = match (ANSYS.iter().position(|l| *l == upper), label.parse()) {
            (Some(at), _) => Component::Number(at as u32 + 1),
            (_, Ok(number)) => Component::Number(number),
            _ => Component::Label(upper),
        };
        Self { node, component }
    }

    /// What it measures. Rows without names count as displacements.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self.component {
            Component::Number(1..=3) if self.node > 0 => Kind::Displacement,
            Component::Number(4..=6) if self.node > 0 => Kind::Rotation,
            Component::TextRow => Kind::Displacement,
            _ => Kind::Generalized,
        }
    }
}

impl fmt::Display for Dof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let node = self.node;
        match &self.component {
            Component::Number(component) => write!(f, "{node}.{component}"),
            Component::Label(label) => write!(f, "{node}.{label}"),
            Component::TextRow => write!(f, "{node}"),
        }
    }
}
