//! Matrices of `*SUBSTRUCTURE MATRIX OUTPUT, OUTPUT FILE=USER DEFINED` (Abaqus) and `*SUBSTRUCTURE GENERATE` (CalculiX): a
//! user element with its nodes in comments, lists of components by position, and lower triangles packed by rows.

use std::path::Path;

use super::super::dof::Dof;
use super::super::lines::{Lines, number, size, whole, words};
use super::super::matrix::{Content, Entries, ImportedMatrix, Naming, Rows, Storage};
use super::abaqus_matrix::{dof_of, one_load};
use crate::file::{FileError, significant_digits};
use crate::model::matrix_market::LARGEST;

/// What the lines that follow a keyword are.
enum SubstructurePart {
    /// Not of interest.
    Other,
    /// Numbers of the nodes, in comments.
    Nodes,
    /// Components by position.
    Components,
    /// A packed triangle.
    Matrix(Triangle),
    /// Loads: node, dof, value.
    Loads,
}

/// A lower triangle, packed by rows.
#[derive(Default)]
struct Triangle {
    name: String,
    entries: Entries,
    place: (usize, usize),
}

/// What is known so far of the element.
#[derive(Default)]
struct Element {
    /// Number of positions that the keyword states.
    positions: usize,
    nodes: Vec<i64>,
    /// From which position on which components are active.
    components: Vec<(usize, Vec<u32>)>,
    dofs: Vec<Dof>,
    matrices: Vec<ImportedMatrix>,
    loads: Vec<(Dof, f64, u64)>,
    load_digits: u32,
}

/// Reads the matrices of one user element.
pub(in crate::import) fn read(path: &Path, text: &str) -> Result<Vec<ImportedMatrix>, FileError> {
    let mut element = Element::default();
    let mut lines = Lines::new(path, text);
    let mut part = SubstructurePart::Other;
    while let Some(line) = lines.next() {
        let upper = line.to_ascii_uppercase();
        let next = element.keyword(&upper);
        let next = next.map_err(|rule| lines.fault(rule))?;
        if let Some(next) = next {
            element.close(path, std::mem::replace(&mut part, next))?;
            continue;
        }
        let taken = element.data(&mut part, line, lines.number);
        taken.map_err(|rule| lines.fault(rule))?;
    }
    element.close(path, part)?;
    let content = |rule: &str| FileError::content(path, None, rule);
    if element.matrices.is_empty() {
        return Err(content("has no *MATRIX, TYPE=STIFFNESS or TYPE=MASS"));
    }
    element.close_loads(path)?;
    Ok(element.matrices)
}

impl Element {
    /// The part that a line begins, if it does.
    fn keyword(&mut self, upper: &str) -> Result<Option<SubstructurePart>, String> {
        if let Some(comment) = upper.strip_prefix("**") {
            let comment = comment.trim();
            return Ok(match comment {
                "ELEMENT NODES" => {
                    self.nodes.clear();
                    Some(SubstructurePart::Nodes)
                }
                _ if comment.starts_with("CLOAD") => Some(self.load(comment)?),
                _ => None,
            });
        }
        if !upper.starts_with('*') {
            return Ok(None);
        }
        let keywords: Vec<&str> = words(&upper[1..]).collect();
        let value = |key: &str| {
            let found = keywords.iter().position(|word| word.starts_with(key));
            found.map(|at| match keywords[at].strip_prefix(key) {
                Some("") => keywords.get(at + 1).copied().unwrap_or_default(),
                Some(value) => value,
                None => "",
            })
        };
        Ok(Some(match keywords[..] {
            ["USER", "ELEMENT", ..] => {
                if keywords.contains(&"UNSYMM") {
                    return Err("is unsymmetric: a structure has symmetric matrices".to_owned());
                }
                if self.positions > 0 {
                    return Err("is a second user element: split the file".to_owned());
                }
                self.positions = size("NODES", value("NODES=").unwrap_or_default())?;
                SubstructurePart::Components
            }
            ["MATRIX", ..] => {
                self.expand()?;
                let at = upper.find("TYPE=").map_or(upper.len(), |at| at + 5);
                let name = upper[at..].split(',').next().unwrap_or_default().trim();
                SubstructurePart::Matrix(Triangle {
                    name: name.to_owned(),
                    ..Triangle::default()
                })
            }
            ["CLOAD", ..] => self.load(upper)?,
            // a keyword of another kind ends what came before
            _ => SubstructurePart::Other,
        }))
    }

    /// Begins the load.
    fn load(&self, keyword: &str) -> Result<SubstructurePart, String> {
        one_load(keyword, self.loads.is_empty()).map(|()| SubstructurePart::Loads)
    }

