//! Requests and answers: which belong together, and their names in messages.

use asperity_core::protocol::{Request, Response};

use super::error::Trouble;

/// Whether this is a kind of answer to that request.
pub(super) fn fits(request: Request, response: &Response) -> bool {
    match request {
        Request::Identify => matches!(response, Response::Ident(_)),
        Request::Status => matches!(response, Response::Status(_)),
        Request::Diagnostics => matches!(response, Response::Diagnostics(_)),
        Request::LastReading => matches!(response, Response::Reading(_)),
        Request::LastCalibration => matches!(response, Response::Calibration(_)),
        _ => matches!(response, Response::Accepted),
    }
}

/// An answer by its kind.
pub(super) fn kind(response: &Response) -> &'static str {
    match response {
        Response::Ident(_) => "its name",
        Response::Accepted => "`accepted`",
        Response::Status(_) => "its status",
        Response::Diagnostics(_) => "its counters",
        Response::Reading(_) => "a reading",
        Response::Calibration(_) => "a calibration",
    }
}

/// An answer that does not belong to its request.
pub(super) fn unfit(request: Request, answer: &str) -> Trouble {
    Trouble::Nonsense(format!("asked for {}, it answers with {answer}", name(request)))
}

/// A request in plain words.
pub(super) fn name(request: Request) -> &'static str {
    match request {
        Request::Identify => "its name",
        Request::Claim => "its ownership",
        Request::Release => "its release",
        Request::Status => "its status",
        Request::Diagnostics => "its counters",
        Request::Home => "homing",
        Request::Move(..) => "a movement",
        Request::Aperture(_) => "the aperture",
        Request::Range(_) => "the range",
        Request::Integration(_) => "the integration time",
        Request::Lamp(_) => "switching the lamp",
        Request::Read | Request::LastReading => "a reading",
        Request::Calibrate(_) => "a calibration",
        Request::LastCalibration => "the calibration's values",
        Request::Scan(_) => "the scan of a segment",
        Request::Continue { .. } => "more points of a segment",
        Request::Stop | Request::EmergencyStop => "a stop",
        Request::ClearFault => "the clearing of a fault",
    }
}
