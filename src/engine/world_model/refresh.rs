//! Features and potential, brought up to date when the schedule says so and there is somebody to use them.

use super::WorldModel;
use crate::engine::error::PipelineError;
use crate::engine::record::RefreshRecord;
use crate::engine::schedule::Moment;
use crate::exploration::Destination;
use crate::graph::SymmetricCsr;
use crate::shaping::PotentialInputs;
use faer::Mat;
use std::hash::Hash;
use std::time::Instant;
use tracing::trace_span;

impl<S: Clone + Eq + Hash> WorldModel<S> {
    fn moment(&self) -> Moment {
        let graph = self.graph.transitions();
        Moment {
            step: self.step,
            nodes: graph.num_states(),
            edges: graph.adjacency().num_edges(),
            pairs_tried: self.pairs_tried,
        }
    }

    /// Brings up to date what is due; none if nothing was. `episode_over`: this is the last step of an episode.
    #[inline]
    pub(in crate::engine) fn refresh_if_due(
        &mut self,
        episode_over: bool,
    ) -> Result<Option<Box<RefreshRecord>>, PipelineError> {
        let now = self.moment();
        let fit_due = self.is_worth_fitting() && self.schedule.fit_due(now, episode_over);
        let features_due = self.features_due(now);
        match features_due || fit_due {
            true => self.refresh(now, features_due, fit_due).map(Some),
            false => Ok(None),
        }
    }

    /// Brings the features up to date although the schedule does not ask for it; none if nobody uses them, or there are
    /// fewer than two states.
    ///
    /// # Errors
    /// If they cannot be computed; the last ones are then still there.
    pub fn refresh_features(&mut self) -> Result<Option<Box<RefreshRecord>>, PipelineError> {
        let now = self.moment();
        match self.features.changes() && now.nodes > 1 {
            true => self.refresh(now, true, false).map(Some),
            false => Ok(None),
        }
    }

    /// The same, and fits the potential anew once there is something to fit it on. Walkers under way are paid by the new φ
    /// from their next step on.
    ///
    /// # Errors
    /// As [`refresh_features`](Self::refresh_features), or if the potential cannot be fitted; φ is then as it was.
    pub fn refit(&mut self) -> Result<Option<Box<RefreshRecord>>, PipelineError> {
        let now = self.moment();
        let features = self.features.changes() && now.nodes > 1;
        let fit = self.is_worth_fitting();
        match features || fit {
            true => self.refresh(now, features, fit).map(Some),
            false => Ok(None),
        }
    }

    /// φ is 0 before the first goal; one made of returns, before the first end or the first step that paid.
    pub(super) fn is_worth_fitting(&self) -> bool {
        !self.goals.is_empty() || self.model.is_made_of_returns() && self.goals.returns_differ()
    }

    /// Apart from the question whether anything is due, which every step asks.
    #[cold]
    fn refresh(
        &mut self,
        now: Moment,
        features_due: bool,
        fit_due: bool,
    ) -> Result<Box<RefreshRecord>, PipelineError> {
        let adjacency = self.graph.transitions().adjacency().to_csr();
        let mut record = RefreshRecord::at(now);
        if features_due {
            let _span =
                trace_span!("spectrum_refresh", step = self.step, nodes = now.nodes).entered();
            let begin = Instant::now();
            let refresh = self.features.refresh(&adjacency)?;
            record.spectrum = refresh.spectrum;
            record.embedding = refresh.embedding;
            record.spectrum_seconds = begin.elapsed().as_secs_f64();
            self.schedule.features_refreshed(now);
        }
        if fit_due {
            let _span = trace_span!("gcn_fit", step = self.step, nodes = now.nodes).entered();
            let begin = Instant::now();
            self.fit(&adjacency, &mut record)?;
            record.fit_seconds = begin.elapsed().as_secs_f64();
            self.schedule.fitted(now);
        }
        Ok(Box::new(record))
    }

    /// An agent acts on its features, the potential only takes them for a cost that it smooths.
    fn features_due(&self, now: Moment) -> bool {
        self.features.changes()
            && match self.agent_features {
                Some(_) => self.schedule.agent_features_due(now),
                None => self.schedule.potential_features_due(now),
            }
    }

    fn fit(
        &mut self,
        adjacency: &SymmetricCsr,
        record: &mut RefreshRecord,
    ) -> Result<(), PipelineError> {
        let nothing = Mat::zeros(0, 0);
        let handicaps = self.goals.handicaps();
        let returns = self.returns.as_ref().map(|returns| returns.means());
        let returns = returns.unwrap_or_default();
        let inputs = PotentialInputs {
            graph: self.graph.transitions(),
            adjacency,
            goals: self.goals.goals(),
            ends: self.goals.ends(),
            returns: &returns,
            gamma: self.gamma,
            labels: self.goals.labels(),
            features: self
                .features
                .get(self.gcn_features)
                .unwrap_or(nothing.as_ref()),
        };
        let fit = self.model.fit(&inputs)?;
        self.table.replace(&fit)?;
        record.fit = Some(fit);
        if let Some(exploration) = &mut self.exploration
            && !self.goals.is_empty()
        {
            let destinations: Vec<_> = handicaps
                .into_iter()
                .map(|(state, handicap)| Destination { state, handicap })
                .collect();
            let graph = self.graph.transitions();
            exploration.set_goals_pay(self.goals.pays());
            exploration.set_returns(graph, self.goals.best_reward(), self.goals.step_cost());
            exploration.set_destinations(graph, &destinations);
            self.unit = mean_rise(self.table.values(), exploration.eccentricity());
        }
        Ok(())
    }
}

/// Range of φ ÷ the hops of the farthest state: what one step towards the goal raises φ by. 1 for a flat φ, whose
/// differences are all 0 anyway.
fn mean_rise(values: &[f64], eccentricity: u32) -> f64 {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(*v), high.max(*v))
        });
    let range = high - low;
    if range > 0.0 && eccentricity > 0 {
        range / f64::from(eccentricity)
    } else {
        1.0
    }
}
