//! One queue of contact requests for one device, and the threads that serve it.
//!
//! Samples are solved each on its own thread and control flow; a thread that asks for a draft waits, and another takes its
//! turn on the processor. Requests gather until half of the samples wait (or nobody is left to ask), and go down as one
//! batch: two halves alternate, so that the device works on one while the processor works on the other. Samples that are
//! done ask no more: batches hold none but active ones. A state's answer does not depend on the rest of its batch.

use super::adapter::Device;
use super::error::GpuError;
use super::kernels::{BatchResult, Buffers, Kernels};
use super::scaled::{ScaledForces, ScaledStates};
use super::self_test::self_test;
use super::settings::{Fault, GpuSettings};
use super::shader::Shape;
use super::tally::{Tally, lock};
use crate::aft::Want;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longest dispatch that is aimed at: drivers with a watchdog reset the device after about two seconds.
const LONGEST_DISPATCH: Duration = Duration::from_millis(100);
/// Batches of fewer states are not cut for their time.
const SHORTEST_BATCH: usize = 64;
/// Times that a lost device is opened again.
const REOPENINGS: usize = 1;

/// States of one sample that wait for the device.
struct Request {
    shape: Shape,
    states: ScaledStates,
    answer: SyncSender<Option<ScaledForces>>,
}

/// What samples and lanes share.
pub(super) struct Queue {
    state: Mutex<State>,
    /// Told of new requests and of samples that come and go.
    asked: Condvar,
    /// Told of free turns.
    freed: Condvar,
    holder: Mutex<Holder>,
    pub(super) tally: Tally,
    /// Batches that were tried.
    attempts: AtomicU64,
    settings: GpuSettings,
}

#[derive(Default)]
struct State {
    pending: Vec<Request>,
    /// Requests that are not answered yet, pending ones included.
    unanswered: usize,
    /// Samples that have begun and not ended.
    in_flight: usize,
    free_turns: usize,
    closed: bool,
    /// No device is left to serve anybody.
    given_up: bool,
}

/// The device, or why there is none any more.
struct Holder {
    device: Result<Arc<Device>, GpuError>,
    kernels: HashMap<Shape, Arc<Kernels>>,
    reopened: usize,
}

impl std::fmt::Debug for Queue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Queue")
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

impl Queue {
    pub(super) fn new(device: Device, settings: GpuSettings) -> Self {
        Self {
            state: Mutex::new(State {
                free_turns: settings.turns.max(1),
                ..State::default()
            }),
            asked: Condvar::new(),
            freed: Condvar::new(),
            tally: Tally::new(&device.adapter, settings.precision),
            attempts: AtomicU64::new(0),
            holder: Mutex::new(Holder {
                device: Ok(Arc::new(device)),
                kernels: HashMap::new(),
                reopened: 0,
            }),
            settings,
        }
    }

    /// Waits for the answer to `states`; `None` if the device has none to give.
    pub(super) fn ask(
        &self,
        shape: Shape,
        states: ScaledStates,
        has_turn: bool,
    ) -> Option<ScaledForces> {
        let (sender, receiver) = sync_channel(1);
        {
            let mut state = lock(&self.state);
            if state.closed || state.given_up {
                self.tally.not_asked();
                return None;
            }
            state.free_turns += usize::from(has_turn);
            state.unanswered += 1;
            state.pending.push(Request {
                shape,
                states,
                answer: sender,
            });
        }
        self.freed.notify_one();
        self.asked.notify_all();
        let answer = receiver.recv().ok().flatten();
        if has_turn {
            self.take_turn();
        }
        answer
    }