    /// Takes a line that belongs to a part.
    fn data(&mut self, part: &mut SubstructurePart, line: &str, at: u64) -> Result<(), String> {
        let comment = line.starts_with("**");
        match part {
            SubstructurePart::Nodes if comment => {
                for word in words(line.trim_start_matches('*')) {
                    let node = dof_of(word, "0")?.node;
                    self.nodes.push(node);
                }
                match self.nodes.len() > LARGEST {
                    true => Err(format!("has more than {LARGEST} nodes")),
                    false => Ok(()),
                }
            }
            SubstructurePart::Loads => {
                let words: Vec<&str> = words(line.trim_start_matches('*')).collect();
                if let [node, dof, value] = words[..] {
                    self.load_digits = self.load_digits.max(significant_digits(value));
                    self.loads.push((dof_of(node, dof)?, number(value)?, at));
                }
                Ok(())
            }
            // Abaqus repeats the nodes between the keyword and the components
            SubstructurePart::Components | SubstructurePart::Nodes
                if !comment && self.positions > 0 =>
            {
                self.components_at(line)
            }
            SubstructurePart::Matrix(triangle) if !comment => {
                triangle.add(line, self.dofs.len(), at)
            }
            _ => Ok(()),
        }
    }

    /// `components` of the first position, or `position, components` from a later one on.
    fn components_at(&mut self, line: &str) -> Result<(), String> {
        let mut found = words(line);
        let mut from = 1;
        if let Some((last, _)) = self.components.last() {
            let Some(word) = found.next() else {
                return Ok(());
            };
            let (least, most) = (*last as i64 + 1, self.positions as i64);
            from = whole("node position", word, least, most)? as usize;
        }
        let components: Result<Vec<u32>, String> = found
            .map(|word| whole("degree of freedom", word, 1, 9_999).map(|c| c as u32))
            .collect();
        let components = components?;
        if !components.is_empty() {
            self.components.push((from, components));
        }
        Ok(())
    }

    /// Names of all degrees of freedom, once all positions are known.
    fn expand(&mut self) -> Result<(), String> {
        if !self.dofs.is_empty() {
            return Ok(());
        }
        if self.positions == 0 {
            return Err("has no *USER ELEMENT before it".to_owned());
        }
        if self.nodes.len() != self.positions {
            return Err(format!(
                "needs the {} nodes that *USER ELEMENT states, under ** ELEMENT NODES; {} are there",
                self.positions,
                self.nodes.len()
            ));
        }
        let mut naming = Naming::default();
        for (position, &node) in (1..).zip(&self.nodes) {
            let active = (self.components.iter()).rfind(|(from, _)| *from <= position);
            let (_, components) = active.ok_or("needs the degrees of freedom of its nodes")?;
            for &component in components {
                naming.add(Dof::new(node, component))?;
            }
        }
        self.dofs = naming.names();
        Ok(())
    }

    /// Keeps a matrix that is whole.
    fn close(&mut self, path: &Path, part: SubstructurePart) -> Result<(), FileError> {
        let SubstructurePart::Matrix(triangle) = part else {
            return Ok(());
        };
        let n = self.dofs.len();
        let (row, column) = triangle.place;
        if (row, column) != (n, 0) {
            let rule = format!(
                "matrix {}: ends in row {}; {n} rows of a packed lower triangle are required",
                triangle.name,
                row + 1
            );
            return Err(FileError::content(path, None, rule));
        }
        let digits = triangle.entries.digits();
        let matrix = triangle.entries.symmetric(path, n, Storage::Triangle)?;
        self.matrices.push(ImportedMatrix {
            name: triangle.name,
            path: path.to_owned(),
            rows: Rows::Named(self.dofs.clone()),
            content: Content::Symmetric(matrix),
            digits,
        });
        Ok(())
    }

    /// Loads on degrees of freedom of the element.
    fn close_loads(&mut self, path: &Path) -> Result<(), FileError> {
        if self.loads.is_empty() {
            return Ok(());
        }
        let mut column = vec![0.0; self.dofs.len()];
        for (dof, value, line) in &self.loads {
            let Some(at) = self.dofs.iter().position(|known| known == dof) else {
                let rule = format!("load on {dof}: must be a degree of freedom of the element");
                return Err(FileError::content(path, Some(*line), rule));
            };
            column[at] += value;
        }
        self.matrices.push(ImportedMatrix {
            name: "CLOAD".to_owned(),
            path: path.to_owned(),
            rows: Rows::Named(self.dofs.clone()),
            content: Content::Column(column),
            digits: self.load_digits,
        });
        Ok(())
    }
}

impl Triangle {
    /// Takes the numbers of a line.
    fn add(&mut self, line: &str, n: usize, at: u64) -> Result<(), String> {
        for word in words(line) {
            let (row, column) = self.place;
            if row == n {
                return Err(format!("more than the {n} rows of the element"));
            }
            self.entries.add(row, column, number(word)?, at);
            self.entries.note_digits(significant_digits(word));
            self.place = match column < row {
                true => (row, column + 1),
                false => (row + 1, 0),
            };
        }
        Ok(())
    }
}
