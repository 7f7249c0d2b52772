//! DeepWalk read back: what was written down must hang together before anything is trained on it.

use super::{DeepWalk, DeepWalkParams, SkipGram};
use crate::features::FeatureError;
use crate::spectral::plain;
use faer::Mat;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

/// The fields of [`DeepWalk`] as they were written.
#[derive(Deserialize)]
pub(super) struct Saved {
    params: DeepWalkParams,
    rng: ChaCha8Rng,
    model: SkipGram,
    row_lengths: Vec<usize>,
    #[serde(with = "plain::maybe_matrix")]
    features: Option<Mat<f64>>,
}

impl TryFrom<Saved> for DeepWalk {
    type Error = FeatureError;

    fn try_from(saved: Saved) -> Result<Self, FeatureError> {
        let (nodes, dimensions) = (saved.row_lengths.len(), saved.params.dimensions);
        let handed_out = saved.features.as_ref();
        let is_whole = saved.model.has_shape(nodes, dimensions)
            && handed_out.is_none_or(|x| x.nrows() <= nodes && x.ncols() == dimensions);
        if !is_whole {
            return Err(FeatureError::Saved);
        }
        Ok(Self {
            params: saved.params,
            rng: saved.rng,
            model: saved.model,
            row_lengths: saved.row_lengths,
            features: saved.features,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::two_cliques;
    use super::*;
    use serde_json::{Value, json};

    /// Vectors that a refresh has left infinite or no numbers are so afterwards, in any format.
    #[test]
    fn vectors_that_have_diverged_come_back_too() {
        let params = DeepWalkParams {
            learning_rate: 1e200,
            ..DeepWalkParams::default()
        };
        let mut deepwalk = DeepWalk::new(params, 1);
        assert!(deepwalk.refresh(&two_cliques(3)).is_err());
        let bits = |d: &DeepWalk| {
            d.model
                .centres()
                .iter()
                .map(|x| x.to_bits())
                .collect::<Vec<_>>()
        };
        assert!(deepwalk.model.centres().iter().any(|x| !x.is_finite()));
        let binary = postcard::to_stdvec(&deepwalk).unwrap();
        assert_eq!(
            bits(&postcard::from_bytes(&binary).unwrap()),
            bits(&deepwalk)
        );
        let text = serde_json::to_string(&deepwalk).unwrap();
        assert_eq!(bits(&serde_json::from_str(&text).unwrap()), bits(&deepwalk));
    }

    #[test]
    fn what_does_not_hang_together_is_refused() {
        let mut deepwalk = DeepWalk::new(DeepWalkParams::default(), 1);
        deepwalk.refresh(&two_cliques(3)).unwrap();
        let whole = serde_json::to_value(&deepwalk).unwrap();
        let is_refused = |damage: &dyn Fn(&mut Value)| {
            let mut damaged = whole.clone();
            damage(&mut damaged);
            serde_json::from_value::<DeepWalk>(damaged).is_err()
        };
        assert!(!is_refused(&|_| ()));
        assert!(is_refused(&|v| v["model"]["dimensions"] = json!(8)));
        assert!(is_refused(&|v| v["params"]["dimensions"] = json!(8)));
        assert!(is_refused(&|v| v["model"]["members"] = json!([])));
        assert!(is_refused(&|v| v["row_lengths"] = json!([1, 1])));
        assert!(is_refused(&|v| v["features"]["rows"] = json!(5)));
    }
}
