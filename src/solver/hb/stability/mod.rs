//! Stability of a periodic solution: does a small disturbance die out or grow from one period to the next?
//!
//! A disturbance d of the motion obeys the equations of motion with the contact law linearised along the solution. What it has
//! become after one period is a linear map of what it was: the monodromy matrix. Its eigenvalues are the Floquet multipliers; the
//! solution is unstable if one of them lies outside the unit circle.
//!
//! - **Structure** (`structure`): low modes of the free structure, and what the high ones do together under forces of the contacts,
//!   all with their mass. The disturbance is not cut off at the harmonics of the solution.
//! - **Contact** (`contact_steps`): the law is marched along the solution on a fine grid, and its derivative with it. A
//!   slider that sticks keeps the disturbance that it had when stick began; a contact that closes takes the one of the place
//!   and of the instant of closing; slip and separation forget.
//! - **March** (`march`): in each step the contact stiffness is its mean over the step, and the step is that of Gauss'
//!   method of fourth order, which neither adds nor takes energy. [`period_map`] makes the map of it; a disk has its own
//!   march ([`ring_map`]), and its largest multipliers are found by what becomes of a few disturbances (`leading`).
//!
//! A slider that neither slips nor opens in the whole period keeps every disturbance for ever: its residual traction is not
//! unique. That is no instability, and these disturbances are left out. So is the retention, which acts on a mean and not on a motion.
//!
//! Source: Nayfeh and Balachandran, Applied Nonlinear Dynamics, 1995, sections 3.2 and 5.3; Hairer, Nørsett and Wanner, Solving
//! Ordinary Differential Equations I, 1993, section II.7 (Gauss' method).

pub mod assessment;
mod contact_steps;
mod leading;
mod march;
mod march_step;
pub mod period_map;
pub mod ring_map;
mod sectors;
mod structure;

pub use assessment::{Instability, Stability, assess};
