//! Contacts of which a part slips long before the rest, as a loose edge does.

/// Slip limits of such a contact, over their mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::identify) struct WeakPart {
    /// Share of the area.
    pub(super) area: f64,
    /// Least slip limit...
    pub(super) least: f64,
    /// ...and greatest one of this part; between them the limits are spread evenly.
    pub(super) greatest: f64,
}

/// Shares of the area that are tried...
const AREAS: [f64; 7] = [0.03, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5];
/// ...with one slip limit for all of the part, over the mean...
const LIMITS: [f64; 8] = [0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6];
/// ...and those of a part whose limits are spread from 0 to that of the rest: a pressure that falls to 0 along an edge.
const EDGES: [f64; 5] = [0.05, 0.1, 0.2, 0.3, 0.4];
/// Probability of all of them together before the loop is seen, beside that of all others: a fault of the contact. What a loop shows
/// clearly outweighs it.
pub(super) const WEAK: f64 = 0.05;

impl WeakPart {
    /// Slip limit of the rest.
    pub(super) fn rest(&self) -> f64 {
        (1.0 - 0.5 * self.area * (self.least + self.greatest)) / (1.0 - self.area)
    }

    /// Share of the swing at an elastic swing of `x` times that of full slip.
    pub(super) fn share(&self, x: f64) -> f64 {
        let (least, greatest) = (self.least, self.greatest);
        let mean = if x <= least {
            x
        } else if x < greatest {
            x - 0.5 * (x - least).powi(2) / (greatest - least)
        } else {
            0.5 * (least + greatest)
        };
        self.area * mean + (1.0 - self.area) * x.min(self.rest())
    }

    /// Share of the area whose slip limit is above `x` times the mean.
    pub(super) fn above(&self, x: f64) -> f64 {
        let (least, greatest) = (self.least, self.greatest);
        let mean = if x < least {
            1.0
        } else if x < greatest {
            (greatest - x) / (greatest - least)
        } else {
            0.0
        };
        let rest = f64::from(u8::from(x < self.rest()));
        self.area * mean + (1.0 - self.area) * rest
    }
}

/// Contacts with a weak part that are tried.
pub(super) fn weak_parts() -> Vec<WeakPart> {
    let alike = AREAS.into_iter().flat_map(|area| {
        LIMITS.map(|limit| WeakPart {
            area,
            least: limit,
            greatest: limit,
        })
    });
    // the limit g of the rest is that of the end of the edge: (1 - a) g + a g/2 = 1
    let edges = EDGES.map(|area| WeakPart {
        area,
        least: 0.0,
        greatest: 1.0 / (1.0 - 0.5 * area),
    });
    alike.chain(edges).collect()
}
