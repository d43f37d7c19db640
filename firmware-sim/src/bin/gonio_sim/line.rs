//! Where the bytes come from: a pseudo terminal, or one TCP client at a time.

use std::fs::File;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::os::unix::fs::OpenOptionsExt as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use serialport::{SerialPort as _, TTYPort};

/// Longest wait where nothing is due.
const FOR_EVER: Duration = Duration::from_hours(24);
/// How long a terminal may leave its bytes unread before they are lost.
const PATIENCE: Duration = Duration::from_millis(200);
/// A terminal that says it is writable takes this many bytes at least.
const PIECE: usize = 128;

/// What came.
#[derive(Debug)]
pub(crate) enum Event {
    /// Nothing in time.
    Nothing,
    Bytes(Vec<u8>),
    /// The client has gone.
    Gone,
}

/// A line to one client at a time.
pub(crate) enum Line {
    Terminal(Terminal),
    Network(Network),
}

impl Line {
    /// Waits for something to come; without a limit for as long as it takes.
    pub(crate) fn wait(&mut self, limit: Option<Duration>) -> io::Result<Event> {
        let limit = limit.unwrap_or(FOR_EVER);
        match self {
            Self::Terminal(terminal) => terminal.wait(limit),
            Self::Network(network) => network.wait(limit),
        }
    }

    /// Sends; what nobody takes is lost, as on a serial line.
    pub(crate) fn send(&mut self, bytes: &[u8]) {
        match self {
            Self::Terminal(terminal) => terminal.send(bytes),
            Self::Network(network) => network.send(bytes),
        }
    }

    /// Breaks the connection, where there is one that can be broken.
    pub(crate) fn hang_up(&mut self) {
        if let Self::Network(Network { client: Some(client), .. }) = self {
            let _ = client.shutdown(Shutdown::Both);
        }
    }
}

/// The end of the instrument, and the client's end: kept open, so that clients may come and go.
pub(crate) struct Terminal {
    port: TTYPort,
    _other: File,
}

/// A terminal that is opened must not become the one that Ctrl-C of this program comes from.
const NO_CONTROLLING_TERMINAL: i32 = if cfg!(target_os = "linux") { 0o400 } else { 0x2_0000 };

impl Terminal {
    /// A new pseudo terminal, raw, and its name.
    pub(crate) fn open() -> io::Result<(Self, String)> {
        let (port, mut other) = TTYPort::pair()?;
        other.set_exclusive(false)?;
        let name = other.name().ok_or(ErrorKind::NotFound)?;
        // opened once more, without the lock by which `other` would keep clients out
        let mut options = File::options();
        options.read(true).write(true).custom_flags(NO_CONTROLLING_TERMINAL);
        let kept_open = options.open(&name)?;
        drop(other);
        Ok((Self { port, _other: kept_open }, name))
    }

    fn wait(&mut self, limit: Duration) -> io::Result<Event> {
        self.port.set_timeout(limit)?;
        let mut bytes = vec![0; 4096];
        match self.port.read(&mut bytes) {
            Ok(count) => {
                bytes.truncate(count);
                Ok(Event::Bytes(bytes))
            }
            Err(e) if matches!(e.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {
                Ok(Event::Nothing)
            }
            Err(e) => Err(e),
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        let mut pieces = bytes.chunks(PIECE);
        let ready = self.port.set_timeout(PATIENCE).is_ok();
        while ready
            && let Some(piece) = pieces.next()
            && self.port.write_all(piece).is_ok()
        {}
    }
}

/// A client, or nobody.
pub(crate) struct Network {
    events: Receiver<Message>,
    client: Option<TcpStream>,
    busy: Arc<AtomicBool>,
}

/// From the threads that listen.
enum Message {
    Client(TcpStream),
    Bytes(Vec<u8>),
    Gone,
}

impl Network {
    /// Listens on an address; returns the one it got.
    pub(crate) fn open(address: &str) -> io::Result<(Self, String)> {
        let listener = TcpListener::bind(address)?;
        let name = listener.local_addr()?.to_string();
        let (sender, events) = sync_channel(64);
        let busy = Arc::new(AtomicBool::new(false));
        let shared = Arc::clone(&busy);
        std::thread::spawn(move || accept(&listener, &sender, &shared));
        Ok((Self { events, client: None, busy }, name))
    }

    fn wait(&mut self, limit: Duration) -> io::Result<Event> {
        match self.events.recv_timeout(limit) {
            Ok(Message::Client(stream)) => {
                self.client = Some(stream);
                Ok(Event::Nothing)
            }
            Ok(Message::Bytes(bytes)) => Ok(Event::Bytes(bytes)),
            Ok(Message::Gone) => {
                self.client = None;
                self.busy.store(false, Ordering::Release);
                Ok(Event::Gone)
            }
            Err(RecvTimeoutError::Timeout) => Ok(Event::Nothing),
            Err(RecvTimeoutError::Disconnected) => Err(ErrorKind::BrokenPipe.into()),
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        // a client that has gone is told of by the thread that reads
        if let Some(client) = &mut self.client {
            let _ = client.write_all(bytes);
        }
    }
}

/// Takes one client at a time and turns the others away.
fn accept(listener: &TcpListener, sender: &SyncSender<Message>, busy: &AtomicBool) {
    for stream in listener.incoming() {
        // such as too many open files: a pause, and the next may succeed
        let Ok(mut stream) = stream else {
            std::thread::sleep(Duration::from_millis(10));
            continue;
        };
        if busy.swap(true, Ordering::AcqRel) {
            let _ = stream.write_all(b"in use by another client\n");
            continue;
        }
        let _ = stream.set_nodelay(true);
        // a client that does not read must not hold up the instrument for ever
        let _ = stream.set_write_timeout(Some(Duration::from_secs(2)));
        let Ok(reader) = stream.try_clone() else {
            busy.store(false, Ordering::Release);
            continue;
        };
        if sender.send(Message::Client(stream)).is_err() {
            return;
        }
        let sender = sender.clone();
        std::thread::spawn(move || read(reader, &sender));
    }
}

fn read(mut stream: TcpStream, sender: &SyncSender<Message>) {
    let mut bytes = vec![0; 4096];
    loop {
        let message = match stream.read(&mut bytes) {
            Ok(0) => Message::Gone,
            Ok(count) => Message::Bytes(bytes.get(..count).unwrap_or(&[]).to_vec()),
            Err(e) if e.kind() == ErrorKind::Interrupted => continue,
            Err(_) => Message::Gone,
        };
        let last = matches!(message, Message::Gone);
        if sender.send(message).is_err() || last {
            return;
        }
    }
}
