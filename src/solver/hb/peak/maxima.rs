//! The maxima of one problem at each level, and which of them is the peak.
//!
//! The peak is the highest maximum of the amplitude in the band. Maxima grow from the modes of the stuck and of the free
//! structure ([`crate::hb::structure::resonance::candidates`]). The reach of a mode is its largest amplitude in these two
//! linear structures; friction damps the modes between them. The modes are searched in the order of their reach. A mode is
//! searched only if its maximum could be higher than those found before it.

use super::branch_maximum::Extent;
use super::level_peak::{LevelPeak, ModeSearch};
use crate::hb::equations::effort::WorkCount;
use crate::hb::route::PeakRoute;
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use crate::hb::structure::resonance::Candidate;
use std::cmp::Reverse;

/// A mode is searched if its reach is at least this part of the highest maximum found so far.
const SEARCHED: f64 = 0.5;
/// A maximum that was found in the search of mode m, but may belong to another mode, is stored under the number m + `ON_BRANCH`.
pub const ON_BRANCH: usize = 1 << 16;
/// Another maximum on the branch through one of mode m is stored under the number m + `BESIDE`. No mode of the structure has such numbers.
const BESIDE: usize = 2 * ON_BRANCH;
/// Two solutions are the same maximum up to these relative distances of frequency and amplitude.
const SAME: [f64; 2] = [1e-6, 1e-5];
/// The same for solutions on different harmonics, whose truncation errors differ.
const SAME_ON_OTHER_HARMONICS: [f64; 2] = [1e-4, 2e-2];

/// Which maximum of the band is the peak.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PeakChoice {
    /// The highest one; a mode is searched only if its reach competes with the maxima found.
    #[default]
    Highest,
    /// The highest one; every mode is searched.
    All,
    /// The one that grows from a mode of the stuck structure that the first harmonic sees, 0 for the lowest.
    Mode(usize),
}

/// The maxima at one level.
#[derive(Debug)]
pub struct Maxima {
    /// Excitation level.
    pub level: f64,
    /// The maxima found, each with the mode that was searched. One maximum may be listed for several modes.
    found: Vec<(usize, Solution)>,
    /// Searches that failed: largest amplitude that the mode can have (m), and status of the search.
    failed: Vec<(f64, Status)>,
    /// Searches that have not found the maximum of their mode, though nothing says that it lies outside the band.
    pub unfinished: usize,
    /// Work of all searches.
    pub count: WorkCount,
}

/// Searches the maxima at `levels`. `search` gives the maxima of one mode at some of the levels, given by their numbers; it is
/// passed the maxima of the other modes found so far.
///
/// # Errors
/// Those of `search`.
pub fn search_maxima<E>(
    candidates: &[Candidate],
    choice: PeakChoice,
    levels: &[f64],
    mut search: impl FnMut(&Candidate, &[usize], &[Maxima]) -> Result<Vec<ModeSearch>, E>,
) -> Result<Vec<Maxima>, E> {
    let mut maxima: Vec<Maxima> = levels.iter().map(|&level| Maxima::none(level)).collect();
    for candidate in candidates {
        let wanted: Vec<usize> = (maxima.iter().enumerate())
            .filter(|(_, at)| at.wants(candidate, choice))
            .map(|(i, _)| i)
            .collect();
        if wanted.is_empty() {
            continue;
        }
        let found = search(candidate, &wanted, &maxima)?;
        for (&i, found) in wanted.iter().zip(found) {
            maxima[i].add(candidate, found, choice);
        }
        for i in wanted {
            // a prediction of another mode led to the maximum of this one: that mode is searched again
            for mode in maxima[i].misled(candidate.mode) {
                for other in candidates.iter().filter(|of| of.mode == mode) {
                    for again in search(other, &[i], &maxima)? {
                        maxima[i].correct(other, candidate.mode, again);
                    }
                }
            }
        }
    }
    Ok(maxima)
}

