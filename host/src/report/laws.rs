//! Laws over each other: their lobes from both sides, and where the light goes.

use asperity_core::direction::Side;

use super::angle_text;
use super::boundary::{BAND, curve_and_band, lobe_name};
use crate::model::Flux;
use crate::plot::{
    Across, Curve, CurveStyle, Diagram, DiagramLobe, DiagramPicture, Figure, HemisphereDisc,
    HemispherePicture, Panel, Scale,
};
use crate::reconstruct::{BoundaryValue, HemisphereValues};

/// A law by its name, with its values in the plane of incidence.
pub type NamedValues = (String, Vec<BoundaryValue>);
/// A law by its name, with its balances.
pub type NamedFluxes = (String, Vec<Flux>);

/// The lobes of several laws, a panel for each side, lobe and incidence, with their bands: a row for each side, or for each lobe of
/// one side. On a linear scale each panel has its own range.
pub fn lobes_figure(title: &str, laws: &[NamedValues], scale: Scale) -> Figure {
    let mut places: Vec<Place> = Vec::new();
    for value in laws.iter().flat_map(|(_, values)| values) {
        let place = (value.side, value.incidence_deg, value.is_transmitted);
        if !places.contains(&place) {
            places.push(place);
        }
    }
    // stable: incidences stay as they were asked for
    places.sort_by_key(|(side, _, through)| (*side == Side::Dielectric, *through));
    let is_at = |v: &BoundaryValue, (side, deg, through): Place| {
        v.side == side && v.is_transmitted == through && v.incidence_deg.total_cmp(&deg).is_eq()
    };
    let panel = |place: Place| {
        let of = |(label, values): &NamedValues| {
            let here: Vec<BoundaryValue> =
                values.iter().filter(|v| is_at(v, place)).copied().collect();
            curve_and_band(label, &here)
        };
        let caption =
            format!("{}, {}°, {}", from(place.0), angle_text(place.1), lobe_name(place.2));
        Panel { caption, curves: laws.iter().flat_map(of).collect() }
    };
    let columns = columns(&places);
    let panels: Vec<Panel> = places.into_iter().map(panel).collect();
    Figure {
        title: title.to_owned(),
        x_label: "angle of observation in the medium that the light goes to (°)".into(),
        y_label: "BSDF (1/sr)".into(),
        x_range: lit(&panels, scale),
        across: Across::Angle,
        scale,
        shared_y: scale != Scale::Linear,
        columns,
        panels: panels.into_iter().filter(|p| !p.curves.is_empty()).collect(),
    }
}

/// The side, incidence and lobe of a panel; light goes through or comes back.
type Place = (Side, f64, bool);

/// How many panels make a row, where the rows are of one length: sides, or the lobes of one side.
fn columns(places: &[Place]) -> Option<usize> {
    let rows = |same: fn(&Place, &Place) -> bool| {
        let mut rows = places.chunk_by(same).map(<[_]>::len);
        let first = rows.next()?;
        let count = 1 + rows.clone().count();
        (count > 1 && rows.all(|other| other == first)).then_some(first)
    };
    let by_side = rows(|a, b| a.0 == b.0);
    let by_lobe = rows(|a, b| a.2 == b.2);
    let is_one_side = places.iter().all(|place| place.0 == Side::Air)
        || places.iter().all(|place| place.0 == Side::Dielectric);
    let columns = if is_one_side { by_lobe } else { by_side };
    columns.filter(|columns| *columns > 1)
}

/// The same as polar diagrams, one for each side and incidence; `below` names what lies below the surface.
pub fn lobe_diagrams(
    title: &str,
    laws: &[NamedValues],
    scale: Scale,
    below: &str,
) -> DiagramPicture {
    let mut places: Vec<(Side, f64)> = Vec::new();
    for value in laws.iter().flat_map(|(_, values)| values) {
        if !places.contains(&(value.side, value.incidence_deg)) {
            places.push((value.side, value.incidence_deg));
        }
    }
    let diagram = |(side, incidence_deg): (Side, f64)| {
        let of = |(label, values): &NamedValues| {
            [false, true].map(|is_transmitted| {
                let here = values.iter().filter(|v| {
                    v.side == side
                        && v.incidence_deg.total_cmp(&incidence_deg).is_eq()
                        && v.is_transmitted == is_transmitted
                });
                let points = here.map(|v| (v.theta_deg, v.f)).collect();
                DiagramLobe { label: label.clone(), is_transmitted, points }
            })
        };
        let lobes = laws.iter().flat_map(of).filter(|lobe| !lobe.points.is_empty());
        Diagram {
            caption: format!("{}, {}°", from(side), angle_text(incidence_deg)),
            from_inside: side == Side::Dielectric,
            incidence_deg,
            lobes: lobes.collect(),
        }
    };
    DiagramPicture {
        title: title.to_owned(),
        label: "BSDF (1/sr)".into(),
        below: below.to_owned(),
        decades: decades(scale),
        diagrams: places.into_iter().map(diagram).collect(),
    }
}

