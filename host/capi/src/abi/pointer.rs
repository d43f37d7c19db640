//! Pointers of C as values, slices and objects.

use core::ffi::c_void;
use core::slice;

use crate::law::{AsperityRay, Law, direction, evaluate};
use crate::options::{self, AsperityQuantity as Quantity};
use crate::status::AsperityStatus as Status;

/// A source of uniform numbers in [0, 1); it must return, and must not throw. `state` is what the caller gave.
pub type AsperityUniform = Option<unsafe extern "C" fn(state: *mut c_void) -> f32>;

/// Neither null nor misaligned.
pub(super) fn check<T>(p: *const T) -> Result<(), Status> {
    check_address(p.addr(), align_of::<T>())
}

/// One for all types: a device has no room for a copy at each of a dozen pointers.
#[cfg_attr(target_arch = "arm", inline(never))]
#[cfg_attr(not(target_arch = "arm"), inline(always))]
fn check_address(address: usize, align: usize) -> Result<(), Status> {
    if address == 0 {
        Err(Status::NullPointer)
    } else if address & (align - 1) == 0 {
        Ok(())
    } else {
        Err(Status::Misaligned)
    }
}

/// The same of some pointers, in a loop: a call for each costs a device more than the reading of what is there.
#[cfg_attr(target_arch = "arm", inline(never))]
pub(super) fn check_all<T>(pointers: &[*const T]) -> Result<(), Status> {
    pointers.iter().try_for_each(|p| check(*p))
}

/// The value at a pointer.
pub(super) unsafe fn read<T: Copy>(p: *const T) -> Result<T, Status> {
    check(p)?;
    // SAFETY: aligned, and by the caller's promise readable
    Ok(unsafe { p.read() })
}

/// The value at a pointer, in place.
pub(super) unsafe fn refer<'a, T>(p: *const T) -> Result<&'a T, Status> {
    check(p)?;
    // SAFETY: aligned, and by the caller's promise there and unchanging
    Ok(unsafe { &*p })
}

/// Puts a value at a pointer.
pub(super) unsafe fn write<T>(p: *mut T, value: T) -> Result<(), Status> {
    check(p.cast_const())?;
    // SAFETY: aligned, and by the caller's promise writable
    unsafe { p.write(value) };
    Ok(())
}

/// Some values in a row; a length of 0 needs no pointer.
pub(super) unsafe fn slice<'a, T>(p: *const T, length: usize) -> Result<&'a [T], Status> {
    if length == 0 {
        return Ok(&[]);
    }
    check_extent(p.addr(), align_of::<T>(), length, size_of::<T>())?;
    // SAFETY: not null, aligned, no longer than any memory, and by the caller's promise there and unchanging
    unsafe {
        core::hint::assert_unchecked(!p.is_null());
        Ok(slice::from_raw_parts(p, length))
    }
}

/// Whether `count` steps of `stride` values can lie in memory at all.
fn extent<T>(count: usize, stride: usize) -> Result<(), Status> {
    let bytes = count.checked_mul(stride).and_then(|n| n.checked_mul(size_of::<T>()));
    in_memory(bytes)
}

#[inline(always)]
fn in_memory(bytes: Option<usize>) -> Result<(), Status> {
    if bytes.is_some_and(|b| isize::try_from(b).is_ok()) {
        Ok(())
    } else {
        Err(Status::OutOfDomain)
    }
}

/// Whether values in a row can lie at an address.
#[cfg_attr(target_arch = "arm", inline(never))]
#[cfg_attr(not(target_arch = "arm"), inline(always))]
fn check_extent(address: usize, align: usize, count: usize, size: usize) -> Result<(), Status> {
    check_address(address, align)?;
    in_memory(count.checked_mul(size))
}

/// Storage of C for a law.
pub(super) trait Storage: Sized {
    type Law: Copy;
    /// What the storage begins with once there is a law in it.
    const MARK: u32;
}

/// What lies in the storage.
#[repr(C)]
struct Marked<L> {
    mark: u32,
    law: L,
}

/// Puts a law in its storage, or marks that as empty.
pub(super) unsafe fn store<S: Storage>(p: *mut S, law: Result<S::Law, Status>) -> Status {
    const {
        assert!(size_of::<Marked<S::Law>>() <= size_of::<S>(), "the header gives too little room");
        assert!(align_of::<Marked<S::Law>>() <= align_of::<S>(), "the header aligns too little");
    }
    if let Err(e) = check(p) {
        return e;
    }
    match law {
        Ok(law) => {
            // SAFETY: aligned, large enough, and by the caller's promise writable
            unsafe { p.cast::<Marked<S::Law>>().write(Marked { mark: S::MARK, law }) };
            Status::Ok
        }
        Err(e) => {
            // SAFETY: as above; the mark is its first word
            unsafe { p.cast::<u32>().write(0) };
            e
        }
    }
}

