//! The graph convolutional network: Φ(X) = softmax(T̂ relu(T̂X W0 + b0) W1 + b1) (source paper, "Sparse Reward
//! Propagation for Deep Reinforcement Learning", eq. 5; Kipf & Welling, ICLR 2017).
//!
//! | symbol | what | shape | where |
//! |---|---|---|---|
//! | A | symmetric adjacency | n × n | [`SymmetricCsr`](crate::graph::SymmetricCsr) |
//! | T̂ | D̃^-1/2 (A + I) D̃^-1/2 | n × n | [`Propagation`] |
//! | X | features, here proto-value functions | n × features | the caller's |
//! | W0, b0, W1, b1 | parameters | features × hidden, hidden, hidden × outputs, outputs | [`GcnParameters`] |
//! | Z | linear output | n × outputs | [`Gcn::forward`] |
//! | P | class probabilities softmax(Z) | n × classes | [`ClassifierLoss`] |
//!
//! loss = −(1/|Y|) Σ_{(i,c) ∈ Y} ln P_ic + (λ/|E|) · ½ tr(PᵀLP), with L = D − A and Y the labelled nodes.
//!
//! Two ways in: [`fit_classifier`] fits the loss above; [`Gcn::forward`], [`Gcn::backward`] and [`Adam`] serve
//! any other loss of Z, whose gradient the caller brings. Gradients are written by hand. Results are the same bits
//! at any number of threads.
//!
//! ```
//! use eigentrail::gcn::{Adam, Gcn, GcnParams, Propagation, fit_classifier};
//! use eigentrail::graph::SymmetricCsr;
//! use eigentrail::seeds::{Stream, stream};
//! use faer::Mat;
//!
//! // A path 0 – 1 – 2; node 2 is rewarding (class 1), node 0 is not (class 0).
//! let mut edges = sprs::TriMatI::<f64, u32>::new((3, 3));
//! for (i, j) in [(0, 1), (1, 0), (1, 2), (2, 1)] {
//!     edges.add_triplet(i, j, 1.0);
//! }
//! let adjacency = SymmetricCsr::new(edges.to_csr())?;
//! let features = Mat::from_fn(3, 1, |i, _| i as f64 - 1.0);
//!
//! let params = GcnParams::default();
//! let mut gcn = Gcn::new(1, params.hidden_dim, 2, true, &mut stream(0, Stream::Gcn));
//! let mut adam = Adam::new(&gcn, params.learning_rate);
//! let propagation = Propagation::new(&adjacency);
//! let labels = [(0, 0), (2, 1)];
//! let (probabilities, statistics) = fit_classifier(
//!     &mut gcn, &mut adam, &propagation, &adjacency, features.as_ref(), &labels, &params,
//! )?;
//! assert!(statistics.loss < statistics.initial_loss);
//! assert!(probabilities[(2, 1)] > probabilities[(0, 1)]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adam;
mod dense;
mod error;
mod fit;
mod layer;
mod loss;
mod model;
mod parameters;
mod params;
mod propagation;
mod rows;
mod smoothness;
mod workspace;

pub use adam::Adam;
pub use error::GcnError;
pub use fit::{FitStatistics, fit_classifier};
pub use layer::GraphConv;
pub use loss::{ClassifierLoss, LossWorkspace};
pub use model::Gcn;
pub use parameters::{GcnGradient, GcnParameters};
pub use params::GcnParams;
pub use propagation::Propagation;
pub(crate) use smoothness::Smoothness;
pub use workspace::GcnWorkspace;
