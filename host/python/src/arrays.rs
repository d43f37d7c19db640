//! Arguments as arrays of vectors: one precision, shape (N, 3) or (3,), any strides.

use asperity_core::direction::Direction;
use asperity_core::math::Real;
use numpy::ndarray::{ArrayView2, Axis, Ix2, s};
use numpy::{Element, PyArrayDescrMethods, PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArray};
use numpy::{PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::error::{bad, reserved};

/// Rows that are worked on at once: six components of so many fit the first-level cache.
pub(crate) const BLOCK: usize = 512;
/// Deviation of a length from 1 that is taken as rounding; the same as of the program's `eval`.
const LENGTH: f64 = 1e-3;

/// A number of numpy that the library computes with.
pub(crate) trait Number: Real + Element + Send + Sync {
    const DTYPE: &'static str;
    const NAN: Self;
}

impl Number for f32 {
    const DTYPE: &'static str = "float32";
    const NAN: Self = f32::NAN;
}

impl Number for f64 {
    const DTYPE: &'static str = "float64";
    const NAN: Self = f64::NAN;
}

/// An argument and its name, still of any type of real numbers.
pub(crate) struct Argument<'py> {
    name: &'static str,
    array: Bound<'py, PyUntypedArray>,
}

impl<'py> Argument<'py> {
    /// Any array, or what numpy makes one of.
    ///
    /// # Errors
    /// If it does not hold real numbers, or has another shape than (N, 3) or (3,).
    pub(crate) fn new(name: &'static str, given: &Bound<'py, PyAny>) -> PyResult<Self> {
        let made = given.py().import("numpy")?.call_method1("asarray", (given,))?;
        let array = made.cast_into::<PyUntypedArray>()?;
        if !matches!(array.dtype().kind(), b'f' | b'i' | b'u') {
            let what = format!("{name} is an array of {}; give real numbers", array.dtype());
            return Err(bad(what));
        }
        if !matches!(array.shape(), [3] | [_, 3]) {
            let shape = array.getattr("shape")?;
            return Err(bad(format!("{name} has the shape {shape}; give (N, 3) or (3,)")));
        }
        Ok(Self { name, array })
    }

    /// Whether all arguments are of single precision, which is then computed with.
    pub(crate) fn are_single(arguments: &[&Self]) -> bool {
        arguments.iter().all(|a| a.array.cast::<PyArrayDyn<f32>>().is_ok())
    }

    /// The numbers in a precision, copied only if they are of another, or lie askew in memory.
    pub(crate) fn hold<T: Number>(&self) -> PyResult<Held<'py, T>> {
        let py = self.array.py();
        let numpy = py.import("numpy")?;
        let mut array = numpy.call_method1("require", (&self.array, T::DTYPE, "A"))?;
        // a field of a structured array may have steps that are no multiple of its size
        let size = isize::try_from(size_of::<T>())?;
        if array.cast::<PyUntypedArray>()?.strides().iter().any(|s| s % size != 0) {
            array = numpy.call_method1("ascontiguousarray", (array,))?;
        }
        let array = array.cast_into::<PyArrayDyn<T>>()?;
        let array = array.try_readonly().map_err(|_| bad(format!("{} is in use", self.name)))?;
        Ok(Held { name: self.name, array })
    }
}

/// Numbers that Python keeps alive.
pub(crate) struct Held<'py, T: Number> {
    name: &'static str,
    array: PyReadonlyArrayDyn<'py, T>,
}

impl<'py, T: Number> Held<'py, T> {
    /// Python.
    pub(crate) fn py(&self) -> Python<'py> {
        self.array.py()
    }

    /// The rows, to be read without Python's lock.
    pub(crate) fn rows(&self) -> PyResult<Rows<'_, T>> {
        let view = self.array.as_array();
        let is_alone = view.ndim() == 1;
        let view = if is_alone { view.insert_axis(Axis(0)) } else { view };
        let view = view.into_dimensionality::<Ix2>().map_err(bad)?;
        Ok(Rows { name: self.name, view, is_alone })
    }
}

