//! Prints the flux of every incidence of a file of scatter: `cargo run --example inspect -- FILE`.
#![allow(clippy::print_stdout, reason = "the result of an example")]

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args_os().nth(1).ok_or("give a file of scatter")?;
    let (format, lobes) = asperity_exchange::read(path.as_ref())?;
    println!("{}", format.title);
    for lobe in &lobes {
        println!("{} from {}, {:?}", lobe.lobe.name(), lobe.side.name(), lobe.bands);
        for (k, incidence) in lobe.incidences.iter().enumerate() {
            let (degrees, flux) = (incidence.theta.to_degrees(), lobe.flux(k, 0));
            println!("  {degrees:6.2} deg: flux {flux:.5}, stated {:?}", incidence.stated);
        }
    }
    Ok(())
}