/// Looks along the branch through the highest maximum of each level for another that may be higher, and adds it to `maxima`. `along` gives
/// it and its work. The branch of a maximum that was predicted from other samples is followed as far as `predicted` says, if at all (shape: as
/// `maxima`), since theirs were followed already. Where one mode is wanted nothing is looked for.
pub fn add_other_on_branches(
    maxima: &mut [Maxima],
    choice: PeakChoice,
    predicted: &[Option<Extent>],
    along: impl Fn(&Solution, Extent) -> (Option<Solution>, WorkCount),
) {
    if !matches!(choice, PeakChoice::Mode(_)) {
        let levels = maxima.iter_mut().zip(predicted);
        levels.for_each(|(at, predicted)| at.add_other_on_branch(*predicted, &along));
    }
}

impl Maxima {
    /// Nothing found yet.
    fn none(level: f64) -> Self {
        Self {
            level,
            found: Vec::new(),
            failed: Vec::new(),
            unfinished: 0,
            count: WorkCount::default(),
        }
    }

    /// Whether the maximum of a mode is to be searched.
    fn wants(&self, candidate: &Candidate, choice: PeakChoice) -> bool {
        match choice {
            PeakChoice::All => true,
            PeakChoice::Mode(mode) => candidate.mode == mode,
            PeakChoice::Highest => match self.highest() {
                Some(highest) => candidate.reach * self.level >= SEARCHED * highest.amplitude(0),
                None => self
                    .failed
                    .iter()
                    .all(|(_, status)| *status == Status::NoPeakInBand),
            },
        }
    }

    /// Adds the result of the search of a mode. Where one mode is wanted, nothing but its own maximum counts.
    fn add(&mut self, candidate: &Candidate, search: ModeSearch, choice: PeakChoice) {
        let (mut peak, mut others, is_own) = (search.peak, search.others, search.is_own);
        self.count += peak.count;
        if matches!(choice, PeakChoice::Mode(_)) {
            others.clear();
            if !is_own {
                peak = LevelPeak::failed(peak.level, Status::StepTooSmall, peak.count);
            }
        }
        let is_missing = peak.solution.is_none() && peak.status != Status::NoPeakInBand;
        self.unfinished += usize::from(is_missing || !is_own);
        let of_another = |found: &Solution| self.is_of_another(candidate.mode, found);
        if peak.solution.is_none() && others.iter().all(of_another) {
            self.failed
                .push((candidate.reach * self.level, peak.status));
        }
        let found = peak.solution.into_iter().chain(others);
        if is_own {
            self.found
                .extend(found.map(|solution| (candidate.mode, solution)));
            return;
        }
        // no start for this mode of other samples, but perhaps for the maximum itself
        let label = ON_BRANCH + candidate.mode;
        let new: Vec<Solution> = found.filter(|s| !self.is_of_another(label, s)).collect();
        (self.found).extend(new.into_iter().map(|solution| (label, solution)));
    }

    /// The maximum to which `mode` was tracked, not predicted from other samples.
    fn tracked(&self, mode: usize) -> Option<&Solution> {
        let is_tracked = |s: &Solution| s.route.is_some_and(|route| !route.is_from_others());
        let own = self.found.iter().filter(|(of, _)| *of == mode);
        own.map(|(_, solution)| solution).find(|s| is_tracked(s))
    }

    /// Modes whose prediction from other samples has led to the maximum to which `mode` was tracked: where two maxima are equally
    /// high, the amplitude does not tell that a prediction has gone to the other one.
    fn misled(&self, mode: usize) -> Vec<usize> {
        let Some(tracked) = self.tracked(mode) else {
            return Vec::new();
        };
        let predicted = |s: &Solution| s.route.is_some_and(PeakRoute::is_from_others);
        let taken = self.found.iter().filter(|(of, solution)| {
            *of != mode && predicted(solution) && is_same_maximum(solution, tracked)
        });
        let mut modes: Vec<usize> = taken.map(|(of, _)| *of).collect();
        modes.dedup();
        modes
    }

