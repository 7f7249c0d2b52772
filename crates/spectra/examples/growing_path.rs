//! The four lowest eigenvalues of a path while it grows.

use eigentrail_spectra::{
    GrowingEigensolver, SpectralError, SpectralParams, SymmetricCsr, sprs::TriMatI,
};

fn main() -> Result<(), SpectralError> {
    let params = SpectralParams {
        num_eigenpairs: 4,
        ..Default::default()
    };
    let mut solver = GrowingEigensolver::new(params, 0);
    for n in [1000, 1100, 1200] {
        let mut path = TriMatI::<f64, u32>::new((n, n));
        (1..n).for_each(|i| path.add_triplet(i - 1, i, 1.0));
        (1..n).for_each(|i| path.add_triplet(i, i - 1, 1.0));
        let refresh = solver.refresh(&SymmetricCsr::new(path.to_csr())?)?;
        println!("{n} nodes: {:.6?}", refresh.eigenvalues);
    }
    Ok(())
}
