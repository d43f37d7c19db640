//! Limits of code for the device.

/// The most that code may take, in bytes or instructions: what the compiler that is asked for makes of it; a quarter more where
/// another one is set (`ASPERITY_DEVICE_ENV`).
pub fn limit(most: usize) -> usize {
    let another = std::env::var("ASPERITY_DEVICE_ENV").is_ok_and(|settings| !settings.is_empty());
    if another { most + most / 4 } else { most }
}
