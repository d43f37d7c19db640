//! The orders of a solution, as a table and in sums.

use std::fmt::Write as _;

use asperity_rigorous::{Kind, Order, Problem, Response, Side, Solution};
use serde_json::json;

/// The side in files: `air` or `inside`.
fn side_word(side: Side) -> &'static str {
    match side {
        Side::Air => "air",
        Side::Dielectric => "inside",
    }
}

fn kind_word(kind: Kind) -> &'static str {
    match kind {
        Kind::Reflected => "R",
        Kind::Transmitted => "T",
    }
}

/// Every order of every incidence: side, order and angle of the light, kind, order and angle of what leaves, efficiencies.
pub fn orders_csv(problem: &Problem, solution: &Solution, head: &str) -> String {
    let mut text = String::new();
    for line in head.lines() {
        let _ = writeln!(text, "# {line}");
    }
    text.push_str("side,m0,theta_i_deg,kind,m,theta_deg,eff_TE,eff_TM\n");
    for response in &solution.responses {
        let (side, m0) = (response.incidence.side, response.incidence.order);
        let incidence = angle_deg(problem.sine(side, m0));
        for (te, tm) in response.te.iter().zip(&response.tm) {
            let _ = writeln!(
                text,
                "{},{m0},{incidence:.6},{},{},{:.6},{:.10},{:.10}",
                side_word(side),
                kind_word(te.kind),
                te.m,
                angle_deg(te.sine),
                te.efficiency(),
                tm.efficiency()
            );
        }
    }
    text
}

/// The same as JSON, with the figures of the solution.
pub fn orders_json(problem: &Problem, solution: &Solution) -> String {
    let response = |r: &Response| {
        let orders = r.te.iter().zip(&r.tm).map(|(te, tm)| {
            json!({
                "kind": kind_word(te.kind),
                "m": te.m,
                "theta_deg": angle_deg(te.sine),
                "eff_TE": te.efficiency(),
                "eff_TM": tm.efficiency(),
            })
        });
        let (side, m0) = (r.incidence.side, r.incidence.order);
        json!({
            "side": side_word(side),
            "m0": m0,
            "theta_i_deg": angle_deg(problem.sine(side, m0)),
            "orders": orders.collect::<Vec<_>>(),
        })
    };
    let value = json!({
        "nodes": solution.nodes,
        "energy_error": solution.energy_error,
        "change": solution.change,
        "incidences": solution.responses.iter().map(response).collect::<Vec<_>>(),
    });
    format!("{value:#}\n")
}

/// Where the light goes: reflected and transmitted shares of each incidence, and the coherent ones of them.
pub fn summary(problem: &Problem, solution: &Solution) -> String {
    let mut text = String::from(
        "side    m0  theta_i   R TE      R TM      T TE      T TM      coherent R, T (mean)\n",
    );
    for r in &solution.responses {
        let (side, m0) = (r.incidence.side, r.incidence.order);
        let sum = |orders: &[Order], kind: Kind| -> f64 {
            orders.iter().filter(|o| o.kind == kind).map(Order::efficiency).sum()
        };
        let coherent = |kind: Kind| {
            let of = |orders: &[Order]| -> f64 {
                let same = orders.iter().filter(|o| o.kind == kind && o.m == m0);
                same.map(Order::efficiency).sum()
            };
            0.5 * (of(&r.te) + of(&r.tm))
        };
        let _ = writeln!(
            text,
            "{:<6} {m0:>4}  {:>7.3}  {:.6}  {:.6}  {:.6}  {:.6}  {:.6}, {:.6}",
            side_word(side),
            angle_deg(problem.sine(side, m0)),
            sum(&r.te, Kind::Reflected),
            sum(&r.tm, Kind::Reflected),
            sum(&r.te, Kind::Transmitted),
            sum(&r.tm, Kind::Transmitted),
            coherent(Kind::Reflected),
            coherent(Kind::Transmitted)
        );
    }
    let change =
        solution.change.map_or(String::new(), |c| format!("; with fewer nodes {c:.1e} off"));
    let _ = writeln!(
        text,
        "{} nodes; balance of energy to {:.1e}{change}",
        solution.nodes, solution.energy_error
    );
    text
}

fn angle_deg(sine: f64) -> f64 {
    sine.clamp(-1.0, 1.0).asin().to_degrees()
}
