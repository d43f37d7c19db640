//! The product of two matrices, blocked for the caches and for vector registers of four numbers.
//!
//! The scheme is that of K. Goto and R. van de Geijn, *Anatomy of high-performance matrix multiplication*,
//! ACM Trans. Math. Softw. 34 (2008) 12: strips of both factors are copied into the order in which the innermost
//! loop reads them, and that loop keeps a tile of the result in registers.

use multiversion::multiversion;
use multiversion::target::target_cfg_f;

use super::matrix::{Block, Matrix};
use crate::stage::{Stopped, Tally};

/// Rows of a tile.
const HIGH: usize = 6;
/// Columns of a tile: the numbers of a vector register.
const WIDE: usize = 4;
/// Terms of a sum that are added in one go: what the first cache holds of both strips.
const DEEP: usize = 192;
/// Rows that stay in the second cache.
const STAY: usize = 16 * HIGH;

/// One column of a strip of the left factor: real parts, imaginary parts.
type Left = [f64; 2 * HIGH];
/// One row of a strip of the right factor: real parts, imaginary parts.
type Right = [f64; 2 * WIDE];

/// Where the strips are copied to, kept from product to product.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    left: Vec<Left>,
    right: Vec<Right>,
}

/// `result += sign left right`; a factor without a matrix is part of the result's own.
#[derive(Debug)]
pub(crate) struct Product<'a> {
    /// The matrix of the left factor.
    pub(crate) left: Option<&'a Matrix>,
    /// Where the left factor is.
    pub(crate) left_at: Block,
    /// The matrix of the right factor.
    pub(crate) right: Option<&'a Matrix>,
    /// Where the right factor is.
    pub(crate) right_at: Block,
    /// 1 or -1.
    pub(crate) sign: f64,
}

impl<'a> Product<'a> {
    /// Of two whole matrices.
    pub(crate) fn of(left: &'a Matrix, right: &'a Matrix, sign: f64) -> Self {
        let (left_at, right_at) = (left.whole(), right.whole());
        Self { left: Some(left), left_at, right: Some(right), right_at, sign }
    }
}

/// Adds a product to the block of `result` at `row`, `col`, which overlaps neither factor.
///
/// # Errors
/// The watcher wants the work to end.
pub(crate) fn add_product(
    result: &mut Matrix,
    row: usize,
    col: usize,
    product: &Product<'_>,
    scratch: &mut Scratch,
    tally: &Tally<'_>,
) -> Result<(), Stopped> {
    let Product { left_at, right_at, sign, .. } = *product;
    let (rows, cols, all) = (left_at.rows, right_at.cols, left_at.cols);
    for first in (0..all).step_by(DEEP) {
        let deep = DEEP.min(all - first);
        let strip = Block { col: left_at.col + first, cols: deep, ..left_at };
        pack_left(product.left.unwrap_or(result), strip, &mut scratch.left);
        let strip = Block { row: right_at.row + first, rows: deep, ..right_at };
        pack_right(product.right.unwrap_or(result), strip, &mut scratch.right);
        for top in (0..rows).step_by(STAY) {
            let high = STAY.min(rows - top);
            let tiles = &scratch.left[top / HIGH * deep..][..high.div_ceil(HIGH) * deep];
            let at = (row + top) * result.cols + col;
            let shape = Shape { stride: result.cols, rows: high, cols, deep, sign };
            add_strips(&mut result.re[at..], &mut result.im[at..], shape, tiles, &scratch.right);
            tally.spend(8.0 * (high * cols * deep) as f64)?;
        }
    }
    Ok(())
}

fn pack_left(from: &Matrix, at: Block, to: &mut Vec<Left>) {
    to.clear();
    to.resize(at.rows.div_ceil(HIGH) * at.cols, [0.0; 2 * HIGH]);
    for row in 0..at.rows {
        let strip = &mut to[row / HIGH * at.cols..][..at.cols];
        let start = (at.row + row) * from.cols + at.col;
        let (re, im) = (&from.re[start..start + at.cols], &from.im[start..start + at.cols]);
        let lane = row % HIGH;
        for ((column, re), im) in strip.iter_mut().zip(re).zip(im) {
            column[lane] = *re;
            column[HIGH + lane] = *im;
        }
    }
}

fn pack_right(from: &Matrix, at: Block, to: &mut Vec<Right>) {
    to.clear();
    to.resize(at.cols.div_ceil(WIDE) * at.rows, [0.0; 2 * WIDE]);
    for row in 0..at.rows {
        let start = (at.row + row) * from.cols + at.col;
        let (re, im) = (&from.re[start..start + at.cols], &from.im[start..start + at.cols]);
        for (tile, (re, im)) in re.chunks(WIDE).zip(im.chunks(WIDE)).enumerate() {
            let to = &mut to[tile * at.rows + row];
            to[..re.len()].copy_from_slice(re);
            to[WIDE..WIDE + im.len()].copy_from_slice(im);
        }
    }
}

/// Of the part of the result that a set of strips adds to.
#[derive(Clone, Copy)]
struct Shape {
    stride: usize,
    rows: usize,
    cols: usize,
    deep: usize,
    sign: f64,
}

#[multiversion(targets("x86_64+avx2+fma"))]
fn add_strips(re: &mut [f64], im: &mut [f64], shape: Shape, left: &[Left], right: &[Right]) {
    for (j, right) in right.chunks_exact(shape.deep).enumerate() {
        let (col, wide) = (j * WIDE, WIDE.min(shape.cols - j * WIDE));
        for (i, left) in left.chunks_exact(shape.deep).enumerate() {
            let tile = if target_cfg_f!(target_feature = "fma") {
                tile::<true>(left, right)
            } else {
                tile::<false>(left, right)
            };
            let high = HIGH.min(shape.rows - i * HIGH);
            for (row, (tile_re, tile_im)) in tile.re.iter().zip(&tile.im).take(high).enumerate() {
                let at = (i * HIGH + row) * shape.stride + col;
                for (to, from) in re[at..at + wide].iter_mut().zip(tile_re) {
                    *to += shape.sign * from;
                }
                for (to, from) in im[at..at + wide].iter_mut().zip(tile_im) {
                    *to += shape.sign * from;
                }
            }
        }
    }
}

struct Tile {
    re: [[f64; WIDE]; HIGH],
    im: [[f64; WIDE]; HIGH],
}

/// The product of two strips, in registers. `FUSED`: the processor has a fused multiply-add.
#[inline(always)]
#[allow(clippy::inline_always, reason = "its instructions are those of the caller's version")]
fn tile<const FUSED: bool>(left: &[Left], right: &[Right]) -> Tile {
    let add = |a: f64, b: f64, sum: f64| if FUSED { a.mul_add(b, sum) } else { a * b + sum };
    let mut tile = Tile { re: [[0.0; WIDE]; HIGH], im: [[0.0; WIDE]; HIGH] };
    for (a, b) in left.iter().zip(right) {
        for row in 0..HIGH {
            let (re, im) = (a[row], a[HIGH + row]);
            for col in 0..WIDE {
                tile.re[row][col] = add(re, b[col], tile.re[row][col]);
                tile.im[row][col] = add(re, b[WIDE + col], tile.im[row][col]);
            }
            for col in 0..WIDE {
                tile.re[row][col] = add(-im, b[WIDE + col], tile.re[row][col]);
                tile.im[row][col] = add(im, b[col], tile.im[row][col]);
            }
        }
    }
    tile
}