    fn take_turn(&self) {
        let mut state = lock(&self.state);
        while state.free_turns == 0 {
            state = self
                .freed
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
        state.free_turns -= 1;
    }

    /// A sample begins: it waits for its first turn.
    pub(super) fn begin(&self) {
        lock(&self.state).in_flight += 1;
        self.take_turn();
    }

    /// A sample ends.
    pub(super) fn end(&self) {
        {
            let mut state = lock(&self.state);
            state.in_flight -= 1;
            state.free_turns += 1;
        }
        self.freed.notify_one();
        self.asked.notify_all();
    }

    /// Lets the lanes end.
    pub(super) fn close(&self) {
        lock(&self.state).closed = true;
        self.asked.notify_all();
    }

    /// Ends the device as a driver reset would.
    pub(super) fn lose_device(&self) {
        if let Ok(device) = &lock(&self.holder).device {
            device.destroy();
        }
    }

    /// The next requests of one shape; `None` once the queue is closed.
    fn next_batch(&self) -> Option<Vec<Request>> {
        let mut state = lock(&self.state);
        loop {
            let n = state.pending.len();
            let everyone_waits = state.unanswered >= state.in_flight;
            if n > 0 && (2 * n >= state.in_flight || everyone_waits || state.closed) {
                let shape = state.pending[0].shape.clone();
                let (taken, left) =
                    (state.pending.drain(..)).partition(|request| request.shape == shape);
                state.pending = left;
                return Some(taken);
            }
            if state.closed {
                return None;
            }
            state = self
                .asked
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Sends everybody who waits to the processor, now and from now on.
    fn give_up(&self) {
        let mut state = lock(&self.state);
        state.given_up = true;
        // their receivers see that no answer will come
        state.pending.clear();
    }

    fn answered(&self, n: usize) {
        lock(&self.state).unanswered -= n;
        self.asked.notify_all();
    }

    /// The device and the kernels for `shape`, compiled when first asked for.
    fn kernels(&self, shape: &Shape) -> Result<(Arc<Device>, Arc<Kernels>), GpuError> {
        let mut holder = lock(&self.holder);
        let device = holder.device.clone()?;
        if let Some(kernels) = holder.kernels.get(shape) {
            return Ok((device, Arc::clone(kernels)));
        }
        let kernels = Arc::new(Kernels::new(&device, shape.clone())?);
        holder.kernels.insert(shape.clone(), Arc::clone(&kernels));
        Ok((device, kernels))
    }

    /// The device, or why there is none any more.
    pub(super) fn device(&self) -> Result<Arc<Device>, GpuError> {
        lock(&self.holder).device.clone()
    }

    /// Opens a lost device again, once; after that it stays away.
    pub(super) fn reopen(&self, lost: &Arc<Device>, why: &GpuError) {
        let mut holder = lock(&self.holder);
        if !holder
            .device
            .as_ref()
            .is_ok_and(|device| Arc::ptr_eq(device, lost))
        {
            // another lane was faster
            return;
        }
        lost.destroy();
        holder.kernels.clear();
        holder.device = match holder.reopened < REOPENINGS {
            true => open(&self.settings).map(Arc::new),
            false => Err(why.clone()),
        };
        holder.reopened += 1;
        if holder.device.is_err() {
            self.give_up();
        }
        self.tally.note(match &holder.device {
            Ok(_) => format!("{why}; it was opened again"),
            Err(error) => format!("{why}; the processor does the rest ({error})"),
        });
    }
}

/// Opens the adapter of the settings and tests it.
pub(super) fn open(settings: &GpuSettings) -> Result<Device, GpuError> {
    let device = Device::open(
        settings.adapter.as_deref(),
        settings.local_rank,
        settings.precision,
    )?;
    self_test(&device, settings)?;
    Ok(device)
}

/// Lets nobody wait for a lane that panicked.
struct Watch<'a>(&'a Queue);

impl Drop for Watch<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0
                .tally
                .note("a thread of the device failed; the processor does the rest".to_owned());
            self.0.give_up();
        }
    }
}

/// One thread with its own buffers; two of them keep the device busy.
#[derive(Default)]
pub(super) struct Lane {
    /// Buffers per shape, and the device that they are on.
    buffers: HashMap<Shape, (Arc<Device>, Buffers)>,
    /// Time (s) of one state in the last batch.
    seconds_per_state: HashMap<Shape, f64>,
}

impl Lane {
    /// Serves the queue until it is closed.
    pub(super) fn serve(&mut self, queue: &Queue) {
        let _watch = Watch(queue);
        while let Some(requests) = queue.next_batch() {
            let states: Vec<&ScaledStates> =
                requests.iter().map(|request| &request.states).collect();
            let answers = self.answers(queue, &requests[0].shape, &states);
            queue.answered(requests.len());
            for (request, answer) in requests.iter().zip(answers) {
                // a sample that does not wait any more needs no answer
                let _ = request.answer.send(answer);
            }
        }
    }

