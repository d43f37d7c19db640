//! `instrument`: looks after an instrument by hand.

use asperity_core::protocol::{Diagnostics, Ident, MachineState, Range, Request, Status};
use clap::Subcommand;

use super::error::Failure;
use super::flags::port::PortFlags;
use super::last_words::LastWords;
use super::{interrupt, print};
use crate::acquire::transport::Transport;
use crate::acquire::{Client, Patience, Trouble};

/// Look after an instrument: its status, home, stop, clear a fault
///
/// Examples:
///   asperity instrument status --port /dev/ttyUSB0
///   asperity instrument stop --port tcp:192.168.1.7:5025
///   asperity instrument clear --port /dev/ttyUSB0 && asperity instrument home --port /dev/ttyUSB0
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Print who it is, what it is doing, and where it stands
    Status(Flags),
    /// Find the zeros of both axes
    Home(Flags),
    /// Stop whatever it is doing; an emergency stop if another client is using it
    Stop(Flags),
    /// Clear a fault, once its cause is mended
    Clear(Flags),
}

#[derive(Debug, clap::Args)]
struct Flags {
    #[command(flatten)]
    port: PortFlags,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

type Instrument = Client<'static, Box<dyn Transport>>;

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let (What::Status(flags) | What::Home(flags) | What::Stop(flags) | What::Clear(flags)) =
        &args.what;
    flags.port.need()?;
    let mut client = flags.port.connect()?;
    let done = match &args.what {
        What::Status(_) => return status(&mut client, flags.json),
        What::Home(_) => {
            client.heed(Some(interrupt::flag()));
            let _words = LastWords::keep();
            let done = home(&mut client);
            client.let_go();
            done
        }
        What::Stop(_) => stop(&mut client),
        What::Clear(_) => clear(&mut client),
    };
    client.let_go();
    let said = done?;
    if flags.json {
        return print(&format!("{:#}\n", serde_json::json!({ "asperity": 1, "done": said })));
    }
    print(&format!("{said}\n"))
}

fn home(client: &mut Instrument) -> Result<String, Failure> {
    client.claim()?;
    client.home()?;
    client.release()?;
    Ok("homed".to_owned())
}

fn stop(client: &mut Instrument) -> Result<String, Failure> {
    match client.claim_now() {
        Ok(()) => {}
        Err(e) if matches!(*e.trouble, Trouble::InUse) => {
            client.ask(Request::EmergencyStop)?;
            return Ok("emergency stop, for another client is using it; before it moves again: \
                       `asperity instrument clear`, then `asperity instrument home`"
                .to_owned());
        }
        Err(e) => return Err(e.into()),
    }
    client.ask(Request::Stop)?;
    let limit = Patience::default().grace;
    let idle = client.wait_idle("stopping", limit);
    if let Err(e) = idle {
        // a fault has stopped it already
        let Trouble::Fault(fault) = *e.trouble else { return Err(e.into()) };
        return Ok(format!("it stands still already, by a fault: {fault}"));
    }
    client.release()?;
    Ok("stopped".to_owned())
}

fn clear(client: &mut Instrument) -> Result<String, Failure> {
    let fault = client.status()?.fault;
    client.claim()?;
    client.ask(Request::ClearFault)?;
    let homed = client.status()?.homed;
    client.release()?;
    let said = fault.map_or_else(|| "no fault".to_owned(), |fault| format!("cleared: {fault}"));
    Ok(if homed { said } else { format!("{said}; its axes are to be homed before they move") })
}

fn status(client: &mut Instrument, json: bool) -> Result<(), Failure> {
    let (ident, status) = (*client.ident(), client.status()?);
    let line = client.diagnostics()?;
    print(&if json { as_json(&ident, &status, &line) } else { as_text(&ident, &status, &line) })
}

fn as_json(ident: &Ident, status: &Status, line: &Diagnostics) -> String {
    let [major, minor, patch] = ident.firmware;
    let axis = |limits: asperity_core::protocol::AxisLimits, at: f64| {
        serde_json::json!({
            "position_deg": at,
            "least_deg": limits.least.degrees(),
            "most_deg": limits.most.degrees(),
            "speed_deg_per_s": f64::from(limits.speed) / 1e6,
        })
    };
    let answer = serde_json::json!({
        "asperity": 1,
        "model": ident.model.as_str(),
        "serial": ident.serial,
        "firmware": format!("{major}.{minor}.{patch}"),
        "protocol": ident.protocol,
        "state": status.state.to_string(),
        "fault": status.fault.map(|fault| fault.to_string()),
        "homed": status.homed,
        "lamp": status.lamp,
        "sigma": axis(ident.sigma, status.sigma.degrees()),
        "theta": axis(ident.theta, status.theta.degrees()),
        "aperture_deg": status.aperture.degrees(),
        "range": range(status.range),
        "integration_ms": f64::from(status.integration_us) / 1e3,
        "calibration": status.calibration.map(|id| format!("{id:08x}")),
        "in_use": status.owner.is_some(),
        "frames": line.frames,
        "bad_frames": line.bad_frames,
        "stack_bytes": line.stack_bytes,
        "uptime_s": f64::from(line.uptime_ms) / 1e3,
    });
    format!("{answer:#}\n")
}

fn as_text(ident: &Ident, status: &Status, line: &Diagnostics) -> String {
    let [major, minor, patch] = ident.firmware;
    let state = match (status.state, status.fault) {
        (MachineState::Fault, Some(fault)) => format!("fault: {fault}"),
        (state, _) => state.to_string(),
    };
    let yes = |yes: bool, a: &'static str, b: &'static str| if yes { a } else { b };
    let calibration = status.calibration.map_or_else(|| "none".into(), |id| format!("{id:08x}"));
    format!(
        "{} {}, firmware {major}.{minor}.{patch}, protocol {}\n\
         {state}; {}; lamp {}; {}\n\
         sigma {} deg, theta {} deg; aperture {} deg, range {}, integration {} ms, calibration {calibration}\n\
         {} frames, {} bad; up {:.0} s\n",
        ident.model,
        ident.serial,
        ident.protocol,
        yes(status.homed, "homed", "not homed"),
        yes(status.lamp, "on", "off"),
        yes(status.owner.is_some(), "in use", "free"),
        status.sigma.degrees(),
        status.theta.degrees(),
        status.aperture.degrees(),
        range(status.range),
        f64::from(status.integration_us) / 1e3,
        line.frames,
        line.bad_frames,
        f64::from(line.uptime_ms) / 1e3,
    )
}

fn range(range: Range) -> String {
    match range {
        Range::Auto => "auto".to_owned(),
        Range::Fixed(number) => number.to_string(),
    }
}
