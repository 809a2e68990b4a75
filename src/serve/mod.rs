//! The model of a study for programs in other languages: a server of the UM-Bridge protocol 1.0 (HTTP and JSON).
//!
//! One model, `forward`: a vector of inputs in; resonance frequencies (Hz) and amplitudes (m) out, one number per level. The protocol
//! has no passwords and no encryption, so a server listens where only its own machine reaches it unless it is told otherwise.
//! Source: Seelinger et al. 2023, "UM-Bridge: Uncertainty quantification and modeling bridge", JOSS 8(83), 4748.
//!
//! ```
//! use microslip::ensemble::stop::Stop;
//! use microslip::serve::Server;
//! use microslip::study::{Evaluator, Study};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let server = Server::bind(([127, 0, 0, 1], 0).into())?;
//! let study = Study::read("studies/own-matrices/study.toml".as_ref())?;
//! let model = Evaluator::solved(study.into_prepared()?, 0, &Stop::default(), |_progress| {})?;
//! println!("http://{}", server.address());
//! let ending = server.ending();
//! std::thread::spawn(move || ending.end());
//! server.run(&model); // until it is told to end
//! # Ok(())
//! # }
//! ```

mod http;
mod protocol;
mod server;

pub use protocol::MODEL;
pub use server::{Ending, Server};
