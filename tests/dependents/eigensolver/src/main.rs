//! What a user of the eigensolver alone writes.

use eigentrail_spectra::{GrowingEigensolver, SpectralError, SpectralParams, SymmetricCsr, sprs};

fn main() -> Result<(), SpectralError> {
    let mut solver = GrowingEigensolver::new(SpectralParams::default(), 0);
    let mut path = sprs::TriMatI::<f64, u32>::new((100, 100));
    (1..100).for_each(|i| path.add_triplet(i - 1, i, 1.0));
    (1..100).for_each(|i| path.add_triplet(i, i - 1, 1.0));
    let refresh = solver.refresh(&SymmetricCsr::new(path.to_csr())?)?;
    println!("{:.4?}", refresh.eigenvalues);
    Ok(())
}
