//! HTTP/1.1, as little as the protocol needs: one request per connection, bounded in size and time.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// Request line and headers at most.
const LONGEST_HEAD: u64 = 16 << 10;
/// Body at most: some ten thousand numbers, where a model has thirty inputs.
const LONGEST_BODY: u64 = 1 << 20;
/// From a connection to the last byte of its request.
const REQUEST_TIME: Duration = Duration::from_secs(10);
/// For the client to take the reply.
const REPLY_TIME: Duration = Duration::from_secs(10);
/// For a client that still sends what nobody reads to see the reply.
const PARTING_TIME: Duration = Duration::from_secs(1);

/// What a client asks for.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Request {
    pub method: String,
    /// Path without what follows a question mark.
    pub path: String,
    pub body: Vec<u8>,
}

/// Codes of a reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Code {
    Ok,
    BadRequest,
    NotFound,
    MethodNotAllowed,
    RequestTimeout,
    LengthRequired,
    ContentTooLarge,
    HeadTooLarge,
    ServerError,
    NotImplemented,
}

impl Code {
    /// Number and words.
    fn line(self) -> &'static str {
        match self {
            Self::Ok => "200 OK",
            Self::BadRequest => "400 Bad Request",
            Self::NotFound => "404 Not Found",
            Self::MethodNotAllowed => "405 Method Not Allowed",
            Self::RequestTimeout => "408 Request Timeout",
            Self::LengthRequired => "411 Length Required",
            Self::ContentTooLarge => "413 Content Too Large",
            Self::HeadTooLarge => "431 Request Header Fields Too Large",
            Self::ServerError => "500 Internal Server Error",
            Self::NotImplemented => "501 Not Implemented",
        }
    }
}

/// Why a request is not read.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Unread {
    /// The client said nothing.
    Silent,
    /// It broke a rule.
    Refused(Code, String),
}

fn refused<T>(code: Code, message: impl Into<String>) -> Result<T, Unread> {
    Err(Unread::Refused(code, message.into()))
}

/// A connection that gives bytes until a moment.
struct Until<'s> {
    stream: &'s TcpStream,
    end: Instant,
}

impl Read for Until<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let left = self.end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(std::io::ErrorKind::TimedOut.into());
        }
        self.stream.set_read_timeout(Some(left))?;
        let mut stream = self.stream;
        stream.read(buffer)
    }
}

/// Reads the request of a connection.
pub(super) fn read_request(stream: &TcpStream) -> Result<Request, Unread> {
    let end = Instant::now() + REQUEST_TIME;
    let mut reader = BufReader::new(Until { stream, end });
    let head = read_head(&mut reader)?;
    let mut lines = head.lines();
    let mut words = lines.next().unwrap_or_default().split(' ');
    let (Some(method), Some(target), Some(version), None) =
        (words.next(), words.next(), words.next(), words.next())
    else {
        return refused(Code::BadRequest, "the first line is no request of HTTP/1.1");
    };
    if !version.starts_with("HTTP/1.") {
        return refused(Code::BadRequest, format!("{version}: must be HTTP/1.1"));
    }
    let headers = Headers::of(lines)?;
    let length = match headers.length {
        Some(length) => length,
        None if method != "POST" => 0,
        None => return refused(Code::LengthRequired, "must state its Content-Length"),
    };
    if headers.waits && length > 0 {
        let mut stream = stream;
        // a client that is gone shows at the next read
        let _ = stream.write_all(b"HTTP/1.1 100 Continue\r\n\r\n");
    }
    let mut body = Vec::new();
    let read = reader.take(length).read_to_end(&mut body);
    read.map_err(|error| broken(&error))?;
    if (body.len() as u64) < length {
        let n = body.len();
        let message = format!("the body ends after {n} bytes of {length}");
        return refused(Code::BadRequest, message);
    }
    Ok(Request {
        method: method.to_owned(),
        path: target.split('?').next().unwrap_or_default().to_owned(),
        body,
    })
}

