//! Connections: accepted by many threads at once, each answered and closed.

use super::http::{Code, Unread, read_request, send};
use super::protocol::{defect, reply, unreadable};
use crate::Error;
use crate::ensemble::stop::Stop;
use crate::study::Evaluator;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, TcpStream};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

/// Connections that are served at once; further ones wait. Each has a thread that mostly waits, too: points are evaluated by the
/// threads of the process, as many at once as there are of these.
const CONNECTIONS: usize = 32;
/// Pause where the system gives no connection: too many files are open.
const PAUSE: Duration = Duration::from_millis(100);

/// A server that listens.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    stop: Stop,
}

impl Server {
    /// Listens at `address`; port 0 takes one that is free. Clients wait until [`Server::run`].
    ///
    /// # Errors
    /// [`Error::Address`] if it is taken or not one of this machine.
    pub fn bind(address: SocketAddr) -> Result<Self, Error> {
        let refused = |source: std::io::Error| Error::Address { address, source };
        let listener = TcpListener::bind(address).map_err(refused)?;
        let address = listener.local_addr().map_err(refused)?;
        Ok(Self {
            listener,
            address,
            stop: Stop::default(),
        })
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What ends it.
    #[must_use]
    pub fn ending(&self) -> Ending {
        Ending {
            address: self.address,
            stop: self.stop.clone(),
        }
    }

    /// Answers what clients ask of `model`, until it is told to end and has answered what it was asked before.
    pub fn run(&self, model: &Evaluator<'_>) {
        std::thread::scope(|scope| {
            for _ in 0..CONNECTIONS {
                scope.spawn(|| self.serve(model));
            }
        });
    }

    /// One connection after the other.
    fn serve(&self, model: &Evaluator<'_>) {
        while !self.stop.asked() {
            match self.listener.accept() {
                Ok((stream, _)) if !self.stop.asked() => answer(&stream, model),
                Ok(_) => {}
                Err(_) => std::thread::sleep(PAUSE),
            }
        }
    }
}

fn answer(stream: &TcpStream, model: &Evaluator<'_>) {
    let (code, body) = match read_request(stream) {
        Ok(request) => {
            // a defect of the program costs this request, not the server
            let replied = catch_unwind(AssertUnwindSafe(|| reply(model, &request)));
            let (code, body) = replied.unwrap_or_else(|_| (Code::ServerError, defect()));
            let head = request.method == "HEAD";
            (code, if head { String::new() } else { body })
        }
        Err(Unread::Silent) => return,
        Err(Unread::Refused(code, message)) => (code, unreadable(&message)),
    };
    send(stream, code, &body);
}

/// Ends a server, from any thread.
#[derive(Debug, Clone)]
pub struct Ending {
    address: SocketAddr,
    stop: Stop,
}

impl Ending {
    /// The wish to end; what is solved before the server runs may look at it.
    #[must_use]
    pub fn stop(&self) -> &Stop {
        &self.stop
    }

    /// Lets the server end.
    pub fn end(&self) {
        self.stop.ask();
        let mut address = self.address;
        match address.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => address.set_ip(Ipv4Addr::LOCALHOST.into()),
            IpAddr::V6(ip) if ip.is_unspecified() => address.set_ip(Ipv6Addr::LOCALHOST.into()),
            _ => {}
        }
        // each thread that waits for a connection gets one; a server that is gone needs none
        for _ in 0..CONNECTIONS {
            if TcpStream::connect(address).is_err() {
                break;
            }
        }
    }
}