/// Lobes over the hemisphere, a disc for each law, side, incidence and lobe that has light.
pub fn hemisphere_picture(
    title: &str,
    laws: &[(String, Vec<HemisphereValues>)],
    scale: Scale,
) -> HemispherePicture {
    let disc = |(label, values): (&String, &HemisphereValues)| {
        let caption = format!(
            "{}, {}°, {}",
            from(values.side),
            angle_text(values.incidence_deg),
            lobe_name(values.is_transmitted)
        );
        let caption = if laws.len() > 1 { format!("{label}: {caption}") } else { caption };
        HemisphereDisc { caption, values: values.values.clone() }
    };
    let all = laws.iter().flat_map(|(label, values)| values.iter().map(move |v| (label, v)));
    let lit = all.filter(|(_, v)| v.values.iter().any(|f| *f > 0.0));
    HemispherePicture {
        title: title.to_owned(),
        label: "BSDF (1/sr)".into(),
        decades: decades(scale),
        discs: lit.map(disc).collect(),
    }
}

fn from(side: Side) -> &'static str {
    if side == Side::Air { "from the air" } else { "from inside" }
}

fn decades(scale: Scale) -> Option<u8> {
    match scale {
        Scale::Linear => None,
        Scale::Log { decades } => Some(decades),
    }
}

/// The angles at which a panel shows light, with a margin.
fn lit(panels: &[Panel], scale: Scale) -> (f64, f64) {
    const MARGIN: f64 = 5.0;
    let share = match scale {
        Scale::Linear => 0.005,
        Scale::Log { decades } => 10.0_f64.powi(-i32::from(decades)),
    };
    let points = |panel: &Panel| -> Vec<(f64, f64)> {
        let lines = panel.curves.iter().filter(|c| c.style != CurveStyle::Band);
        lines.flat_map(|c| &c.points).copied().collect()
    };
    let panels: Vec<Vec<(f64, f64)>> = panels.iter().map(points).collect();
    let top = |points: &[(f64, f64)]| points.iter().map(|p| p.1).fold(0.0, f64::max);
    let largest = panels.iter().map(|points| top(points)).fold(0.0, f64::max);
    let seen = panels.iter().flat_map(|points| {
        let largest = if scale == Scale::Linear { top(points) } else { largest };
        points.iter().filter(move |p| p.1 >= share * largest).map(|p| p.0)
    });
    let (low, high) =
        seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    if low > high {
        return (-90.0, 90.0);
    }
    ((low - MARGIN).max(-90.0), (high + MARGIN).min(90.0))
}