/// The text up to the first empty line.
fn read_head(reader: &mut impl BufRead) -> Result<String, Unread> {
    let mut head = Vec::new();
    let mut bounded = reader.take(LONGEST_HEAD);
    loop {
        let before = head.len();
        let read = bounded.read_until(b'\n', &mut head);
        read.map_err(|error| match head.is_empty() {
            true => Unread::Silent,
            false => broken(&error),
        })?;
        match &head[before..] {
            b"\r\n" | b"\n" => break,
            line if line.ends_with(b"\n") => {}
            _ if head.is_empty() => return Err(Unread::Silent),
            _ if bounded.limit() == 0 => {
                let message = format!("the head is longer than {} KiB", LONGEST_HEAD >> 10);
                return refused(Code::HeadTooLarge, message);
            }
            _ => return refused(Code::BadRequest, "the request ends in its head"),
        }
    }
    match String::from_utf8(head) {
        Ok(text) => Ok(text),
        Err(_) => refused(Code::BadRequest, "the head is no UTF-8"),
    }
}

/// What the headers say of the body.
#[derive(Default)]
struct Headers {
    length: Option<u64>,
    /// Whether the client waits for a word before it sends the body.
    waits: bool,
}

impl Headers {
    fn of<'t>(lines: impl Iterator<Item = &'t str>) -> Result<Self, Unread> {
        let mut headers = Self::default();
        for line in lines.filter(|line| !line.is_empty()) {
            let Some((name, value)) = line.split_once(':') else {
                return refused(Code::BadRequest, format!("{line:?}: no header"));
            };
            let value = value.trim();
            match name.to_ascii_lowercase().as_str() {
                "content-length" => {
                    let length = length_of(value)?;
                    if headers.length.is_some_and(|other| other != length) {
                        return refused(Code::BadRequest, "Content-Length: two lengths");
                    }
                    headers.length = Some(length);
                }
                "transfer-encoding" => {
                    let message = "Transfer-Encoding: send the body whole, with its Content-Length";
                    return refused(Code::NotImplemented, message);
                }
                "expect" => headers.waits = value.eq_ignore_ascii_case("100-continue"),
                _ => {}
            }
        }
        Ok(headers)
    }
}

fn length_of(value: &str) -> Result<u64, Unread> {
    let digits = !value.is_empty() && value.bytes().all(|b| b.is_ascii_digit());
    if !digits {
        return refused(Code::BadRequest, "Content-Length: must be a number");
    }
    // a number that no integer holds is too large as well
    let length = value.parse().unwrap_or(u64::MAX);
    if length > LONGEST_BODY {
        let message = format!("the body is longer than {} KiB", LONGEST_BODY >> 10);
        return refused(Code::ContentTooLarge, message);
    }
    Ok(length)
}

fn broken(error: &std::io::Error) -> Unread {
    use std::io::ErrorKind::{TimedOut, WouldBlock};
    let (code, message) = match error.kind() {
        TimedOut | WouldBlock => {
            let seconds = REQUEST_TIME.as_secs();
            let message = format!("the request did not come whole within {seconds} s");
            (Code::RequestTimeout, message)
        }
        _ => (Code::BadRequest, format!("the request broke off: {error}")),
    };
    Unread::Refused(code, message)
}

/// Sends a reply in JSON and ends the connection. A client that is gone has no use for an error.
pub(super) fn send(stream: &TcpStream, code: Code, body: &str) {
    let _ = try_to_send(stream, code, body);
}

fn try_to_send(mut stream: &TcpStream, code: Code, body: &str) -> std::io::Result<()> {
    stream.set_write_timeout(Some(REPLY_TIME))?;
    let (line, length) = (code.line(), body.len());
    let reply = format!(
        "HTTP/1.1 {line}\r\nContent-Type: application/json\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{body}"
    );
    stream.write_all(reply.as_bytes())?;
    stream.shutdown(Shutdown::Write)?;
    // what is not read when a connection closes makes the system take the reply back
    let end = Instant::now() + PARTING_TIME;
    let rest = Until { stream, end }.take(LONGEST_BODY);
    std::io::copy(&mut { rest }, &mut std::io::sink())?;
    Ok(())
}
