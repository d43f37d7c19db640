//! A serial port, or a pseudo terminal.

use std::io::{self, Read, Write};
use std::thread;
use std::time::{Duration, Instant};

use serialport::{ClearBuffer, ErrorKind, SerialPort, SerialPortType};

use super::{Transport, broken, is_only_late};

/// Longest time for sending a frame.
const SEND: Duration = Duration::from_secs(1);

/// A serial port, 8 bits, no parity, 1 stop bit, that no other program may open meanwhile.
///
/// `TIOCEXCL` keeps others out, but not root; so `serialport` also takes an advisory lock (`flock`) of
/// the device. A second lock of our own on the same device would shut out that one.
#[derive(Debug)]
pub struct Serial {
    path: String,
    baud: u32,
    port: Option<Box<dyn SerialPort>>,
    begun: Instant,
}

impl Serial {
    /// Opens the port with `baud` bits per second.
    ///
    /// # Errors
    /// The operating system's; [`io::ErrorKind::ResourceBusy`] if another program has it.
    pub fn open(path: &str, baud: u32) -> io::Result<Self> {
        let mut serial = Self { path: path.to_owned(), baud, port: None, begun: Instant::now() };
        serial.reconnect()?;
        Ok(serial)
    }
}

impl Transport for Serial {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let port = self.port.as_mut().ok_or_else(broken)?;
        port.set_timeout(SEND)?;
        port.write_all(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> io::Result<usize> {
        let port = self.port.as_mut().ok_or_else(broken)?;
        port.set_timeout(wait)?;
        match port.read(buffer) {
            Ok(0) => Err(broken()),
            Err(e) if is_only_late(&e) => Ok(0),
            result => result,
        }
    }

    fn now(&self) -> Duration {
        self.begun.elapsed()
    }

    fn pause(&mut self, time: Duration) {
        thread::sleep(time);
    }

    fn reconnect(&mut self) -> io::Result<()> {
        // the old one holds the lock
        self.port = None;
        let port = serialport::new(&self.path, self.baud).open().map_err(|e| match e.kind() {
            ErrorKind::NoDevice if cfg!(unix) => io::Error::from(io::ErrorKind::ResourceBusy),
            _ => io::Error::from(e),
        })?;
        // what came before is nobody's answer; where that cannot be done the decoder throws it away
        let _ = port.clear(ClearBuffer::Input);
        self.port = Some(port);
        Ok(())
    }

    fn name(&self) -> String {
        self.path.clone()
    }
}

/// A serial port of this computer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortName {
    /// The name for `--port`.
    pub name: String,
    /// The device at the port, if it identifies itself.
    pub what: String,
}

/// The serial ports of this computer, by name.
///
/// # Errors
/// The operating system's.
pub fn list() -> io::Result<Vec<PortName>> {
    let mut ports: Vec<_> = serialport::available_ports()?
        .into_iter()
        .map(|port| PortName { name: port.port_name, what: describe(port.port_type) })
        .collect();
    ports.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(ports)
}

fn describe(kind: SerialPortType) -> String {
    match kind {
        SerialPortType::UsbPort(usb) => {
            let words = [usb.manufacturer, usb.product, usb.serial_number];
            let words: Vec<String> = words.into_iter().flatten().collect();
            format!("USB {:04x}:{:04x} {}", usb.vid, usb.pid, words.join(", "))
                .trim_end()
                .to_owned()
        }
        SerialPortType::PciPort => "built in".to_owned(),
        SerialPortType::BluetoothPort => "Bluetooth".to_owned(),
        SerialPortType::Unknown => String::new(),
    }
}