/// Puts the beginning of a law in its storage, which counts as empty until [`finish`].
#[inline(always)]
pub(super) unsafe fn begin<'a, S: Storage>(p: *mut S, law: S::Law) -> &'a mut S::Law {
    let marked = p.cast::<Marked<S::Law>>();
    // SAFETY: the caller has checked the pointer; large enough as `store` asserts, and by the promise writable
    unsafe {
        marked.write(Marked { mark: 0, law });
        &mut (*marked).law
    }
}

/// Marks a storage as one that holds a law.
pub(super) unsafe fn finish<S: Storage>(p: *mut S) {
    // SAFETY: the mark is the first word of any storage
    unsafe { p.cast::<u32>().write(S::MARK) };
}

/// The law in a storage.
pub(super) unsafe fn stored<'a, S: Storage>(p: *const S) -> Result<&'a S::Law, Status> {
    check(p)?;
    // SAFETY: aligned, by the caller's promise readable, and the mark is the first word of any storage
    let mark = unsafe { p.cast::<u32>().read() };
    if mark != S::MARK {
        return Err(Status::NotInitialised);
    }
    // SAFETY: the mark is written with a law and by nothing else
    Ok(unsafe { &(*p.cast::<Marked<S::Law>>()).law })
}

/// A value for a pair of directions; NaN with the reason if either is none. In line, so that each function holds the
/// code of its own quantity only.
#[inline(always)]
pub(super) unsafe fn value<S: Storage<Law: Law>>(
    p: *const S,
    what: Quantity,
    wi: *const f32,
    wo: *const f32,
    out: *mut f32,
) -> Status {
    // SAFETY: the caller's promise, handed on
    let law = match unsafe { stored(p) } {
        Ok(law) => law,
        Err(e) => return e,
    };
    // SAFETY: as above
    unsafe { pairs(law, what, 1, (wi, 0), (wo, 0), out) }
}

/// Values of a batch; those of bad pairs are NaN, and the first reason is the answer.
pub(super) unsafe fn values<S: Storage<Law: Law>>(
    p: *const S,
    what: u32,
    count: usize,
    wi: (*const f32, usize),
    wo: (*const f32, usize),
    out: *mut f32,
) -> Status {
    // SAFETY: the caller's promise, handed on
    let law = unsafe { stored(p) };
    match (law, options::quantity(what)) {
        (Ok(_), Ok(_)) if count == 0 => Status::Ok,
        // SAFETY: as above; a constant quantity makes each loop one of its own
        (Ok(law), Ok(what)) => unsafe { pairs(law, what, count, wi, wo, out) },
        (Err(e), _) | (_, Err(e)) => e,
    }
}

#[inline(always)]
unsafe fn pairs(
    law: &impl Law,
    what: Quantity,
    count: usize,
    (wi, wi_stride): (*const f32, usize),
    (wo, wo_stride): (*const f32, usize),
    out: *mut f32,
) -> Status {
    let fine = check(wi).and(check(wo)).and(check(out.cast_const()));
    let fits = extent::<f32>(count, wi_stride.max(3)).and(extent::<f32>(count, wo_stride.max(3)));
    if let Err(e) = fine.and(fits) {
        return e;
    }
    let mut status = Status::Ok;
    for k in 0..count {
        // SAFETY: checked above, and by the caller's promise that far in its memory
        let value = unsafe {
            evaluate(law, what, vector(wi.add(k * wi_stride)), vector(wo.add(k * wo_stride)))
        };
        let value = value.unwrap_or_else(|e| {
            if status == Status::Ok {
                status = e;
            }
            f32::NAN
        });
        // SAFETY: as above
        unsafe { out.add(k).write(value) };
    }
    status
}

/// Three floats.
#[inline(always)]
unsafe fn vector(p: *const f32) -> [f32; 3] {
    // SAFETY: the caller has checked it
    unsafe { p.cast::<[f32; 3]>().read() }
}

/// Draws rays of one direction of incidence.
pub(super) unsafe fn rays<S: Storage<Law: Law>>(
    p: *const S,
    count: usize,
    wi: *const f32,
    uniform: AsperityUniform,
    state: *mut c_void,
    out: *mut AsperityRay,
) -> Status {
    let run = || -> Result<(), Status> {
        // SAFETY: the caller's promise, handed on
        let law = unsafe { stored(p) }?;
        let uniform = uniform.ok_or(Status::NullPointer)?;
        // SAFETY: as above
        let wi = direction(unsafe { read(wi.cast::<[f32; 3]>()) }?)?;
        check(out.cast_const())?;
        extent::<AsperityRay>(count, 1)?;
        let mut fine = true;
        for k in 0..count {
            let ray = law.draw(wi, &mut || {
                // SAFETY: a function of the caller with the state it wants
                let u = unsafe { uniform(state) };
                let inside = (0.0..1.0).contains(&u);
                fine &= inside;
                if inside { u } else { 0.0 }
            });
            // SAFETY: checked above, and by the caller's promise that far in its memory
            unsafe { out.add(k).write(ray) };
        }
        if fine { Ok(()) } else { Err(Status::OutOfDomain) }
    };
    run().err().unwrap_or(Status::Ok)
}