    /// Takes the second search of a mode whose first one had led to the maximum of the mode `owner`. If it has led elsewhere, that
    /// maximum is no longer counted for the mode.
    fn correct(&mut self, candidate: &Candidate, owner: usize, again: ModeSearch) {
        self.count += again.peak.count;
        let (Some(own), Some(tracked)) = (again.peak.solution, self.tracked(owner).cloned()) else {
            return;
        };
        if !is_same_maximum(&own, &tracked) {
            self.found
                .retain(|(of, s)| *of != candidate.mode || !is_same_maximum(s, &tracked));
            self.found.push((candidate.mode, own));
        }
    }

    /// Adds another maximum on the branch through the highest one, as a maximum of its own: what the search of the mode has led to stays a
    /// start for others.
    fn add_other_on_branch(
        &mut self,
        predicted: Option<Extent>,
        along: impl Fn(&Solution, Extent) -> (Option<Solution>, WorkCount),
    ) {
        let Some(highest) = self.highest() else {
            return;
        };
        let extent = |s: &Solution| match s.route.is_some_and(PeakRoute::is_from_others) {
            true => predicted,
            false => Some(Extent::Band),
        };
        let found = self
            .found
            .iter()
            .filter(|(_, s)| is_same_maximum(s, highest));
        let followed = found.filter_map(|(mode, s)| Some((extent(s)?, mode, s)));
        let farthest = followed.min_by_key(|(extent, ..)| Reverse(*extent));
        let Some((extent, mode, solution)) = farthest else {
            return;
        };
        let (mode, (other, work)) = (BESIDE + mode % ON_BRANCH, along(solution, extent));
        self.count += work;
        let is_new = |other: &Solution| !self.found.iter().any(|(_, s)| is_same_maximum(s, other));
        let new = other.filter(is_new).map(|other| (mode, other));
        self.found.extend(new);
    }

    /// Adds the maximum that the prediction of one on a branch (`mode` from [`ON_BRANCH`] on) has led to; says whether there is one.
    pub fn add_predicted_on_branch(&mut self, mode: usize, search: ModeSearch) -> bool {
        self.count += search.peak.count;
        let found = search.peak.solution;
        let is_there = found.is_some();
        self.found.extend(found.map(|solution| (mode, solution)));
        is_there
    }

    /// The highest maximum found; the first of equal ones, so that it depends only on the problem and its starts.
    #[must_use]
    pub fn highest(&self) -> Option<&Solution> {
        self.distinct().into_iter().next()
    }

    /// The different maxima found, highest first.
    #[must_use]
    pub fn distinct(&self) -> Vec<&Solution> {
        let mut distinct: Vec<&Solution> = Vec::new();
        for (_, solution) in &self.found {
            let mut known = distinct.iter();
            if !known.any(|known| is_same_maximum(known, solution)) {
                distinct.push(solution);
            }
        }
        distinct.sort_by(|a, b| b.amplitude(0).total_cmp(&a.amplitude(0)));
        distinct
    }

    /// The highest maximum that was found in the search of each mode, as starts for others.
    #[must_use]
    pub fn by_mode(&self) -> Vec<(usize, &Solution)> {
        let mut best: Vec<(usize, &Solution)> = Vec::new();
        for (mode, solution) in &self.found {
            match best.iter_mut().find(|(other, _)| other == mode) {
                Some((_, known)) if solution.amplitude(0) > known.amplitude(0) => *known = solution,
                Some(_) => {}
                None => best.push((*mode, solution)),
            }
        }
        best
    }

    /// Whether `solution` is the maximum of another mode than `mode`.
    #[must_use]
    pub fn is_of_another(&self, mode: usize, solution: &Solution) -> bool {
        let mut others = self.by_mode().into_iter();
        others.any(|(other, known)| other != mode && is_same_maximum(known, solution))
    }

    /// Status of the search for the peak. If the search of a mode failed, and that mode could be higher than the maxima found,
    /// the highest maximum is not known.
    #[must_use]
    pub fn status(&self) -> Status {
        let highest = self.highest();
        let known = highest.map_or(0.0, |highest| highest.amplitude(0));
        let mut failed = (self.failed.iter()).filter(|(_, status)| *status != Status::NoPeakInBand);
        match highest {
            Some(highest) => failed
                .find(|(reach, _)| *reach > known)
                .map_or(highest.status, |(_, status)| *status),
            None => failed
                .next()
                .map_or(Status::NoPeakInBand, |(_, status)| *status),
        }
    }

