//! Unit vectors of a contact pair: normal and two tangents.

/// Largest |cosine| between a normal and a tangent that are meant to be perpendicular: half a degree.
const PERPENDICULAR: f64 = 0.01;
/// Components of a unit vector that count as 0.
const NEGLIGIBLE: f64 = 1e-12;
/// Length of a vector at least, to have a direction.
const SHORTEST: f64 = 1e-30;

/// A right-handed set: normal, first and second tangent.
pub(super) type Directions = [[f64; 3]; 3];

/// Normal and tangents; the second tangent is normal × first. Without a tangent the first one is the axis that is most
/// perpendicular to the normal, made perpendicular to it.
///
/// # Errors
/// The rule that the vectors break.
pub(super) fn directions(
    normal: [f64; 3],
    tangent: Option<[f64; 3]>,
) -> Result<Directions, String> {
    let normal = unit(normal).ok_or("nx, ny, nz: must not be zero")?;
    let given = match tangent {
        Some(tangent) => {
            let tangent = unit(tangent).ok_or("tx, ty, tz: must not be zero")?;
            let cosine = dot(normal, tangent);
            if cosine.abs() > PERPENDICULAR {
                return Err(format!(
                    "tx, ty, tz: must be perpendicular to the normal; their cosine is {cosine:.3}"
                ));
            }
            tangent
        }
        None => {
            let least = (0..3).min_by(|&i, &j| normal[i].abs().total_cmp(&normal[j].abs()));
            let mut axis = [0.0; 3];
            axis[least.unwrap_or_default()] = 1.0;
            axis
        }
    };
    let along = dot(normal, given);
    let in_plane = [0, 1, 2].map(|i| given[i] - along * normal[i]);
    let first = unit(in_plane).ok_or("tx, ty, tz: must not be along the normal")?;
    let second = cross(normal, first);
    Ok([normal, first, second].map(|v| v.map(|c| if c.abs() < NEGLIGIBLE { 0.0 } else { c })))
}

/// The vector with length 1; nothing if it has no direction.
pub(super) fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let largest = v.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
    if largest < SHORTEST || !largest.is_finite() {
        return None;
    }
    let scaled = v.map(|c| c / largest);
    let length = dot(scaled, scaled).sqrt();
    Some(scaled.map(|c| c / length))
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail with the second tangent of the other sign.
    #[test]
    fn tangents_complete_a_right_handed_set() {
        let [n, t1, t2] = directions([0.0, 0.0, 2.0], Some([0.0, 3.0, 0.0])).unwrap();
        assert_eq!([n, t1], [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]);
        assert_eq!(t2, [-1.0, 0.0, 0.0]);
        let [n, t1, t2] = directions([1.0, 2.0, 2.0], None).unwrap();
        for (a, b) in [(n, t1), (n, t2), (t1, t2)] {
            assert!(dot(a, b).abs() < 1e-14, "perpendicular");
        }
        assert!((dot(cross(n, t1), t2) - 1.0).abs() < 1e-14, "right-handed");
        assert!(directions([0.0; 3], None).is_err());
        assert!(directions([0.0, 0.0, 1.0], Some([0.0, 1.0, 0.1])).is_err());
    }
}
