//! The device of a run and batches of lanes on it, whatever becomes of it.

use super::kernels::LaneKernels;
use super::program::TILE;
use super::search::LaneSearch;
use super::system::LaneSystem;
use crate::gpu::{Device, Gpu, GpuError, GpuSettings};
use crate::hb::equations::balance::Balance;
use crate::hb::equations::inverse::InverseJacobian;
use crate::hb::peak::predicted::PeakPrediction;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Smallest batch that is halved where the device refuses it.
const SMALLEST: usize = 64;
/// Most iterations of a batch. Lanes that need more are lost: of 6144 lanes of the default study 237 went on after ten iterations, and 209
/// had not arrived after twenty.
const ITERATIONS: usize = 10;
/// Share of the largest batch by the device's limits that is used: its memory holds other things, too.
const SHARE: usize = 2;

/// A device with the kernels for lanes that were compiled for it.
#[derive(Debug)]
pub struct LaneDevice {
    /// The device.
    pub gpu: Gpu,
    /// By the orders of their harmonics; compiled when first asked for.
    compiled: Mutex<BTreeMap<Vec<usize>, Compiled>>,
}

/// Kernels and the device that they are on.
type Compiled = (Arc<Device>, Arc<LaneKernels>);

impl LaneDevice {
    /// Opens and tests the adapter.
    ///
    /// # Errors
    /// [`GpuError`] if there is none, it lacks something, or it fails the self-test.
    pub fn open(settings: GpuSettings) -> Result<Self, GpuError> {
        Ok(Self {
            gpu: Gpu::open(settings)?,
            compiled: Mutex::default(),
        })
    }

    /// Predictions improved by the device; none for a lane that is lost, and for all where the device fails.
    pub fn improved(
        &self,
        system: &LaneSystem,
        balance: &Balance<'_>,
        lanes: Vec<LaneSearch<'_>>,
    ) -> Vec<Option<PeakPrediction>> {
        let gpu = &self.gpu;
        let mut found = vec![None; lanes.len()];
        let mut rest = by_inverse(lanes);
        let mut most = usize::MAX;
        while !rest.is_empty() {
            let evaluated = gpu.device().and_then(|device| {
                let improved = self.kernels(&device, system, balance).and_then(|kernels| {
                    most = most.min(kernels.most_lanes(&device) / SHARE);
                    let n = fitting(&rest, most, kernels.most_inverses(&device));
                    improved(&kernels, &device, &mut rest[..n])
                });
                improved.map_err(|error| gpu.failed(&device, error))
            });
            match evaluated {
                Ok(improved) => {
                    let lost = improved.iter().filter(|lane| lane.is_none()).count();
                    gpu.lanes(improved.len(), lost);
                    for (lane, start) in rest.drain(..improved.len()).zip(improved) {
                        found[lane.number] = start;
                    }
                }
                Err(GpuError::Refused { .. }) if most > SMALLEST => {
                    most = most.min(rest.len()) / 2;
                }
                // opened again
                Err(GpuError::Lost { .. }) if gpu.device().is_ok() => {}
                Err(_) => {
                    gpu.lanes(rest.len(), rest.len());
                    rest.clear();
                }
            }
        }
        found
    }

    fn kernels(
        &self,
        device: &Arc<Device>,
        system: &LaneSystem,
        balance: &Balance<'_>,
    ) -> Result<Arc<LaneKernels>, GpuError> {
        let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let orders = balance.harmonics.orders().to_vec();
        if let Some((on, kernels)) = compiled.get(&orders)
            && Arc::ptr_eq(on, device)
            && kernels.are_of(system, balance.plan())
        {
            return Ok(Arc::clone(kernels));
        }
        let fault = self.gpu.fault();
        let kernels = LaneKernels::new(device, system.clone(), balance.plan(), fault)?;
        let kernels = Arc::new(kernels);
        compiled.insert(orders, (Arc::clone(device), Arc::clone(&kernels)));
        Ok(kernels)
    }
}

/// A lane, its place in the list that was asked for, and the number of its inverse.
struct Numbered<'a> {
    number: usize,
    inverse: usize,
    search: LaneSearch<'a>,
}

/// The lanes, those with the same inverse side by side.
fn by_inverse(lanes: Vec<LaneSearch<'_>>) -> Vec<Numbered<'_>> {
    let mut inverses: Vec<&InverseJacobian> = Vec::new();
    let numbered = lanes.into_iter().enumerate().map(|(number, search)| {
        let known = (inverses.iter()).position(|x| std::ptr::eq(*x, search.inverse));
        let inverse = known.unwrap_or_else(|| {
            inverses.push(search.inverse);
            inverses.len() - 1
        });
        Numbered {
            number,
            inverse,
            search,
        }
    });
    let mut numbered: Vec<Numbered<'_>> = numbered.collect();
    numbered.sort_by_key(|lane| lane.inverse);
    numbered
}

/// Number of lanes from the first on that take no more than `most` columns, whole tiles for each of at most `inverses` inverses;
/// at least one.
fn fitting(lanes: &[Numbered<'_>], most: usize, inverses: usize) -> usize {
    let mut n = 0;
    let (mut columns, mut groups) = (0, 0);
    for group in lanes.chunk_by(|a, b| a.inverse == b.inverse) {
        let left = most.saturating_sub(columns) / TILE * TILE;
        groups += 1;
        if groups > inverses || left == 0 {
            break;
        }
        let taken = group.len().min(left);
        (n, columns) = (n + taken, columns + taken.next_multiple_of(TILE));
        if taken < group.len() {
            break;
        }
    }
    n.max(1)
}

/// What a lane does.
#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Going(f64),
    Found,
    Lost,
}

/// Predictions improved by `device`; none for a lane that is lost.
///
/// # Errors
/// What the device says; then no lane is improved.
fn improved(
    kernels: &LaneKernels,
    device: &Device,
    lanes: &mut [Numbered<'_>],
) -> Result<Vec<Option<PeakPrediction>>, GpuError> {
    let mut inverses: Vec<&InverseJacobian> = Vec::new();
    let mut batch = Vec::with_capacity(lanes.len());
    for group in lanes.chunk_by(|a, b| a.inverse == b.inverse) {
        let number = inverses.len();
        inverses.push(group[0].search.inverse);
        batch.extend(group.iter().map(|lane| (lane.search.lane.clone(), number)));
    }
    lanes.iter_mut().for_each(|lane| lane.search.begin());
    let mut batch = kernels.begin(device, &batch, &inverses)?;
    let mut states = vec![State::Going(0.0); lanes.len()];
    for _ in 0..ITERATIONS {
        let steps: Vec<Option<f64>> = (states.iter())
            .map(|state| match state {
                State::Going(step) => Some(*step),
                State::Found | State::Lost => None,
            })
            .collect();
        if steps.iter().all(Option::is_none) {
            break;
        }
        let told = batch.step(&steps)?;
        for ((state, lane), told) in states.iter_mut().zip(lanes.iter_mut()).zip(&told) {
            if matches!(state, State::Going(_)) {
                *state = match lane.search.next_step(told) {
                    Ok(Some(step)) => State::Going(step),
                    Ok(None) => State::Found,
                    Err(_) => State::Lost,
                };
            }
        }
    }
    let points = batch.points()?;
    let found =
        (lanes.iter().zip(states).zip(points)).map(|((lane, state), (r, omega))| match state {
            State::Found => lane.search.improved(r, omega),
            State::Going(_) | State::Lost => None,
        });
    Ok(found.collect())
}
