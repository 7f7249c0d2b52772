//! The sources that are in use, brought up to date together.

use super::{
    DeepWalk, DeepWalkParams, EmbeddingRefresh, FeatureError, FeatureSource, RandomFeatures,
};
use crate::graph::SymmetricCsr;
use crate::spectral::{ProtoValueFunctions, SpectralParams, SpectrumRefresh};
use faer::MatRef;
use serde::{Deserialize, Serialize};

/// Statistics of a refresh, of the sources that have any.
#[derive(Clone, Debug, Default)]
pub struct FeatureRefresh {
    /// The eigensolver, if eigenvectors are in use.
    pub spectrum: Option<SpectrumRefresh>,
    /// The skip-gram training, if walks are in use.
    pub embedding: Option<EmbeddingRefresh>,
}

/// Features from every source that somebody uses. Sources that nobody uses cost nothing. A plain value: written down with
/// serde and read back, it continues exactly where it was.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FeatureSet {
    used: Vec<FeatureSource>,
    spectrum: ProtoValueFunctions,
    deepwalk: DeepWalk,
    random: RandomFeatures,
}

impl FeatureSet {
    /// Nothing yet. `random` is as wide as there are eigenvectors, so that the two can be compared.
    pub fn new(
        used: &[FeatureSource],
        spectral: &SpectralParams,
        deepwalk: &DeepWalkParams,
        seed: u64,
    ) -> Self {
        Self {
            used: used.to_vec(),
            spectrum: ProtoValueFunctions::new(spectral.clone(), seed),
            deepwalk: DeepWalk::new(deepwalk.clone(), seed),
            random: RandomFeatures::new(spectral.num_eigenpairs, seed),
        }
    }

    /// Whether anything has to be refreshed as the graph grows.
    pub fn changes(&self) -> bool {
        self.used.iter().any(|s| *s != FeatureSource::Constant)
    }

    /// Brings the sources in use up to date with a graph that has grown since the last call (rows only appended).
    ///
    /// # Errors
    /// As [`ProtoValueFunctions::refresh`] and [`DeepWalk::refresh`].
    ///
    /// # Panics
    /// If the graph has shrunk.
    pub fn refresh(&mut self, adjacency: &SymmetricCsr) -> Result<FeatureRefresh, FeatureError> {
        let uses = |source| self.used.contains(&source);
        let mut refresh = FeatureRefresh::default();
        if uses(FeatureSource::Random) {
            self.random.grow(adjacency.num_nodes());
        }
        if uses(FeatureSource::Deepwalk) {
            refresh.embedding = Some(self.deepwalk.refresh(adjacency)?);
        }
        if uses(FeatureSource::Pvf) {
            refresh.spectrum = Some(self.spectrum.refresh(adjacency)?);
        }
        Ok(refresh)
    }

    /// The rows of a source as of the last refresh, entries of order 1. `None` for a source that is not in use or
    /// not refreshed yet, and for `constant`: whoever fits on features takes none as one constant column.
    pub fn get(&self, source: FeatureSource) -> Option<MatRef<'_, f64>> {
        if !self.used.contains(&source) {
            return None;
        }
        match source {
            FeatureSource::Pvf => self.spectrum.features(),
            FeatureSource::Deepwalk => self.deepwalk.features(),
            FeatureSource::Random => Some(self.random.features()),
            FeatureSource::Constant => None,
        }
    }

    /// The proto-value functions; without pairs unless `pvf` is in use.
    pub fn spectrum(&self) -> &ProtoValueFunctions {
        &self.spectrum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::deepwalk::testing::two_cliques;
    use eigentrail_testing::graphs;

    fn read_back(set: &FeatureSet) -> FeatureSet {
        postcard::from_bytes(&postcard::to_stdvec(set).unwrap()).unwrap()
    }

    /// Written down and read back between refreshes of a graph that grows, every source goes on to the same bits.
    #[test]
    fn features_read_back_go_on_to_the_same_bits() {
        let whole = graphs::discovered(&graphs::maze(12, 12, 0.1, 1), 2);
        let whole = SymmetricCsr::new(whole).unwrap();
        let bits = |set: &FeatureSet| {
            let entries = |x: MatRef<'_, f64>| -> Vec<u64> {
                let columns = x.col_iter().flat_map(|column| column.iter());
                columns.map(|value| value.to_bits()).collect()
            };
            FeatureSource::ALL.map(|source| set.get(source).map(entries))
        };
        let mut kept = FeatureSet::new(
            &FeatureSource::ALL,
            &Default::default(),
            &Default::default(),
            1,
        );
        let mut read = read_back(&kept);
        for nodes in [1, 20, 90, whole.num_nodes()] {
            let graph = whole.leading_block(nodes);
            kept.refresh(&graph).unwrap();
            read.refresh(&graph).unwrap();
            assert!(bits(&kept)[..3].iter().all(Option::is_some));
            assert!(bits(&read) == bits(&kept), "{nodes} nodes");
            read = read_back(&read);
            assert!(bits(&read) == bits(&kept), "before the next refresh, too");
        }
    }

    #[test]
    fn only_what_is_in_use_is_there() {
        let graph = two_cliques(4);
        let make = |used: &[FeatureSource]| {
            FeatureSet::new(used, &Default::default(), &Default::default(), 1)
        };
        let mut none = make(&[FeatureSource::Constant]);
        assert!(!none.changes());
        none.refresh(&graph).unwrap();
        assert!(FeatureSource::ALL.iter().all(|&s| none.get(s).is_none()));

        let mut two = make(&[FeatureSource::Deepwalk, FeatureSource::Random]);
        assert!(two.changes() && two.get(FeatureSource::Deepwalk).is_none());
        let refresh = two.refresh(&graph).unwrap();
        assert!(refresh.spectrum.is_none() && refresh.embedding.is_some());
        assert!(two.get(FeatureSource::Pvf).is_none());
        for source in [FeatureSource::Deepwalk, FeatureSource::Random] {
            assert_eq!(two.get(source).unwrap().shape(), (8, 16));
        }
    }
}
