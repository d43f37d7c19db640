//! What a call came to.

use core::ffi::CStr;

use asperity_core::quantity::QuantityError;
use asperity_core::table::TableError;

/// What a call came to; 0 is success.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AsperityStatus {
    /// All is well.
    Ok = 0,
    /// A pointer that must not be null is.
    NullPointer = 1,
    /// A pointer is not aligned to what it points to.
    Misaligned = 2,
    /// The object was never initialised, or not with success, or is of another kind.
    NotInitialised = 3,
    /// A number is NaN or infinite.
    NotFinite = 4,
    /// A direction has no length.
    ZeroVector = 5,
    /// A number is outside its domain.
    OutOfDomain = 6,
    /// An option has no such value, or this library was built without it.
    UnknownOption = 7,
    /// An axis of a table has fewer than two nodes, or more than a table can have.
    TableShape = 8,
    /// An array of a table, or its payload, has another length than its axes ask for.
    TableLength = 9,
    /// A number of a table is outside its domain.
    TableNumber = 10,
    /// Quantiles of a table do not ascend from 0, or a lean is beyond 125/128.
    TableQuantiles = 11,
    /// A table reflects and transmits more light than there is.
    TableEnergy = 12,
    /// The checksum of a table is another: a bit of its numbers or arrays is not what it was.
    TableChecksum = 13,
    /// A table of an opaque body that does more than reflect light from the air.
    TableOpaque = 14,
}

/// All of them with their texts, in the order of their numbers.
const TEXTS: [(AsperityStatus, &CStr); 15] = [
    (AsperityStatus::Ok, c"all is well"),
    (AsperityStatus::NullPointer, c"a pointer is null"),
    (AsperityStatus::Misaligned, c"a pointer is not aligned"),
    (AsperityStatus::NotInitialised, c"the object is not initialised"),
    (AsperityStatus::NotFinite, c"a number is NaN or infinite"),
    (AsperityStatus::ZeroVector, c"a direction has no length"),
    (AsperityStatus::OutOfDomain, c"a number is outside its domain"),
    (AsperityStatus::UnknownOption, c"an option is unknown, or was left out of this build"),
    (AsperityStatus::TableShape, c"an axis of the table has too few or too many nodes"),
    (
        AsperityStatus::TableLength,
        c"an array of the table has another length than its axes ask for",
    ),
    (AsperityStatus::TableNumber, c"a number of the table is outside its domain"),
    (
        AsperityStatus::TableQuantiles,
        c"quantiles of the table do not ascend, or a lean is too large",
    ),
    (AsperityStatus::TableEnergy, c"the table gives more light than it receives"),
    (AsperityStatus::TableChecksum, c"the table is damaged: its checksum is another"),
    (
        AsperityStatus::TableOpaque,
        c"the table of an opaque body does more than reflect light from the air",
    ),
];

/// One line of English for a status, also for a number that is none.
pub fn text(status: i32) -> &'static CStr {
    TEXTS.iter().find(|(known, _)| *known as i32 == status).map_or(c"no such status", |(_, t)| t)
}

impl From<QuantityError> for AsperityStatus {
    fn from(error: QuantityError) -> Self {
        if error == QuantityError::NotFinite { Self::NotFinite } else { Self::OutOfDomain }
    }
}

impl From<TableError> for AsperityStatus {
    fn from(error: TableError) -> Self {
        match error {
            TableError::Shape => Self::TableShape,
            TableError::Length => Self::TableLength,
            TableError::Quantiles => Self::TableQuantiles,
            TableError::Energy => Self::TableEnergy,
            TableError::Checksum => Self::TableChecksum,
            TableError::Opaque => Self::TableOpaque,
            _ => Self::TableNumber,
        }
    }
}