    /// The peak: the highest maximum, unless it is not known.
    #[must_use]
    pub fn peak(&self) -> Option<&Solution> {
        self.highest().filter(|_| self.status().has_solution())
    }
}

impl From<Maxima> for LevelPeak {
    /// The highest maximum.
    fn from(maxima: Maxima) -> Self {
        Self {
            level: maxima.level,
            status: maxima.status(),
            count: maxima.count,
            solution: maxima.peak().cloned(),
        }
    }
}

/// Whether two solutions of one problem are the same maximum, perhaps on other harmonics.
fn is_same_maximum(a: &Solution, b: &Solution) -> bool {
    let apart = |a: f64, b: f64| (a / b - 1.0).abs();
    let [frequency, amplitude] = match a.harmonics == b.harmonics {
        true => SAME,
        false => SAME_ON_OTHER_HARMONICS,
    };
    apart(a.omega, b.omega) <= frequency && apart(a.amplitude(0), b.amplitude(0)) <= amplitude
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harmonics::HarmonicSet;
    use crate::hb::equations::effort::WorkCount;
    use crate::hb::solution::{ContactFractions, CycleWork};
    use crate::hb::structure::resonance::Band;

    /// A solution of one response, told apart by frequency and amplitude.
    fn maximum(omega: f64, amplitude: f64, highest: usize) -> Solution {
        let harmonics = HarmonicSet::up_to(highest);
        let mut responses = vec![0.0; harmonics.n_coefficients()];
        responses[1] = amplitude;
        Solution {
            status: Status::Converged,
            omega,
            level: 1.0,
            harmonics,
            relative: Vec::new(),
            force: Vec::new(),
            responses,
            residual: 0.0,
            contact: ContactFractions::default(),
            flight_fraction: 0.0,
            work: CycleWork::default(),
            kinetic_energy: 0.0,
            truncation_error: None,
            stability: None,
            sharpness: None,
            route: None,
        }
    }

    fn mode(mode: usize, reach: f64) -> Candidate {
        let band = Band {
            low: 90.0,
            high: 110.0,
        };
        Candidate {
            mode,
            omega: 100.0,
            reach,
            path: band,
        }
    }

    fn search(solution: Solution, others: Vec<Solution>) -> ModeSearch {
        let peak = LevelPeak::found(solution, WorkCount::default());
        ModeSearch {
            others,
            ..ModeSearch::from(peak)
        }
    }

    fn failed(status: Status) -> ModeSearch {
        ModeSearch::from(LevelPeak {
            level: 1.0,
            status,
            solution: None,
            count: WorkCount::default(),
        })
    }

    /// Seen to fail with the lowest of the maxima, and with maxima on other harmonics counted apart.
    #[test]
    fn the_highest_maximum_is_reported_and_the_others_are_counted() {
        let end = |others: Vec<Solution>| {
            let mut at = Maxima::none(1.0);
            at.add(
                &mode(0, 3.0),
                search(maximum(100.0, 2.0, 3), others),
                PeakChoice::All,
            );
            (at.peak().unwrap().omega, at.distinct().len() - 1)
        };
        assert_eq!(end(vec![]), (100.0, 0));
        assert_eq!(end(vec![maximum(100.0, 2.0, 3)]), (100.0, 0));
        let other = maximum(100.001, 2.01, 5);
        assert_eq!(end(vec![other]), (100.0, 0), "harmonics");
        assert_eq!(end(vec![maximum(100.001, 1.9, 3)]), (100.0, 1), "lower");
        let [lower, higher] = [maximum(99.0, 1.0, 3), maximum(101.0, 3.0, 3)];
        assert_eq!(end(vec![lower, higher.clone(), higher]), (101.0, 2));
    }

    /// A prediction for mode 4 ends at the maximum of mode 7, as high as its own. Mode 7 is tracked there, so that mode 4 is searched
    /// again and its own maximum counts for it, unless the second search ends there, too, or in nothing. Seen to fail without the
    /// second search: one maximum.
    #[test]
    fn a_mode_whose_prediction_took_the_maximum_of_another_is_searched_again() {
        let modes = [mode(4, 3.0), mode(7, 2.0)];
        let by = |omega: f64, route| Solution {
            route: Some(route),
            ..maximum(omega, 2.0, 3)
        };
        let run = |second: &dyn Fn() -> ModeSearch| {
            let mut asked = Vec::new();
            let found = search_maxima(&modes, PeakChoice::Highest, &[1.0], |mode, _, _| {
                asked.push(mode.mode);
                Ok::<_, ()>(vec![match asked.len() {
                    1 => search(by(103.0, PeakRoute::Predicted), Vec::new()),
                    2 => search(by(103.0, PeakRoute::Tracked), Vec::new()),
                    _ => second(),
                }])
            });
            let found = &found.unwrap()[0];
            assert_eq!(asked, [4, 7, 4]);
            let by_mode = found.by_mode().into_iter().map(|(m, s)| (m, s.omega));
            (found.distinct().len(), by_mode.collect::<Vec<_>>())
        };
        let own = run(&|| search(by(99.0, PeakRoute::Tracked), Vec::new()));
        assert_eq!(own, (2, vec![(7, 103.0), (4, 99.0)]));
        let same = (1, vec![(4, 103.0), (7, 103.0)]);
        let again = run(&|| search(by(103.0, PeakRoute::Tracked), Vec::new()));
        assert_eq!(again, same);
        assert_eq!(run(&|| failed(Status::StepTooSmall)), same);
    }

    /// Modes are searched where they may be higher than what is known, and a failed search hides the peak where its mode
    /// may be higher.
    #[test]
    fn modes_compete_by_their_reach() {
        let modes = [mode(4, 3.0), mode(7, 2.0), mode(1, 0.9)];
        let run = |choice, first: fn() -> ModeSearch| {
            let mut asked = Vec::new();
            let found = search_maxima(&modes, choice, &[1.0], |mode, _, _| {
                asked.push(mode.mode);
                Ok::<_, ()>(vec![match mode.mode {
                    4 => first(),
                    7 => search(maximum(103.0, 2.1, 3), Vec::new()),
                    _ => search(maximum(105.0, 0.1, 3), Vec::new()),
                }])
            });
            let found = &found.unwrap()[0];
            (asked, found.status(), found.peak().map(|peak| peak.omega))
        };
        let lower = || search(maximum(100.0, 2.0, 3), Vec::new());
        let converged = Status::Converged;
        let highest = run(PeakChoice::Highest, lower);
        assert_eq!(highest, (vec![4, 7], converged, Some(103.0)));
        assert_eq!(run(PeakChoice::All, lower).0, [4, 7, 1]);
        let one = run(PeakChoice::Mode(1), lower);
        assert_eq!(one, (vec![1], converged, Some(105.0)));
        let lost = || failed(Status::StepTooSmall);
        assert_eq!(run(PeakChoice::All, lost).1, Status::StepTooSmall);
        let outside = run(PeakChoice::Highest, || failed(Status::NoPeakInBand));
        assert_eq!(outside, (vec![4, 7], converged, Some(103.0)));
    }

    /// The search of a mode fails. If all that it has found is the maximum of another mode, its own may be higher and the peak is not known;
    /// a maximum of its own, on another branch than expected, is one. Seen to fail where any other maximum counts for the mode.
    #[test]
    fn a_failed_search_that_found_the_maximum_of_another_mode_has_failed() {
        let ends = |other: f64| {
            let mut at = Maxima::none(1.0);
            at.add(
                &mode(7, 2.0),
                search(maximum(103.0, 1.5, 3), Vec::new()),
                PeakChoice::All,
            );
            let others = vec![maximum(other, 1.5, 3)];
            let lost = failed(Status::StepTooSmall);
            at.add(
                &mode(4, 3.0),
                ModeSearch { others, ..lost },
                PeakChoice::All,
            );
            at.status()
        };
        assert_eq!(ends(103.0), Status::StepTooSmall);
        assert_eq!(ends(99.0), Status::Converged);
    }
}
