//! Sparse matrices as files hold them: where each row, or column, begins in a list of entries.

/// The row of each of `entries` entries, from where each of `n` rows begins. `what` is the name of the list.
///
/// # Errors
/// The rule if it does not ascend.
pub fn expanded(
    what: &str,
    pointers: &[usize],
    n: usize,
    entries: usize,
) -> Result<Vec<usize>, String> {
    let ordered = pointers.len() == n + 1
        && pointers.first() == Some(&0)
        && pointers.last() == Some(&entries)
        && pointers.windows(2).all(|two| two[0] <= two[1]);
    if !ordered {
        return Err(format!(
            "{what}: must ascend from 0 to {entries} in {} numbers",
            n + 1
        ));
    }
    let rows = pointers.windows(2).enumerate();
    let rows = rows.flat_map(|(row, two)| std::iter::repeat_n(row, two[1] - two[0]));
    Ok(rows.collect())
}