    /// Answers in batches that memory and time allow; halves those that fail.
    fn answers(
        &mut self,
        queue: &Queue,
        shape: &Shape,
        parts: &[&ScaledStates],
    ) -> Vec<Option<ScaledForces>> {
        let mut answers = Vec::with_capacity(parts.len());
        let mut rest = parts;
        let mut most = usize::MAX;
        let mut reopened = false;
        while !rest.is_empty() {
            let (device, kernels) = match queue.kernels(shape) {
                Ok(both) => both,
                Err(error) => {
                    queue.tally.fall_back(&error, rest.len());
                    answers.resize_with(parts.len(), || None);
                    break;
                }
            };
            let most_states = self.most_states(shape, &device, &kernels).min(most);
            let batch = &rest[..fitting(rest, most_states)];
            match self.evaluate(queue, (&device, &kernels), batch) {
                Ok(result) => {
                    let undecided = result.parts.iter().map(|part| part.undecided.len()).sum();
                    queue.tally.undecided(undecided);
                    answers.extend(result.parts.into_iter().map(Some));
                    rest = &rest[batch.len()..];
                }
                Err(error @ GpuError::Lost { .. }) if !reopened => {
                    reopened = true;
                    queue.reopen(&device, &error);
                }
                Err(error) if batch.len() > 1 && !matches!(error, GpuError::Lost { .. }) => {
                    let states: usize = batch.iter().map(|part| part.n_states).sum();
                    most = states / 2;
                    queue.tally.halved(&error);
                }
                Err(error) => {
                    if matches!(error, GpuError::Lost { .. }) {
                        queue.reopen(&device, &error);
                    }
                    queue.tally.fall_back(&error, batch.len());
                    answers.extend(batch.iter().map(|_| None));
                    rest = &rest[batch.len()..];
                }
            }
        }
        answers
    }

    /// States of the largest batch that limits and the time of a dispatch allow.
    fn most_states(&self, shape: &Shape, device: &Device, kernels: &Kernels) -> usize {
        let by_time = (self.seconds_per_state.get(shape)).map_or(usize::MAX, |seconds| {
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a count; too large ones saturate"
            )]
            let states = (LONGEST_DISPATCH.as_secs_f64() / seconds) as usize;
            states.max(SHORTEST_BATCH)
        });
        kernels.most_states(device).min(by_time)
    }

    fn evaluate(
        &mut self,
        queue: &Queue,
        (device, kernels): (&Arc<Device>, &Kernels),
        batch: &[&ScaledStates],
    ) -> Result<BatchResult, GpuError> {
        let shape = kernels.shape();
        let n: usize = batch.iter().map(|part| part.n_states).sum();
        let attempt = queue.attempts.fetch_add(1, Ordering::Relaxed);
        match queue.settings.fault {
            Some(Fault::LoseDeviceAfter(batches)) if attempt == batches => device.destroy(),
            Some(Fault::RefuseAbove(states)) if n > states => {
                let message = "injected".to_owned();
                return Err(GpuError::Refused { states: n, message });
            }
            _ => {}
        }
        let fits = |(on, buffers): &(Arc<Device>, Buffers)| {
            Arc::ptr_eq(on, device) && buffers.capacity() >= n
        };
        if !self.buffers.get(shape).is_some_and(fits) {
            self.buffers.remove(shape);
            let most = kernels.most_states(device).max(n);
            let buffers = kernels.buffers(device, n.next_power_of_two().min(most))?;
            self.buffers
                .insert(shape.clone(), (Arc::clone(device), buffers));
        }
        let clock = Instant::now();
        let (_, buffers) = &self.buffers[shape];
        let result = kernels.evaluate(device, buffers, batch, Want::ForcesAndTangents);
        if result.is_err() {
            // they may be half used
            self.buffers.remove(shape);
        }
        let result = result?;
        let on_device =
            (result.pass_seconds.as_ref()).map(|passes| passes.iter().map(|(_, s)| s).sum::<f64>());
        let seconds = on_device.unwrap_or_else(|| clock.elapsed().as_secs_f64());
        self.seconds_per_state
            .insert(shape.clone(), seconds / n as f64);
        queue
            .tally
            .batch(batch.len(), n, result.pass_seconds.as_deref());
        Ok(result)
    }
}

/// Number of parts from the first on that hold no more than `most` states together; at least one.
fn fitting(parts: &[&ScaledStates], most: usize) -> usize {
    let mut states = 0;
    let fits = parts.iter().take_while(|part| {
        states += part.n_states;
        states <= most
    });
    fits.count().max(1)
}
