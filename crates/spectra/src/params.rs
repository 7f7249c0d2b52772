//! The parameters of an eigensolve, with their defaults and one check.

use crate::ParameterError;

/// Which Laplacian of the adjacency W, with degrees D.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
pub enum LaplacianKind {
    /// L_sym = I − D^-1/2 W D^-1/2; the row of an isolated node is 0.
    #[default]
    Normalized,
    /// L = D − W.
    Combinatorial,
}

/// How a refresh finds the pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
pub enum Method {
    /// From the previous vectors, extended to the new nodes.
    #[default]
    Warm,
    /// From random vectors every time.
    Cold,
    /// Dense, all n pairs, k kept: O(n³) time, O(n²) memory. The yardstick.
    Full,
}

/// Parameters of an eigensolve.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields, rename_all = "snake_case")
)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
pub struct SpectralParams {
    /// k, how many of the lowest pairs to keep; 1 to 65 536. A graph of fewer nodes has fewer.
    pub num_eigenpairs: usize,
    /// Largest residual ‖Lv − λv‖₂ of a unit vector v, relative to λ_k; in (0, 1). Eigenvalues come
    /// out accurate to tol² relative to λ_k: 1e-2 serves as features, 1e-3 gives six digits.
    pub tol: f64,
    /// Which Laplacian.
    pub laplacian: LaplacianKind,
    /// How a refresh finds the pairs.
    pub method: Method,
    /// In how many parts to split products with blocks; 1 to 1024. They run on the rayon pool in
    /// which the solver is called. The result does not depend on it.
    pub threads: usize,
    /// Whether to prove by an inertia count (Sylvester's law) that no pair was missed, and to
    /// search again where one was. Costs one more sparse factorisation per refresh.
    pub certify: bool,
    /// Rayleigh–Ritz steps after which a solve gives up and returns the best it has; 1 to 100 000.
    pub max_restarts: usize,
}

impl Default for SpectralParams {
    fn default() -> Self {
        Self {
            num_eigenpairs: 16,
            tol: 1e-2,
            laplacian: LaplacianKind::default(),
            method: Method::default(),
            threads: 1,
            certify: false,
            max_restarts: 60,
        }
    }
}

impl SpectralParams {
    /// Checks every range once.
    ///
    /// # Errors
    /// The first parameter that is out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        within("num_eigenpairs", self.num_eigenpairs, 65_536, "1 to 65536")?;
        within("threads", self.threads, 1024, "1 to 1024")?;
        within("max_restarts", self.max_restarts, 100_000, "1 to 100000")?;
        if self.tol > 0.0 && self.tol < 1.0 {
            return Ok(());
        }
        Err(ParameterError {
            name: "tol",
            value: self.tol.to_string(),
            rule: "above 0 and below 1",
        })
    }
}

/// At least 1 and at most `most`: beyond that lies no experiment, only a slip of the pen that takes all memory or for
/// ever.
fn within(
    name: &'static str,
    value: usize,
    most: usize,
    rule: &'static str,
) -> Result<(), ParameterError> {
    if (1..=most).contains(&value) {
        return Ok(());
    }
    Err(ParameterError {
        name,
        value: value.to_string(),
        rule,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_each_range_is_checked() {
        assert_eq!(SpectralParams::default().validate(), Ok(()));
        type Change = fn(&mut SpectralParams);
        let broken: [(&str, Change); 9] = [
            ("num_eigenpairs", |p| p.num_eigenpairs = 1 << 32),
            ("threads", |p| p.threads = usize::MAX),
            ("max_restarts", |p| p.max_restarts = 100_001),
            ("num_eigenpairs", |p| p.num_eigenpairs = 0),
            ("threads", |p| p.threads = 0),
            ("max_restarts", |p| p.max_restarts = 0),
            ("tol", |p| p.tol = 0.0),
            ("tol", |p| p.tol = 1.0),
            ("tol", |p| p.tol = f64::NAN),
        ];
        for (expected, break_it) in broken {
            let mut params = SpectralParams::default();
            break_it(&mut params);
            assert_eq!(params.validate().unwrap_err().name, expected);
        }
    }
}
