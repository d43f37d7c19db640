//! The content of a plot: panels of curves under one title. Plain data, checked when drawn.

/// The most panels one figure holds; more would be too small to read.
pub const MAX_PANELS: usize = 9;

/// The meaning of a curve, which decides its style.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveStyle {
    /// Data: a broad grey line under everything else, or circles when the points are few.
    Measured,
    /// A model: a thin line over the data, told from the others by colour and by dashes.
    Fitted,
    /// Points by themselves, told from the others by colour.
    Points,
    /// A ring around each point, under it.
    Marked,
    /// The light area between pairs of points, the lower and the upper end at each place, under the fitted curve of the same
    /// name.
    Band,
}

impl CurveStyle {
    /// All, in the order of drawing.
    pub(super) const ALL: [Self; 5] =
        [Self::Band, Self::Measured, Self::Marked, Self::Fitted, Self::Points];

    /// Whether its curves have colours of their own.
    pub(super) fn is_coloured(self) -> bool {
        matches!(self, Self::Fitted | Self::Points)
    }
}

/// One line of a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name in the legend. Curves of the same name in several panels share colour and legend entry.
    pub label: String,
    /// Points `(x, y)` in drawing order.
    pub points: Vec<(f64, f64)>,
    /// Data or model.
    pub style: CurveStyle,
}

/// One pair of axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Line above the axes, such as `σ = 15°`.
    pub caption: String,
    /// Curves, drawn in this order, the measured ones first.
    pub curves: Vec<Curve>,
}

/// The vertical scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// From zero, or from the lowest reading if that is clearly negative, to the highest.
    Linear,
    /// Logarithmic. Readings that are not positive are left out and break their line.
    Log {
        /// Decades shown below the highest measured reading, 1 to 15.
        decades: u8,
    },
}

impl Scale {
    /// The logarithmic scale used unless asked otherwise: four decades, about what a goniophotometer resolves.
    pub const LOG: Self = Self::Log { decades: 4 };
}

/// The horizontal scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// Angles in degrees, with ticks at parts of a circle.
    Angle,
    /// Any other number.
    Linear,
    /// Logarithmic; both ends are positive.
    Log,
}

/// A grid of panels under one title, with one legend and common axis labels.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Line above the panels.
    pub title: String,
    /// Name and unit of the horizontal axes.
    pub x_label: String,
    /// Name and unit of the vertical axes.
    pub y_label: String,
    /// Ends of all horizontal axes. Points outside are cut off.
    pub x_range: (f64, f64),
    /// Horizontal scale of all panels.
    pub across: Across,
    /// Vertical scale of all panels.
    pub scale: Scale,
    /// Whether all panels have one vertical range, so that heights compare between them.
    pub shared_y: bool,
    /// Panels of a row, 1 to 4; chosen by their number if `None`.
    pub columns: Option<usize>,
    /// The panels, row by row, at most [`MAX_PANELS`].
    pub panels: Vec<Panel>,
}

impl Figure {
    /// Refuses a figure that cannot be drawn.
    pub(super) fn check(&self) -> Result<(), PlotError> {
        let (lo, hi) = self.x_range;
        let placed = self.across != Across::Log || lo > 0.0;
        if !(drawable(lo) && drawable(hi) && lo < hi && placed) {
            return Err(PlotError::BadRange { lo, hi });
        }
        if let Scale::Log { decades } = self.scale
            && !(1..=15).contains(&decades)
        {
            return Err(PlotError::BadDecades(decades));
        }
        match self.panels.len() {
            0 => return Err(PlotError::NoPanels),
            1..=MAX_PANELS => {}
            count => return Err(PlotError::TooManyPanels(count)),
        }
        for panel in &self.panels {
            if panel.curves.is_empty() {
                return Err(PlotError::EmptyPanel { panel: panel.caption.clone() });
            }
            for curve in &panel.curves {
                check_curve(&panel.caption, curve)?;
            }
        }
        let shown = |y: f64| y > 0.0 || self.scale == Scale::Linear;
        if !self.curves().flat_map(|c| &c.points).any(|&(x, y)| shown(y) && lo <= x && x <= hi) {
            return Err(match self.scale {
                Scale::Linear => PlotError::NothingInRange { lo, hi },
                Scale::Log { .. } => PlotError::NothingPositive,
            });
        }
        Ok(())
    }

    /// The curves of all panels.
    pub(super) fn curves(&self) -> impl Iterator<Item = &Curve> {
        self.panels.iter().flat_map(|panel| &panel.curves)
    }
}

/// Why a figure cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// The figure has no panel.
    #[error("nothing to plot: the figure has no panels")]
    NoPanels,
    /// The figure has more panels than are legible.
    #[error("{0} panels do not fit into one figure, choose at most {MAX_PANELS}")]
    TooManyPanels(usize),
    /// A panel has no curve.
    #[error("nothing to plot in panel `{panel}`: it has no curves")]
    EmptyPanel {
        /// Caption of the panel.
        panel: String,
    },
    /// A curve has no point.
    #[error("nothing to plot for `{curve}` in panel `{panel}`: the curve has no points")]
    EmptyCurve {
        /// Caption of the panel.
        panel: String,
        /// Label of the curve.
        curve: String,
    },
    /// A coordinate is NaN, infinite or beyond 1e100.
    #[error("point {index} of `{curve}` in panel `{panel}` cannot be plotted: ({x}, {y})")]
    NotFinite {
        /// Caption of the panel.
        panel: String,
        /// Label of the curve.
        curve: String,
        /// Which point, from 0.
        index: usize,
        /// Its horizontal coordinate.
        x: f64,
        /// Its vertical coordinate.
        y: f64,
    },
    /// The ends of the horizontal axis are not two numbers in ascending order, or not positive on a
    /// logarithmic one.
    #[error("the horizontal axis cannot run from {lo} to {hi}")]
    BadRange {
        /// Requested left end.
        lo: f64,
        /// Requested right end.
        hi: f64,
    },
    /// The number of decades is not from 1 to 15.
    #[error("a logarithmic axis shows 1 to 15 decades, not {0}")]
    BadDecades(u8),
    /// A linear figure has no point between the ends of the horizontal axis.
    #[error("nothing to plot: no point lies between {lo} and {hi} on the horizontal axis")]
    NothingInRange {
        /// Left end.
        lo: f64,
        /// Right end.
        hi: f64,
    },
    /// A logarithmic figure has no positive value to show.
    #[error("nothing to plot on a logarithmic scale: no reading on the axis is above zero")]
    NothingPositive,
    /// A map without area or values.
    #[error("nothing to plot: the map has no extent or no value")]
    EmptyMap,
    /// The picture could not be rasterised.
    #[error("the picture could not be rasterised: {0}")]
    Raster(String),
}

fn check_curve(panel: &str, curve: &Curve) -> Result<(), PlotError> {
    if curve.points.is_empty() {
        return Err(PlotError::EmptyCurve { panel: panel.into(), curve: curve.label.clone() });
    }
    match curve.points.iter().enumerate().find(|(_, (x, y))| !(drawable(*x) && drawable(*y))) {
        None => Ok(()),
        Some((index, &(x, y))) => Err(PlotError::NotFinite {
            panel: panel.into(),
            curve: curve.label.clone(),
            index,
            x,
            y,
        }),
    }
}

/// Finite, and far enough from the largest number for differences and ratios to be finite too.
fn drawable(v: f64) -> bool {
    v.abs() <= 1e100
}
