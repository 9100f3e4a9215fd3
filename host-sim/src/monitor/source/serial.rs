//! A serial port, opened again whenever it comes back.

use super::{Device, Happened};
use crate::report::record::Source;
use serialport::{SerialPort, SerialPortInfo, SerialPortType};
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

/// The link's speed (docs/protocol.md).
const BAUD: u32 = 230_400;
/// Time between two attempts to open a port that is gone.
const RETRY: Duration = Duration::from_millis(200);
/// Longest wait for a byte: a key is looked at after it.
const READ: Duration = Duration::from_millis(10);
/// ST's number among USB vendors: the board's ST-LINK.
const ST: u16 = 0x0483;

/// Which port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// This one.
    Path(String),
    /// The only one with an ST-LINK, or the only one at all.
    Auto,
}

/// See the module's page.
pub struct Serial {
    wanted: Wanted,
    port: Option<Box<dyn SerialPort>>,
    start: Instant,
    next_try: Instant,
}

impl Serial {
    /// Looks for the port.
    ///
    /// # Errors
    /// When there is no such port, or it cannot be opened: names the ports that there are.
    pub fn new(wanted: Wanted) -> Result<Self, String> {
        let now = Instant::now();
        let mut serial = Self { wanted, port: None, start: now, next_try: now };
        serial.open()?;
        Ok(serial)
    }

    fn open(&mut self) -> Result<(), String> {
        let ports = available();
        let path = choose(&self.wanted, &ports)?;
        let opened = serialport::new(&path, BAUD).timeout(READ).open();
        self.port = Some(opened.map_err(|error| refusal(&path, &error, &ports))?);
        Ok(())
    }
}

/// The ports that there are.
fn available() -> Vec<SerialPortInfo> {
    // The crate panics where a Linux has no such folder, as in some containers.
    if cfg!(target_os = "linux") && !Path::new("/sys/class/tty").is_dir() {
        return Vec::new();
    }
    serialport::available_ports().unwrap_or_default()
}

fn listed(ports: &[SerialPortInfo]) -> String {
    let line = |port: &SerialPortInfo| match &port.port_type {
        SerialPortType::UsbPort(usb) => {
            format!("{} ({})", port.port_name, usb.product.as_deref().unwrap_or("USB"))
        }
        _ => port.port_name.clone(),
    };
    match ports {
        [] => "there is no serial port: connect the board's USB cable, or try --elf".into(),
        _ => format!("there are {}", ports.iter().map(line).collect::<Vec<_>>().join(", ")),
    }
}

fn choose(wanted: &Wanted, ports: &[SerialPortInfo]) -> Result<String, String> {
    let of_st = |port: &&SerialPortInfo| matches!(&port.port_type, SerialPortType::UsbPort(usb) if usb.vid == ST);
    match wanted {
        Wanted::Path(path) if cfg!(windows) || Path::new(path).exists() => Ok(path.clone()),
        Wanted::Path(path) => Err(format!("there is no port {path}; {}", listed(ports))),
        Wanted::Auto => {
            let boards: Vec<_> = ports.iter().filter(of_st).collect();
            match (boards.as_slice(), ports) {
                ([board], _) => Ok(board.port_name.clone()),
                ([], [only]) => Ok(only.port_name.clone()),
                ([], []) => Err(listed(ports)),
                _ => Err(format!("which port? Name it with --port; {}", listed(ports))),
            }
        }
    }
}

fn refusal(path: &str, error: &serialport::Error, ports: &[SerialPortInfo]) -> String {
    let hint = match error.kind() {
        serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => {
            "; on Linux add yourself to the group dialout, or close what else has it open".to_owned()
        }
        _ => format!("; {}", listed(ports)),
    };
    format!("cannot open {path}: {error}{hint}")
}

impl Device for Serial {
    fn source(&self) -> Source {
        Source::Device
    }

    fn name(&self) -> String {
        match &self.wanted {
            Wanted::Path(path) => path.clone(),
            Wanted::Auto => self.port.as_ref().and_then(|port| port.name()).unwrap_or_else(|| "any port".into()),
        }
    }

    fn now_ms(&self) -> u64 {
        self.start.elapsed().as_millis() as u64
    }

    fn unix_ms(&self) -> Option<u64> {
        SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).ok().map(|since| since.as_millis() as u64)
    }

    fn poll(&mut self, wait: Duration) -> anyhow::Result<Happened> {
        let Some(port) = &mut self.port else {
            let now = Instant::now();
            if now < self.next_try {
                std::thread::sleep(wait.min(self.next_try - now));
                return Ok(Happened::Nothing);
            }
            self.next_try = now + RETRY;
            return Ok(if self.open().is_ok() { Happened::Opened } else { Happened::Nothing });
        };
        let mut bytes = vec![0; 4096];
        let why = match port.read(&mut bytes) {
            Ok(0) => "the port is gone".to_owned(),
            Ok(count) => {
                bytes.truncate(count);
                return Ok(Happened::Bytes(bytes));
            }
            Err(error)
                if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock) =>
            {
                return Ok(Happened::Nothing);
            }
            Err(error) => error.to_string(),
        };
        self.port = None;
        self.next_try = Instant::now() + RETRY;
        Ok(Happened::Lost(why))
    }

    fn send(&mut self, bytes: &[u8]) {
        if let Some(port) = &mut self.port {
            // A line that is gone is seen when it is read from.
            drop(port.write_all(bytes));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serialport::UsbPortInfo;

    fn port(name: &str, vid: Option<u16>) -> SerialPortInfo {
        let usb = |vid| {
            SerialPortType::UsbPort(UsbPortInfo {
                vid,
                pid: 0x374B,
                serial_number: None,
                manufacturer: None,
                product: Some("STM32 STLink".into()),
            })
        };
        SerialPortInfo { port_name: name.into(), port_type: vid.map_or(SerialPortType::Unknown, usb) }
    }

    #[test]
    fn the_boards_own_port_is_found_among_others() {
        let ports = [port("/dev/ttyS0", None), port("/dev/ttyACM0", Some(ST)), port("/dev/ttyUSB0", Some(0x0403))];
        assert_eq!(choose(&Wanted::Auto, &ports), Ok("/dev/ttyACM0".into()));
        assert_eq!(choose(&Wanted::Auto, &ports[..1]), Ok("/dev/ttyS0".into()));
        let twice = [port("/dev/ttyACM0", Some(ST)), port("/dev/ttyACM1", Some(ST))];
        let error = choose(&Wanted::Auto, &twice).expect_err("two boards");
        assert!(error.contains("--port") && error.contains("/dev/ttyACM1 (STM32 STLink)"), "{error}");
    }

    #[test]
    fn an_unknown_port_names_those_that_there_are() {
        let wanted = Wanted::Path("/dev/ttyNOTHERE".into());
        let error = choose(&wanted, &[port("/dev/ttyACM7", Some(ST))]).expect_err("not there");
        assert!(error.contains("/dev/ttyNOTHERE") && error.contains("/dev/ttyACM7"), "{error}");
        assert!(choose(&wanted, &[]).expect_err("none").contains("no serial port"));
    }
}