/// Where the light of several laws goes over the incidence: reflected, transmitted and lost from both sides, with bands.
pub fn flux_figure(title: &str, laws: &[NamedFluxes]) -> Figure {
    type Share = (&'static str, fn(&Flux) -> f64, fn(&Flux) -> Option<f64>);
    const SHARES: [Share; 3] = [
        ("reflected", |f| f.reflected, |f| f.std_reflected),
        ("transmitted", |f| f.transmitted, |f| f.std_transmitted),
        ("lost", |f| f.lost, |_| None),
    ];
    let panel = |(side, from): (&str, &str), (name, value, error): Share| {
        let of = |(label, fluxes): &NamedFluxes| {
            let here: Vec<&Flux> = fluxes.iter().filter(|f| f.side == side).collect();
            let points: Vec<(f64, f64)> =
                here.iter().map(|f| (f.incidence_deg, value(f))).collect();
            if points.is_empty() {
                return Vec::new();
            }
            let band = here.iter().flat_map(|f| {
                let by = BAND * error(f).unwrap_or(0.0);
                [(f.incidence_deg, value(f) - by), (f.incidence_deg, value(f) + by)]
            });
            let has_band = here.iter().any(|f| error(f).is_some());
            let band = has_band.then(|| Curve {
                label: label.clone(),
                points: band.collect(),
                style: CurveStyle::Band,
            });
            let line = Curve { label: label.clone(), points, style: CurveStyle::Fitted };
            band.into_iter().chain([line]).collect::<Vec<_>>()
        };
        Panel { caption: format!("{from}, {name}"), curves: laws.iter().flat_map(of).collect() }
    };
    let sides = [("air", "from the air"), ("dielectric", "from inside")];
    let panels = sides.into_iter().flat_map(|s| SHARES.map(|share| panel(s, share)));
    Figure {
        title: title.to_owned(),
        x_label: "angle of incidence in the medium that the light comes from (°)".into(),
        y_label: "share of the light".into(),
        x_range: (0.0, 90.0),
        across: Across::Angle,
        scale: Scale::Linear,
        shared_y: true,
        columns: None,
        panels: panels.filter(|p| !p.curves.is_empty()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::direction::Side;

    use super::{flux_figure, lobe_diagrams, lobes_figure};
    use crate::model::Flux;
    use crate::plot::{CurveStyle, Scale};
    use crate::reconstruct::BoundaryValue;

    fn lobe(is_transmitted: bool, width: f64) -> Vec<BoundaryValue> {
        (-88..=88)
            .map(|t| BoundaryValue {
                side: Side::Dielectric,
                incidence_deg: 30.0,
                is_transmitted,
                theta_deg: f64::from(t),
                f: (-(f64::from(t) / width).powi(2)).exp(),
                std: is_transmitted.then_some(0.01),
            })
            .collect()
    }

    #[test]
    fn lobes_have_a_panel_each_and_the_axis_ends_where_the_light_does() {
        let laws = [("a".to_owned(), lobe(false, 5.0)), ("b".to_owned(), lobe(true, 5.0))];
        let figure = lobes_figure("title", &laws, Scale::LOG);
        let captions: Vec<&str> = figure.panels.iter().map(|p| p.caption.as_str()).collect();
        assert_eq!(captions, ["from inside, 30°, reflection", "from inside, 30°, transmission"]);
        // 1e-4 of the peak at 5 sqrt(ln 1e4) = 15.2 degrees, and a margin of 5
        assert_eq!(figure.x_range, (-20.0, 20.0));
        let styles: Vec<_> = figure.panels[1].curves.iter().map(|c| c.style).collect();
        assert_eq!(styles, [CurveStyle::Band, CurveStyle::Fitted]);
    }

    #[test]
    fn each_side_has_a_row_and_each_panel_its_linear_range() {
        let mut values = Vec::new();
        for (side, peak) in [(Side::Air, 1.0), (Side::Dielectric, 1e-3)] {
            for incidence_deg in [0.0, -90.0 + 130.1] {
                for is_transmitted in [false, true] {
                    let place = |v: BoundaryValue| BoundaryValue {
                        side,
                        incidence_deg,
                        f: peak * v.f,
                        std: None,
                        ..v
                    };
                    values.extend(lobe(is_transmitted, 5.0).into_iter().map(place));
                }
            }
        }
        let laws = [("ggx".to_owned(), values)];
        let figure = lobes_figure("title", &laws, Scale::Linear);
        let captions: Vec<&str> = figure.panels.iter().map(|p| p.caption.as_str()).collect();
        assert_eq!(
            captions[2..6],
            [
                "from the air, 0°, transmission",
                "from the air, 40.1°, transmission",
                "from inside, 0°, reflection",
                "from inside, 40.1°, reflection"
            ]
        );
        assert_eq!((figure.columns, figure.shared_y), (Some(4), false));
        // the weak lobes count as the strong ones do: 0.005 of the peak at 11.5 degrees
        assert_eq!(figure.x_range, (-16.0, 16.0));
        let picture = lobe_diagrams("title", &laws, Scale::Linear, "material");
        let captions: Vec<&str> = picture.diagrams.iter().map(|d| d.caption.as_str()).collect();
        assert_eq!(captions[1], "from the air, 40.1°");
        let one = [("ggx".to_owned(), lobe(false, 5.0)), ("b".to_owned(), lobe(true, 5.0))];
        assert_eq!(lobes_figure("title", &one, Scale::LOG).columns, None);
    }

    #[test]
    fn fluxes_have_a_panel_for_each_side_and_share() {
        let flux = |incidence_deg: f64| Flux {
            side: "air".into(),
            incidence_deg,
            reflected: 0.1,
            transmitted: 0.8,
            lost: 0.1,
            std_reflected: Some(0.01),
            std_transmitted: None,
        };
        let figure = flux_figure("title", &[("a".to_owned(), vec![flux(0.0), flux(60.0)])]);
        let captions: Vec<&str> = figure.panels.iter().map(|p| p.caption.as_str()).collect();
        assert_eq!(
            captions,
            ["from the air, reflected", "from the air, transmitted", "from the air, lost"]
        );
        assert_eq!(figure.panels[0].curves[0].points[1], (0.0, 0.1 + 0.0196));
        assert_eq!(figure.panels[1].curves.len(), 1);
    }
}