/// Rows of three numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'a, T> {
    name: &'static str,
    view: ArrayView2<'a, T>,
    is_alone: bool,
}

/// Components of up to [`BLOCK`] rows.
pub(crate) type Block<'a, T> = [&'a [T]; 3];

/// Room for the components of a block.
pub(crate) type Room<T> = [[T; BLOCK]; 3];

impl<T: Number> Rows<'_, T> {
    /// Number of rows of two arguments together; one row goes with any number.
    pub(crate) fn common(&self, other: &Self) -> PyResult<usize> {
        match (self.view.nrows(), other.view.nrows()) {
            (a, b) if a == b => Ok(a),
            (1, b) => Ok(b),
            (a, 1) => Ok(a),
            (a, b) => Err(bad(format!(
                "{} has {a} rows and {} has {b}; give as many, or one",
                self.name, other.name
            ))),
        }
    }

    /// Whether it was one vector, not an array of vectors.
    pub(crate) fn is_alone(&self) -> bool {
        self.is_alone
    }

    /// The components of `count` rows from a row on.
    pub(crate) fn block<'r>(
        &self,
        from: usize,
        count: usize,
        room: &'r mut Room<T>,
    ) -> Block<'r, T> {
        let rows = if self.view.nrows() == 1 { 0..1 } else { from..from + count };
        let part = self.view.slice(s![rows, ..]);
        for (axis, room) in room.iter_mut().enumerate() {
            let column = part.column(axis);
            if column.len() == 1 {
                room[..count].fill(column[0]);
            } else {
                room[..count].iter_mut().zip(column).for_each(|(to, x)| *to = *x);
            }
        }
        room.each_ref().map(|room| &room[..count])
    }

    /// Refuses what is no unit vector; NaN passes. `from` is the row of the first.
    pub(crate) fn check_lengths(&self, from: usize, block: Block<'_, T>) -> Result<(), String> {
        let [x, y, z] = block;
        let length = |k: usize| (x[k] * x[k] + y[k] * y[k] + z[k] * z[k]).sqrt().to_f64();
        match (0..x.len()).find(|&k| (length(k) - 1.0).abs() > LENGTH) {
            None => Ok(()),
            Some(k) => {
                let row = if self.view.nrows() == 1 { 0 } else { from + k };
                let (name, length) = (self.name, length(k));
                Err(format!("{name}[{row}] has length {length}; give a unit vector"))
            }
        }
    }

    /// All rows that are directions; NaN is left out.
    pub(crate) fn directions(&self) -> PyResult<Vec<Direction<T>>> {
        let mut room = [[T::ZERO; BLOCK]; 3];
        let mut found = reserved(self.view.nrows())?;
        for from in (0..self.view.nrows()).step_by(BLOCK) {
            let block = self.block(from, BLOCK.min(self.view.nrows() - from), &mut room);
            self.check_lengths(from, block).map_err(bad)?;
            let [x, y, z] = block;
            let rows =
                x.iter().zip(y).zip(z).filter(|((x, y), z)| !(**x + **y + **z).to_f64().is_nan());
            found.extend(rows.map(|((x, y), z)| Direction::from_unit(*x, *y, *z)));
        }
        Ok(found)
    }

    /// Refuses what is no number from 0 to below 1.
    pub(crate) fn check_uniforms(&self, from: usize, block: Block<'_, T>) -> Result<(), String> {
        for (k, u) in block.iter().flat_map(|c| c.iter().enumerate()) {
            if !(0.0..1.0).contains(&u.to_f64()) {
                let row = if self.view.nrows() == 1 { 0 } else { from + k };
                let (name, u) = (self.name, u.to_f64());
                return Err(format!("{name}[{row}] has {u}; give numbers from 0 to below 1"));
            }
        }
        Ok(())
    }
}
